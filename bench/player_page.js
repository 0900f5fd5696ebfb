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

/**
 * Pictures per second of a player that plays and turns, at the resolution that it chooses: without the seconds that it needs to
 * choose. surfaceScale: the least that it has chosen.
 */
window.measureAuto = async (source, settleMs = 6000, ms = 6000) => {
  const player = new FvvPlayer();
  player.style.cssText = "width: 960px; height: 540px";
  document.body.append(player);
  Object.assign(player, { src: source, muted: true, loop: true });
  await new Promise((seen) => player.addEventListener("loadeddata", seen));
  player.play();
  const { eye, target } = player.getPose();
  const begins = performance.now();
  const turn = () => {
    const [sine, cosine] = [Math.sin, Math.cos].map((of) => of((performance.now() - begins) / 5000));
    const [x, , z] = eye.map((value, k) => value - target[k]);
    if (!player.isConnected) return;
    player.setPose({ eye: [target[0] + cosine * x - sine * z, eye[1], target[2] + sine * x + cosine * z] });
    requestAnimationFrame(turn);
  };
  turn();
  const rest = (ms) => new Promise((done) => setTimeout(done, ms));
  await rest(settleMs);
  const before = player.stats.drawnFrames;
  const began = performance.now();
  await rest(ms);
  const rate = (1000 * (player.stats.drawnFrames - before)) / (performance.now() - began);
  const { resolution } = player._stage;
  const found = { rate, ratio: resolution.ratio(1, true), surfaceScale: resolution.surfaceScale(true) };
  player.remove();
  return found;
};

const refreshed = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
const lumaOf = ({ data }) =>
  Float32Array.from({ length: data.length / 4 }, (_, i) => {
    const [r, g, b] = data.subarray(4 * i, 4 * i + 3);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  });
/** Variance of luma within a window above which it shows the scene; the sky is a smooth gradient. */
const TEXTURED = 4;
/**
 * Structural similarity of two pictures of one size: the mean over windows of 8 by 8 pixels at every fourth in which the second one
 * has texture.
 */
function likeness(one, other) {
  const WINDOW = 8;
  const [a, b] = [lumaOf(one), lumaOf(other)];
  let sum = 0;
  let count = 0;
  for (let top = 0; top + WINDOW <= one.height; top += 4)
    for (let left = 0; left + WINDOW <= one.width; left += 4) {
      const m = { a: 0, b: 0, aa: 0, bb: 0, ab: 0 };
      for (let y = top; y < top + WINDOW; y++)
        for (let x = left; x < left + WINDOW; x++) {
          const [u, v] = [a[y * one.width + x], b[y * one.width + x]];
          m.a += u;
          m.b += v;
          m.aa += u * u;
          m.bb += v * v;
          m.ab += u * v;
        }
      for (const name in m) m[name] /= WINDOW ** 2;
      if (m.bb - m.b ** 2 < TEXTURED) continue;
      const [c1, c2] = [(0.01 * 255) ** 2, (0.03 * 255) ** 2];
      const covariance = m.ab - m.a * m.b;
      const variances = m.aa - m.a ** 2 + m.bb - m.b ** 2;
      sum += ((2 * m.a * m.b + c1) * (2 * covariance + c2)) / ((m.a ** 2 + m.b ** 2 + c1) * (variances + c2));
      count++;
    }
  return sum / count;
}

/**
 * Of a stream with a ladder: milliseconds to its first frame, to the first picture that is seen and the rung of that, and how like
 * it is to the same view of the finest rung.
 */
window.measureGood = async (source) => {
  const player = new FvvPlayer();
  player.style.cssText = "width: 960px";
  document.body.append(player);
  const began = performance.now();
  const seen = new Promise((seen, failed) => {
    player.addEventListener("error", () => failed(new Error(player.error.message)));
    player.addEventListener("loadeddata", seen);
  });
  let coarseMs = null;
  player.addEventListener("loadedmetadata", () => (coarseMs = performance.now() - began));
  // What surrounds the surface has no rungs.
  Object.assign(player, { src: source, environment: false, grid: false });
  await seen;
  const ms = performance.now() - began;
  await refreshed();
  const first = player._stage.renderer.readPixels();
  const { playedRung: rung } = player;
  player.rung = 0;
  while (player.playedRung !== 0 || player._stage.busy) await refreshed();
  // The frame comes again after the rung was announced.
  await new Promise((done) => setTimeout(done, 1500));
  const ssim = likeness(first, player._stage.renderer.readPixels());
  player.remove();
  return { ms, coarseMs, rung, ssim };
};
document.documentElement.dataset.ready = "";
