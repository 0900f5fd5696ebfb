// What the tests share: tools of the native build, clips that they make, and what libfvv decodes of a file.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { build, root, toolPath } from "../../testing/served.mjs";
import { createDecoder } from "../dist/index.js";

function run(program, ...parameters) {
  const { status, stdout, stderr, error } = spawnSync(program, parameters, { maxBuffer: 2 ** 30 });
  if (error) throw error;
  if (status !== 0 && status !== 3) throw new Error(`${program} ${parameters.join(" ")}: ${status}\n${stderr}`);
  return stdout;
}
export const tool = (name, ...parameters) => run(toolPath(name), ...parameters);

const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

const known = new Map();

/** The frames as libfvv decodes them: maps from "lattice 1" and similar names to SHA-256. */
export function nativeFrames(file) {
  if (!known.has(file)) known.set(file, decodeNatively(file));
  return known.get(file);
}

/** Pairs of a name such as "lattice 1" and a hash. */
function* nativeItems(program, ...parameters) {
  const bytes = run(join(build, "tests/js", program), ...parameters);
  for (let at = 0; at < bytes.length;) {
    const line = bytes.indexOf(10, at);
    const [name, id, size] = bytes.toString("latin1", at, line).split(" ");
    at = line + 1 + Number(size);
    yield [`${name} ${id}`, sha256(bytes.subarray(line + 1, at))];
  }
}

function decodeNatively(file) {
  const frames = [];
  for (const [what, hash] of nativeItems("frame_bytes", file)) {
    if (what === "time 0") frames.push({});
    frames.at(-1)[what] = hash;
  }
  return frames;
}

/** The environment of the last group. */
export const nativeEnvironment = (file) => Object.fromEntries(nativeItems("frame_bytes", "--environment", file));

/** The track and the hash of the planes of every video picture, as the installed libavcodec decodes them. */
export const nativePictures = (file) =>
  Array.from(nativeItems("picture_bytes", file), ([name, hash]) => ({ track: Number(name.split(" ")[1]), hash }));

export function environmentHashes({ parts, pictures, lights }) {
  const hashes = {};
  parts.forEach((part, i) => {
    for (const name of ["positions", "faces", "uvs"])
      if (part[name]) hashes[`part-${name} ${i}`] = sha256(raw(part[name]));
  });
  pictures.forEach(({ data }, i) => (hashes[`picture ${i}`] = sha256(data)));
  lights.forEach((l, i) => {
    const { position, direction, colour, intensity, range, innerCone, outerCone } = l;
    const numbers = [...position, ...direction, ...colour, intensity, range, innerCone, outerCone];
    hashes[`light ${i}`] = sha256(raw(Float64Array.from(numbers)));
  });
  return hashes;
}

const raw = (typed) => new Uint8Array(typed.buffer, typed.byteOffset, typed.byteLength);

function cameraNumbers(camera) {
  const { fx, fy, cx, cy, skew, distortion, rMax, rotation, translation } = camera;
  return Float64Array.of(fx, fy, cx, cy, skew, ...distortion, rMax, ...rotation, ...translation);
}

function tileNumbers(tiles) {
  const rect = ({ x, y, width, height }) => [x, y, width, height];
  return Uint32Array.from(tiles.flatMap((tile) => [tile.camera, ...rect(tile.source), ...rect(tile.destination)]));
}

/** The same for a frame of the decoder under test. */
export function frameHashes(frame) {
  const hashes = { "time 0": sha256(raw(BigInt64Array.of(frame.time))) };
  const { threshold, depthBias, depthSlope, best, unseen, blend } = frame.configuration.texturing;
  hashes["texturing 0"] = sha256(
    raw(Float64Array.of(threshold, depthBias, depthSlope, best, unseen, blend === "paper" ? 1 : 0)),
  );
  for (const mesh of frame.meshes)
    for (const name of ["lattice", "faces", "positions", "normals", "uvs", "colours"])
      if (mesh[name]) hashes[`${name} ${mesh.track}`] = sha256(raw(mesh[name]));
  for (const visibility of frame.visibility)
    for (const camera of visibility.cameras) hashes[`weights ${camera}`] = sha256(visibility.weightsOf(camera));
  for (const sample of frame.samples) hashes[`${sample.key ? "key" : "sample"} ${sample.track}`] = sha256(sample.data);
  for (const { track, shows } of frame.configuration.videos)
    if (shows === "tiles" && frame.tiles(track).length)
      hashes[`tiles ${track}`] = sha256(raw(tileNumbers(frame.tiles(track))));
  for (const camera of frame.cameras) {
    if (!camera.calibrated) continue;
    hashes[`camera ${camera.id}`] = sha256(raw(cameraNumbers(camera)));
    const pixel = camera.project(0.25, 1, -0.5);
    if (pixel) hashes[`pixel ${camera.id}`] = sha256(raw(Float64Array.from(pixel)));
  }
  return hashes;
}

/** Cases with the streams of other writers, and the streams of pictures; conformance/run compares all cases. */
export function conformanceFiles() {
  const folder = join(root, "conformance");
  return readdirSync(folder, { recursive: true })
    .filter((name) => /^(render\/.*|cases\/valid\/vector_.*)\.fvv$/.test(name))
    .map((name) => join(folder, name))
    .sort();
}

/** Small clips of every kind but the ladder, whose rung depends on the network, or the named ones; done removes them. */
export function makeClips(...wanted) {
  const folder = mkdtempSync(join(tmpdir(), "fvv-js-"));
  const captures = new Map();
  const capture = (name, ...options) => {
    const path = join(folder, name);
    const size = options.includes("--size") ? [] : ["--size", "96x64"];
    if (!captures.has(name)) captures.set(name, tool("fvvsynth", "-o", path, "--frames", "5", ...size, ...options));
    return path;
  };
  const tracked = () =>
    capture("tracked", "--rig", "small", "--cameras", "2", "--atlas", "--atlas-size", "512", "--environment");
  const ring = () => capture("ring", "--rig", "small", "--cameras", "5", "--environment", "--size", "192x128");
  const slow = () => capture("slow", "--rig", "small", "--cameras", "5", "--size", "384x256", "--fps", "1");
  const studio = () => capture("studio", "--rig", "studio", "--meshes", "hull", "--hull-cells", "40");
  const texturing = [
    "--texture-threshold",
    "0.375",
    "--texture-best",
    "5",
    "--texture-unseen",
    "1,20,250",
    "--texture-blend",
    "paper",
  ];
  const kinds = {
    environment: [tracked, "--no-pictures"],
    delta: [tracked, "--triangles", "3000", "--no-environment"],
    raw: [tracked, "--no-delta", "--mesh-profile", "raw", "--codec", "jpeg", "--no-environment"],
    fast: [tracked, "--no-delta", "--mesh-profile", "fast", "--codec", "vp9", "--no-environment"],
    draco: [tracked, "--no-delta", "--no-pictures", "--no-environment"],
    moving: [studio, "--keep-geometry", ...texturing],
    hull: [studio, "--keep-geometry", "--no-pictures", "--no-environment", "--visibility", "none"],
    live: [studio, "--live", "--repeat-configuration"],
    // Samples large enough that leaving one out is worth a request.
    tracks: [ring, "--video-tracks", "camera", "--codec", "jpeg", "--group", "2", "--crop", "none"],
    neighbours: [ring, "--video-tracks", "3", "--group", "2"],
    // A frame a second: any link is fast enough. Every rung has meshes of its own, large enough to measure the link by.
    ladder: [
      slow,
      "--ladder",
      "1,0.5,0.25",
      "--mesh-ladder",
      "on",
      "--max-error",
      "0.03",
      "--group",
      "1",
      "--crop",
      "none",
      "--no-environment",
    ],
  };
  const clips = {};
  for (const [name, [source, ...options]] of Object.entries(kinds)) {
    if (wanted.length ? !wanted.includes(name) : name === "ladder") continue;
    clips[name] = join(folder, `${name}.fvv`);
    const quality = name === "tracks" ? "100" : options.includes("jpeg") ? "70" : "36dB";
    const group = options.includes("--group") ? [] : ["--group", "3"];
    tool("fvvmux", source(), "-o", clips[name], "--quality", quality, ...group, ...options);
  }
  return { clips, done: () => rmSync(folder, { recursive: true, force: true }) };
}

/** Plays to the end, from frame start on if given, and returns the environment, which has to be reported exactly once. */
export async function onlyEnvironment(source, start) {
  const decoder = await createDecoder({ source });
  let count = 0;
  decoder.addEventListener("environment", ({ detail }) => (count += detail.length));
  if (start) await decoder.seek({ frame: start });
  for await (const frame of decoder) frame.close();
  assert.equal(count, 1);
  decoder.close();
  return decoder.environments[0];
}
