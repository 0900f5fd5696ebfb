// A page in React: the component with listeners and a ref, and the element itself as JSX.

import type { FvvPlayer as FvvPlayerElement } from "@fvv/player";
import { FvvPlayer } from "@fvv/player/react";
import { useRef, useState } from "react";
import { createRoot } from "react-dom/client";

function Clip() {
  const player = useRef<FvvPlayerElement>(null);
  const [frame, setFrame] = useState(-1);
  const [source, setSource] = useState("");
  const [played, setPlayed] = useState(0);
  return (
    <>
      <FvvPlayer
        ref={player}
        src="clip.fvv"
        controls
        shadows={false}
        cameraOrbit="10deg auto auto"
        onFrameChange={() => setFrame(player.current!.currentFrame)}
        onCameraChange={({ detail }) => setSource(detail.source)}
        onPlay={() => setPlayed((count) => count + 1)}
      />
      <button onClick={() => player.current!.play()}>Play</button>
      <output>{`${frame} ${source} ${played} ${player.current?.shadows}`}</output>
      {/* @ts-expect-error there is no such ratio */}
      <FvvPlayer pixelRatio="best" hidden />
      <fvv-player
        src="clip.fvv"
        hidden
        onframechange={(event) => event.type}
        oncamera-change={({ detail }) => detail.source}
      />
    </>
  );
}

createRoot(document.getElementById("root")!).render(<Clip />);
