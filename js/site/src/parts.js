// What a clip consists of, in words: the cells of facts and the parts of its bytes.

import { bitrate, bytes, codecName, count, percent, profileName, seconds } from "./words.js";

const plural = (n, one, many = `${one}s`) => (n === 1 ? one : many);
const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** [value, unit, explanation] of everything that a clip has. */
export function factsOf(clip) {
  const { mesh, pictures, visibility } = clip;
  const facts = [];
  if (clip.cameras)
    facts.push([
      count(clip.cameras),
      plural(clip.cameras, "camera"),
      "filmed the scene at the same moments, from all sides",
    ]);
  facts.push([
    count(clip.frames),
    plural(clip.frames, "frame"),
    clip.frames === 1 ? "a moment that stands still" : `${clip.rate} a second, ${seconds(clip.seconds)} in all`,
  ]);
  if (mesh) {
    facts.push([count(mesh.triangles), "triangles", "make up the surface of a frame, on average"]);
    facts.push([bytes(mesh.bytes / clip.frames), "for a mesh", capital(meshWords(mesh))]);
  }
  facts.push([bytes(clip.bytes), "in all", "one file, checked byte for byte while it plays"]);
  if (clip.frames > 1) facts.push([bitrate(clip.bitrate), "on average", "what a connection has to bring"]);
  if (pictures)
    facts.push([
      codecName(pictures.codec),
      `${pictures.width} × ${pictures.height}`,
      pictures.shows === "tiles"
        ? "one video: what each camera saw of the scene, side by side"
        : "a video of the texture that lies on the mesh",
    ]);
  if (visibility)
    facts.push([
      visibility.bitsPerPair.toFixed(3),
      "bits",
      "tell of a triangle and a camera whether one sees the other, so that players need not find out",
    ]);
  return facts;
}

function meshWords({ profiles }) {
  return profiles.map(profileName).join(" and ");
}

const kinds = {
  video: [
    "Pictures",
    ({ pictures }) => (pictures.shows === "tiles" ? "what the cameras saw, as one video" : "the texture, as a video"),
  ],
  mesh: ["Meshes", ({ mesh }) => `the surface in each frame: ${meshWords(mesh)}`],
  visibility: ["Visibility", () => "which camera sees which triangle"],
  calibration: ["Calibration", () => "where cameras that move stand and look, frame by frame"],
  background: ["Environment", () => "floor, walls and lamps; sent once"],
  container: ["Container", () => "headers with checksums, tables, the index"],
};

/** [{name, bytes, share, words}], the largest first. */
export function partsOf(clip) {
  const parts = clip.tracks
    .map(({ kind, bytes: size }) => {
      const [name, words] = kinds[kind] ?? [capital(kind), () => ""];
      return { kind, name, bytes: size, words: words(clip) };
    })
    .sort((a, b) => b.bytes - a.bytes);
  return parts.map((part) => ({ ...part, share: part.bytes / clip.bytes, text: percent(part.bytes / clip.bytes) }));
}
