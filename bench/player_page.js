// Runs in a browser for player.mjs: measures playback.

import { createDecoder } from "@fvv/decoder";
import { FvvPlayer, Renderer, viewFromPose } from "@fvv/player";

const SIZE = { width: 960, height: 540 };
/** Fraction of a turn between pictures. */
const TURN = 0.01;

/** A view on a circle around the scene that shows all of it. */
function viewAt(bounds, up, turns, size) {
  const centre = bounds.min.map((x, i) => (x + bounds.max[i]) / 2);
  const radius = Math.hypot(...bounds.min.map((x, i) => bounds.max[i] - x)) / 2;
  const angle = 2 * Math.PI * turns;
  const axis = "xyz".indexOf(up.at(-1));
  const sign = up.startsWith("-") ? -1 : 1;
  const eye = [...centre];
  eye[(axis + 1) % 3] += 2.2 * radius * Math.cos(angle);
  eye[(axis + 2) % 3] += 2.2 * radius * Math.sin(angle);
  eye[axis] += 0.5 * sign * radius;
  const upwards = [0, 0, 0].map((_, i) => (i === axis ? sign : 0));
  return viewFromPose({ eye, target: centre, up: upwards, fov: 46, ...size });
}

/** Waits until drawing has finished. */
function finish(gl) {
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
}

/** Shows and draws every frame of a file once, as fast as possible, from a moving viewpoint; then draws the last one N times. */
window.measureRate = async (source, visibleBy, size = SIZE) => {
  const canvas = document.body.appendChild(document.createElement("canvas"));
  const renderer = new Renderer(canvas);
  const gl = canvas.getContext("webgl2");
  const decoder = await createDecoder({
    source,
    worker: new URL("worker.js", import.meta.url),
  });
  let [began, count, up] = [0, 0, "y"];
  for await (const frame of decoder) {
    up = frame.configuration.upAxis;
    await renderer.show(frame);
    frame.close();
    renderer.draw(viewAt(renderer.bounds, up, TURN * count, size), { visibleBy });
    finish(gl);
    // Programs are compiled for the first one.
    if (count++ === 0) began = performance.now();
  }
  const playing = (1000 * (count - 1)) / (performance.now() - began);
  const orbiting = performance.now();
  for (let i = 0; i < count; i++) {
    renderer.draw(viewAt(renderer.bounds, up, TURN * i, size), { visibleBy });
    finish(gl);
  }
  const still = (1000 * count) / (performance.now() - orbiting);
  // Each method of clause 17.5 in turn, because other programs take time from all.
  const blendMs = { paper: [], viewer: [] };
  for (let i = 0; i < Math.max(10, count); i++) {
    for (const blend of Object.keys(blendMs)) {
      const start = performance.now();
      renderer.draw(viewAt(renderer.bounds, up, TURN * i, size), { visibleBy, blend });
      finish(gl);
      if (i > 0) blendMs[blend].push(performance.now() - start);
    }
  }
  const { counters } = renderer;
  renderer.close();
  decoder.close();
  canvas.remove();
  return { playing, still, blendMs, counters, frames: count };
};

/** Milliseconds from the source of a player to its first picture on screen. */
window.measureFirst = async (source) => {
  const player = new FvvPlayer();
  player.style.cssText = "width: 960px";
  document.body.append(player);
  const began = performance.now();
  const drawn = new Promise((seen, failed) => {
    player.addEventListener("error", () => failed(new Error(player.error.message)));
    const look = () => (player.stats.drawnFrames > 0 ? seen(performance.now()) : requestAnimationFrame(look));
    requestAnimationFrame(look);
  });
  player.src = source;
  const ms = (await drawn) - began;
  player.remove();
  return ms;
};
document.documentElement.dataset.ready = "";
