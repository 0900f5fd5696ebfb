// The facts of a clip as elements and words: its properties, the parts of its bytes, and the comparison with WHP 235.

const number = new Intl.NumberFormat("en");
const count = (n) => number.format(Math.round(n));
const percent = (share) => `${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;

/** 1923408 -> "1.92 MB" */
export function bytes(n) {
  if (n >= 1e6) return `${(n / 1e6).toFixed(n < 1e7 ? 2 : 1)} MB`;
  return n >= 1e3 ? `${(n / 1e3).toFixed(n < 1e4 ? 1 : 0)} kB` : `${Math.round(n)} bytes`;
}
const bitrate = (bits) => (bits >= 1e6 ? `${(bits / 1e6).toFixed(1)} Mbit/s` : `${(bits / 1e3).toFixed(0)} kbit/s`);
const seconds = (s) => (s < 0.095 ? `${Math.round(1000 * s)} ms` : `${s.toFixed(2)} s`);

const codecs = { avc1: "H.264", hvc1: "HEVC", vp09: "VP9", av01: "AV1", jpeg: "JPEG", oexr: "OpenEXR" };
const codecName = (codec) => codecs[codec] ?? codec;

const profiles = {
  draco: "Draco key frames",
  delta: "motion between them",
  patched: "motion and patches",
  fast: "fast meshes",
  raw: "raw meshes",
  field: "fields",
};
const profileName = (profile) => profiles[profile] ?? profile;

/** element("p", {class: "small"}, "text", node, ...) */
export function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

const plural = (n, one, many = `${one}s`) => (n === 1 ? one : many);
const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** [value, unit, explanation] of the properties of a clip. */
export function factsOf(clip) {
  const { mesh, pictures, visibility } = clip;
  const facts = [];
  if (clip.cameras)
    facts.push([
      count(clip.cameras),
      plural(clip.cameras, "camera"),
      "recorded the scene synchronously from all sides",
    ]);
  facts.push([
    count(clip.frames),
    plural(clip.frames, "frame"),
    clip.frames === 1 ? "a still" : `${clip.rate} per second, ${seconds(clip.seconds)} in total`,
  ]);
  if (mesh) {
    facts.push([count(mesh.triangles), "triangles", "per frame on average"]);
    facts.push([bytes(mesh.bytes / clip.frames), "per mesh", capital(meshWords(mesh))]);
  }
  facts.push([bytes(clip.bytes), "in total", "one file, all of it protected by checksums"]);
  if (clip.frames > 1) facts.push([bitrate(clip.bitrate), "on average", "the bandwidth that playback needs"]);
  if (pictures)
    facts.push([
      codecName(pictures.codec),
      `${pictures.width} × ${pictures.height}`,
      pictures.shows === "tiles"
        ? "one video with the pictures of all cameras side by side"
        : "a video of the mesh's texture",
    ]);
  if (visibility)
    facts.push([
      visibility.bitsPerPair.toFixed(3),
      "bits",
      "per vertex and camera for visibility, which players need not compute",
    ]);
  return facts;
}

/** The same of a file, as far as the player knows. size: bytes, or null. */
export function factsOfFile({ cameras, frameCount, duration }, size) {
  const facts = [];
  if (cameras.length) facts.push([count(cameras.length), plural(cameras.length, "camera"), "of the frame on screen"]);
  const timed = Number.isFinite(duration) && duration > 0;
  if (frameCount)
    facts.push([count(frameCount), plural(frameCount, "frame"), timed ? `${seconds(duration)} in total` : "in total"]);
  if (size !== null) facts.push([bytes(size), "in total", "one file, all of it protected by checksums"]);
  if (size !== null && timed) facts.push([bitrate((8 * size) / duration), "on average", "the bandwidth of playback"]);
  return facts;
}

function meshWords({ profiles }) {
  return profiles.map(profileName).join(" and ");
}

const kinds = {
  video: [
    "Pictures",
    ({ pictures }) => (pictures.shows === "tiles" ? "of the cameras, as one video" : "the texture, as a video"),
  ],
  mesh: ["Meshes", ({ mesh }) => `the surface in each frame: ${meshWords(mesh)}`],
  visibility: ["Visibility", () => "what each camera sees of the surface"],
  calibration: ["Calibration", () => "poses of moving cameras in each frame"],
  environment: ["Environment", () => "floor, walls and lamps; transmitted once"],
  container: ["Container", () => "headers with checksums, tables, the index"],
};

/** The parts of a clip's bytes, [{kind, name, bytes, share, text, words}], the largest first. */
export function partsOf(clip) {
  const parts = clip.tracks
    .map(({ kind, bytes: size }) => {
      const [name, words] = kinds[kind] ?? [capital(kind), () => ""];
      return { kind, name, bytes: size, words: words(clip) };
    })
    .sort((a, b) => b.bytes - a.bytes);
  return parts.map((part) => ({ ...part, share: part.bytes / clip.bytes, text: percent(part.bytes / clip.bytes) }));
}

/** The paper's clip. */
const THEN = { seconds: 2, bytes: 27.3e6 };

function row(name, value, share, now) {
  const fill = element("div", { class: now ? "fill now" : "fill" });
  fill.style.width = `${Math.max(100 * share, 0.4)}%`;
  return element(
    "div",
    { class: "row" },
    element("span", { class: "who" }, name),
    element("div", { class: "track" }, fill),
    element("span", { class: "value" }, value),
  );
}

function group(title, then, now, text) {
  const max = Math.max(then, now);
  const ratio = then / now;
  const less = ratio > 1 ? `: ${ratio.toFixed(ratio < 9.5 ? 1 : 0)} times less` : "";
  return element(
    "div",
    { class: "pair" },
    element("h3", {}, title + less),
    row("WHP 235", text(then), then / max, false),
    row("This clip", text(now), now / max, true),
  );
}

/** Bars that compare the size of a clip with that of WHP 235. Times are left out: they are those of other machines and networks. */
export function comparedWith(clip) {
  if (clip.frames < 2) return [element("p", {}, "This clip is a single frame, which the paper has no figure for.")];
  return [group("Size of two seconds", THEN.bytes, (clip.bytes / clip.seconds) * THEN.seconds, bytes)];
}
