// A TypeScript program that uses the packages. tsc has to accept it and their declarations.

import { pick, rayThrough } from "@fvv/analysis";
import { FvvError, camerasFor, createDecoder } from "@fvv/decoder";
import type { Decoder, Frame, FvvEvent, Group } from "@fvv/decoder";
import { FvvPlayer } from "@fvv/player";
import { Renderer } from "@fvv/player/renderer";
import { viewFromCamera, viewFromPose } from "@fvv/player/view";
import { texturingOf, viewsOf } from "@fvv/shading";
import { FvvObject3D, lookThrough } from "@fvv/three";
import { FvvClip as NodeClip, FvvObject3D as NodeObject } from "@fvv/three/webgpu";
import { PerspectiveCamera, Scene, WebGLRenderer } from "three";
import { WebGPURenderer } from "three/webgpu";

async function open(url: string): Promise<Decoder> {
  const decoder = await createDecoder({
    source: { url, credentials: "include" },
    limits: { memory: 2 ** 28 },
    videoFallback: () => WebAssembly.compileStreaming(fetch("/video.wasm")),
    sound: "decoded",
    soundFallback: () => import("opus-decoder"),
  });
  const report = ({ detail }: FvvEvent<FvvError>): void => {
    if (detail.code === "gap") console.warn(detail.from, detail.to, detail.issue);
  };
  decoder.addEventListener("warning", report);
  decoder.addEventListener("configuration", ({ detail }) => console.log(detail.texturing.best, detail.cameras.length));
  decoder.removeEventListener("warning", report);
  decoder.addEventListener("configuration", { handleEvent() {} });
  decoder.addEventListener("sound", ({ detail }) => console.log(detail.track));
  FvvPlayer.decoderOptions = { soundFallback: () => import("opus-decoder") };
  // @ts-expect-error warnings have no cameras
  decoder.addEventListener("warning", ({ detail }) => detail.cameras);
  const groups: readonly Group[] = decoder.groups ?? [];
  const start: bigint | undefined = groups[0]?.start;
  if (start !== undefined) await decoder.seek({ time: start });
  await decoder.select({ tracks: null });
  const buffered: bigint = (await decoder.buffered()).reduce((sum, { start, end }) => sum + end - start, 0n);
  const { cachedBytes, cacheHits }: { cachedBytes: number; cacheHits: number } = await decoder.stats();
  console.log(buffered, cachedBytes, cacheHits);
  return decoder;
}

async function drawAll(decoder: Decoder, canvas: HTMLCanvasElement): Promise<void> {
  const renderer = new Renderer(canvas);
  const from = { eye: [0, 1, 3], target: [0, 1, 0], up: [0, 1, 0], fov: 40 } as const;
  for await (const frame of decoder) {
    await renderer.show(frame);
    const camera = frame.camera(0);
    const view = camera ? viewFromCamera(camera) : viewFromPose({ ...from, width: 640, height: 360 });
    renderer.draw(view, { threshold: 0.3, best: 2, unseen: 0x202020, cameras: new Set([0, 1]) });
    const { tolerance } = texturingOf(frame.configuration, { unseen: 0xff0000 });
    console.log(tolerance[0], viewsOf(frame, new Map()).length, camera?.project(0, 1, 2)?.[0]);
    frame.close();
  }
  // @ts-expect-error no such mode
  renderer.draw(viewFromPose({ ...from, width: 1, height: 1 }), { mode: "pretty" });
  renderer.close();
}

async function showWithNodes(frame: Frame, renderer: WebGPURenderer, viewer: PerspectiveCamera): Promise<boolean> {
  const object = new NodeObject({ renderer, blend: "paper" });
  // @ts-expect-error the renderer is of another kind
  new FvvObject3D({ renderer });
  const [camera] = frame.cameras;
  if (camera) lookThrough(viewer, camera, renderer);
  return object.show(frame);
}

async function showInScene(frame: Frame, renderer: WebGLRenderer): Promise<number | null> {
  const object = new FvvObject3D({ renderer, best: 2, threshold: 0.5, unseen: 0x336699 });
  const viewer = new PerspectiveCamera();
  new Scene().add(object.add(viewer));
  await object.show(frame);
  lookThrough(viewer, frame.cameras[0]);
  renderer.render(object, viewer);
  return object.frame && object.frame.number;
}

function touch(frame: Frame): number | null {
  const found = pick(frame, rayThrough(frame.cameras[0], 160, 90));
  const time: bigint | undefined = found?.time;
  console.log(time, found?.barycentric[2], found?.camera);
  // @ts-expect-error a ray has a direction
  pick(frame, { origin: [0, 0, 0] });
  return found && found.face;
}

async function playInScene(src: Blob, renderer: WebGPURenderer, scene: Scene): Promise<number> {
  const clip = new NodeClip({ src, renderer, loop: true, rung: 0 });
  scene.add(clip, clip.instance());
  clip.addEventListener("error", ({ error }) => console.error(error.message));
  clip.addEventListener("rungchange", ({ rung }) => console.log(rung.reason));
  // @ts-expect-error no such event
  clip.addEventListener("click", () => {});
  const { frameCount } = await clip.ready;
  clip.volume = 0.5;
  await clip.seek(1);
  return frameCount + clip.audio.length;
}

async function play(source: Blob): Promise<void> {
  const player: FvvPlayer = document.createElement("fvv-player");
  player.srcObject = source;
  player.viewMode = "weights";
  await player.play().catch((error: unknown) => {
    if (error instanceof FvvError) console.error(error.code, error.offset);
  });
  await player.setPose({ fov: 30 }, { duration: 1 });
  player.tools = "measure mark follow";
  await player.setMarks({
    fvv_marks: 1,
    marks: [
      {
        kind: "arrow",
        points: [
          [0, 0, 0],
          [1, 0, 0],
        ],
        from: 10,
      },
    ],
  });
  await player.follow("ball");
  console.log(player.measurements[0]?.value?.uncertainty, player.getMarks().marks.length);
  // @ts-expect-error no such kind
  await player.setMarks({ fvv_marks: 1, marks: [{ kind: "circle" }] });
  player.addEventListener("timeupdate", () => console.log(player.currentTime, player.stats.framesShown));
}

export { camerasFor, drawAll, open, play, playInScene, showInScene, showWithNodes, touch };
