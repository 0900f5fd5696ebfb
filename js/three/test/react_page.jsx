// Clips as components of @react-three/fiber, for tests.

import { Fvv } from "@fvv/three/react";
import { Canvas, useThree } from "@react-three/fiber";
import { Component, StrictMode, Suspense, useEffect } from "react";
import { createRoot } from "react-dom/client";
import { WebGPURenderer } from "three/webgpu";

const decoderOptions = { worker: new URL("worker.js", import.meta.url) };
const log = (window.log = { waited: 0, frames: [], failed: null, clips: [], requests: 0 });

const plainFetch = window.fetch;
window.fetch = (...parameters) => {
  log.requests += String(parameters[0]?.url ?? parameters[0]).endsWith(".fvv");
  return plainFetch(...parameters);
};

class Boundary extends Component {
  state = { failed: false };
  static getDerivedStateFromError() {
    return { failed: true };
  }
  componentDidCatch(error) {
    log.failed = error.message;
  }
  render() {
    return this.state.failed ? null : this.props.children;
  }
}

function Waiting() {
  useEffect(() => void log.waited++, []);
  return null;
}
function Looking() {
  const { gl, scene, camera } = useThree();
  Object.assign(window, { gl, scene });
  useEffect(() => {
    camera.position.set(0, 1.4, 4);
    camera.lookAt(0, 1, 0);
  }, [camera]);
  return null;
}

/** clips: properties of each. */
function Page({ clips, kind }) {
  const gl =
    kind === "webgl"
      ? { preserveDrawingBuffer: true }
      : async (properties) => {
          const renderer = new WebGPURenderer({ ...properties, forceWebGL: true });
          await renderer.init();
          return renderer;
        };
  return (
    <StrictMode>
      <Canvas gl={gl}>
        <Looking />
        <Boundary>
          <Suspense fallback={<Waiting />}>
            {clips.map((properties, i) => (
              <Fvv
                key={i}
                {...properties}
                decoderOptions={decoderOptions}
                muted
                ref={(clip) => void (log.clips[i] = clip)}
                onFrame={({ number }) => log.frames.push(number)}
              />
            ))}
          </Suspense>
        </Boundary>
      </Canvas>
    </StrictMode>
  );
}

document.getElementById("root").style.height = "300px";
let root = null;
window.show = (clips, kind = "webgl") => {
  root ??= createRoot(document.getElementById("root"));
  root.render(<Page clips={clips} kind={kind} />);
};
window.unmount = () => {
  root.unmount();
  root = null;
};
/** Objects of the scene with a mesh of a clip. */
window.shown = () =>
  window.scene.children.filter(({ children }) => children.some(({ isMesh, visible }) => isMesh && visible)).length;
document.documentElement.dataset.ready = "";
