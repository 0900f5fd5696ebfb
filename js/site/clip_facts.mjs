// The facts of a clip for its page, from the output of fvvinfo.

import { readFileSync } from "node:fs";
import { basename } from "node:path";

const descriptions = JSON.parse(readFileSync(new URL("descriptions.json", import.meta.url), "utf8"));

function bytesByKind({ tracks, container_bytes: container }) {
  const kinds = new Map();
  for (const { kind, bytes } of tracks) kinds.set(kind, (kinds.get(kind) ?? 0) + bytes);
  return [...kinds, ["container", container]].map(([kind, bytes]) => ({ kind, bytes }));
}

/** null if the clip has no mesh. */
function meshOf({ tracks }) {
  const track = tracks.find(({ kind }) => kind === "mesh");
  if (!track) return null;
  return {
    triangles: track.mesh.triangles_sum / track.chunks,
    bytes: track.bytes,
    profiles: Object.keys(track.mesh.profiles),
  };
}

function picturesOf({ tracks }) {
  const { codec, width, height, shows } = tracks.find(({ kind }) => kind === "video")?.video ?? {};
  return codec ? { codec, width, height, shows } : null;
}

/** The number of cameras with pictures. */
function camerasOf({ tracks }) {
  const videos = tracks.filter(({ kind }) => kind === "video").map(({ video }) => video);
  const ids = videos.flatMap(({ shows, tiles = [], camera }) =>
    shows === "camera" ? [camera] : tiles.map((tile) => tile.camera),
  );
  return new Set(ids).size;
}

/** info: the output of fvvinfo --json for the file. */
export function factsOf(path, info) {
  const name = basename(path, ".fvv");
  const [numerator, denominator] = info.scene.time_base;
  const seconds = (Number(info.end) - Number(info.start)) * (numerator / denominator);
  const visibility = info.tracks.find(({ kind }) => kind === "visibility")?.visibility;
  return {
    name,
    file: `clips/${name}.fvv`,
    ...(descriptions[name] ?? { title: name, kind: "Clip", about: "" }),
    bytes: info.bytes,
    frames: info.frames,
    seconds,
    rate: Number((info.frames / seconds).toFixed(2)),
    bitrate: (8 * info.bytes) / seconds,
    cameras: camerasOf(info),
    mesh: meshOf(info),
    pictures: picturesOf(info),
    visibility: visibility ? { bitsPerPair: visibility.bits_per_pair } : null,
    tracks: bytesByKind(info),
  };
}
