// Runs in a browser: decodes every clip from every kind of source, in window and worker, and posts hashes.

import { createDecoder } from "../dist/index.js";

const hex = (buffer) => Array.from(new Uint8Array(buffer), (byte) => byte.toString(16).padStart(2, "0")).join("");
const sha256 = async (typed) => hex(await crypto.subtle.digest("SHA-256", typed));

const tileNumbers = ({ camera, source: s, destination: d }) => [
  camera,
  ...[s, d].flatMap(({ x, y, width, height }) => [x, y, width, height]),
];

async function hashes(frame) {
  const out = {};
  for (const mesh of frame.meshes)
    for (const name of ["lattice", "faces", "positions", "normals", "uvs", "colours"])
      if (mesh[name]) out[`${name} ${mesh.track}`] = await sha256(mesh[name]);
  for (const visibility of frame.visibility)
    for (const camera of visibility.cameras) out[`weights ${camera}`] = await sha256(visibility.weightsOf(camera));
  for (const { track, shows } of frame.configuration.videos)
    if (shows === "tiles")
      out[`tiles ${track}`] = await sha256(Uint32Array.from(frame.tiles(track).flatMap(tileNumbers)));
  for (const camera of frame.cameras) {
    if (!camera.calibrated) continue;
    const { fx, fy, cx, cy, skew, distortion, rMax, rotation, translation } = camera;
    const numbers = [fx, fy, cx, cy, skew, ...distortion, rMax, ...rotation, ...translation];
    out[`camera ${camera.id}`] = await sha256(Float64Array.from(numbers));
    const pixel = camera.project(0.25, 1, -0.5);
    if (pixel) out[`pixel ${camera.id}`] = await sha256(Float64Array.from(pixel));
  }
  const { threshold, depthBias, depthSlope, best, unseen, blend } = frame.configuration.texturing;
  out["texturing 0"] = await sha256(
    Float64Array.of(threshold, depthBias, depthSlope, best, unseen, blend === "paper" ? 1 : 0),
  );
  return out;
}

/** For some clips only, which are listed in the page's parameters. */
const more = {
  live: (name) => new URL(`/live/${name}`, location.href.replace("http", "ws")),
  segments: (name) => `/whole/${name}/manifest.json`,
};
const sources = {
  ...more,
  range: (name) => `/range/${name}`,
  whole: (name) => `/whole/${name}`,
  blob: async (name) => (await fetch(`/range/${name}`)).blob(),
  stream: async (name) => (await fetch(`/range/${name}`)).body,
  bytes: async (name) => new Uint8Array(await (await fetch(`/range/${name}`)).arrayBuffer()),
};

async function decode(name, kind, worker) {
  const decoder = await createDecoder({
    rung: 0,
    source: await sources[kind](name),
    worker: worker ? undefined : false,
  });
  const warnings = [];
  decoder.addEventListener("warning", (event) => warnings.push(event.detail.message));
  const frames = [];
  const pictures = [];
  for await (const frame of decoder) {
    frames.push(await hashes(frame));
    for (const { track, picture } of frame.pictures) {
      const late = picture.timestamp === undefined ? 0 : picture.timestamp - frame.seconds * 1e6;
      pictures.push({ track, late, width: picture.displayWidth ?? picture.width });
    }
    frame.close();
  }
  const { inWorker } = decoder;
  decoder.close();
  return { name, kind, worker, inWorker, frames, pictures, warnings };
}

async function pixels(image) {
  const bytes = new Uint8Array(image.allocationSize());
  await image.copyTo(bytes);
  return sha256(bytes);
}

/**
 * Plays a clip with groups of two frames: with all tracks, then with one track in the second group and all in the third.
 * Returns for each frame the tracks whose pictures are the same as with all tracks.
 */
async function reselect(name, worker) {
  const play = async (onFrame) => {
    const decoder = await createDecoder({ source: sources.range(name), queue: 1, worker: worker ? undefined : false });
    const frames = [];
    for await (const frame of decoder) {
      await onFrame?.(decoder, frame);
      const entries = frame.pictures.map(async ({ track, picture }) => [track, await pixels(picture)]);
      frames.push({ tracks: frame.tracks, pictures: Object.fromEntries(await Promise.all(entries)) });
      frame.close();
    }
    decoder.close();
    return frames;
  };
  const whole = await play();
  const [track] = Object.keys(whole[0].pictures).map(Number);
  const some = await play(async (decoder, { number }) => {
    if (number === 0) await decoder.select({ tracks: [track] });
    if (number === 2) await decoder.select({ tracks: null });
  });
  const different = new Set(whole.flatMap(({ pictures }) => Object.values(pictures))).size;
  const same = some.map(({ pictures }, i) =>
    Object.entries(pictures).map(([id, hash]) => hash === whole[i].pictures[id] && Number(id)),
  );
  return { worker, track, all: Object.keys(whole[0].pictures).map(Number), different, same };
}

/** Aborting while a frame is awaited ends the iteration. */
async function abort(worker) {
  const controller = new AbortController();
  const source = new ReadableStream({ pull: () => new Promise(() => {}) });
  const decoder = await createDecoder({ source, signal: controller.signal, worker: worker ? undefined : false });
  setTimeout(() => controller.abort(), 20);
  for await (const _ of decoder) throw new Error("there is no frame");
}

const violations = [];
addEventListener("securitypolicyviolation", (event) =>
  violations.push(`${event.violatedDirective} ${event.blockedURI}`),
);
const results = [];
try {
  const parameters = new URLSearchParams(location.search);
  const names = parameters.get("clips").split(",");
  const whole = new Set(parameters.get("more").split(","));
  for (const worker of [true, false])
    for (const name of names)
      for (const kind of Object.keys(sources))
        if (!more[kind] || whole.has(name)) results.push(await decode(name, kind, worker));
  const reselected = [];
  for (const worker of [true, false]) reselected.push(await reselect(parameters.get("reselect"), worker));
  await abort(true);
  await abort(false);
  await fetch("/result", { method: "POST", body: JSON.stringify({ results, reselected, violations }) });
} catch (error) {
  await fetch("/result", {
    method: "POST",
    body: JSON.stringify({ error: `${error.message}\n${error.stack}`, violations }),
  });
}
