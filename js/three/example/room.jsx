// A clip on the floor of the viewer's room, with @react-three/fiber and @react-three/xr. ?file=NAME.fvv selects the stream.

import { Fvv } from "@fvv/three/react";
import { Canvas } from "@react-three/fiber";
import { createXRStore, XR } from "@react-three/xr";
import { Suspense } from "react";
import { createRoot } from "react-dom/client";

const file = new URLSearchParams(location.search).get("file") ?? "players.fvv";
// Without models of controllers and hands, which come from another host.
const store = createXRStore({ emulate: false, controller: false, hand: false });

function Room() {
  return (
    <>
      <nav>
        <button onClick={() => store.enterAR()}>In this room</button>
        <button onClick={() => store.enterVR()}>In a headset</button>
      </nav>
      <Canvas camera={{ position: [0, 1.6, 3], fov: 45 }}>
        <XR store={store}>
          <Suspense fallback={null}>
            <Fvv src={file} loop autoPlay position={[0, 0, -2.5]} />
          </Suspense>
          <gridHelper args={[6, 12, "#4a525c", "#2a3038"]} />
        </XR>
      </Canvas>
    </>
  );
}

createRoot(document.getElementById("root")).render(<Room />);
