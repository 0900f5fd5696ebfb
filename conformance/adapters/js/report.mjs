// The report of conformance/PROTOCOL.md by @fvv/decoder, in Node and in browsers.

const raw = (typed) => new Uint8Array(typed.buffer, typed.byteOffset, typed.byteLength);
/** 64-bit integers that a number cannot hold are strings of digits. */
const integer = (big) => (big >= -(2n ** 53n) && big <= 2n ** 53n ? Number(big) : String(big));
/** What a decoder reports of damage; other codes are about the host, or about a file that has no index. */
const damaging = new Set(["damaged", "truncated", "invalid", "unsupported", "limit"]);

function cameraNumbers(camera) {
  const { fx, fy, cx, cy, skew, distortion, rMax, rotation, translation } = camera;
  return Float64Array.of(fx, fy, cx, cy, skew, ...distortion, rMax, ...rotation, ...translation);
}

function tileNumbers(tiles) {
  const rect = ({ x, y, width, height }) => [x, y, width, height];
  return Uint32Array.from(tiles.flatMap((tile) => [tile.camera, ...rect(tile.source), ...rect(tile.destination)]));
}

/** Red, green and blue of each vertex, without the 255 that follows them. */
const rgbOf = (colours) => colours.filter((_, i) => i % 4 !== 3);

/** [name, typed array] of everything in a frame. */
function* arraysOf(frame) {
  const { texturing, tracks, videos } = frame.configuration;
  const best = new Set(tracks.filter(({ rank }) => rank === 0).map(({ id }) => id));
  for (const mesh of frame.meshes) {
    const name = (what) => `mesh/${mesh.track}/${what}`;
    yield [name("lattice"), mesh.lattice];
    yield [name("faces"), mesh.faces];
    yield [name("positions"), mesh.positions];
    // Computed ones where none were sent; the runner leaves those out.
    if (mesh.normals) yield [name("normals"), mesh.normals];
    if (mesh.uvs) yield [name("uvs"), mesh.uvs];
    if (mesh.colours) yield [name("colours"), rgbOf(mesh.colours)];
  }
  for (const visibility of frame.visibility)
    for (const camera of visibility.cameras)
      yield [`visibility/${visibility.track}/${camera}`, visibility.weightsOf(camera)];
  for (const { track, key, data } of frame.samples) {
    yield [`video/${track}/sample`, data];
    yield [`video/${track}/key`, Uint8Array.of(key ? 1 : 0)];
  }
  for (const { track, shows } of videos)
    if (shows === "tiles" && best.has(track)) yield [`tiles/${track}`, tileNumbers(frame.tiles(track))];
  for (const camera of frame.cameras) if (camera.calibrated) yield [`camera/${camera.id}`, cameraNumbers(camera)];
  const { threshold, depthBias, depthSlope, unseen, blend } = texturing;
  const numbers = [threshold, depthBias, depthSlope, texturing.best, unseen, blend === "paper" ? 1 : 0];
  yield ["texturing", Float64Array.from(numbers)];
}

function* environmentArrays({ parts, pictures, lights }) {
  for (const [i, part] of parts.entries()) {
    yield [`part/${i}/positions`, part.positions];
    yield [`part/${i}/faces`, part.faces];
    if (part.uvs) yield [`part/${i}/uvs`, part.uvs];
  }
  for (const [i, { data }] of pictures.entries()) yield [`picture/${i}`, data];
  for (const [i, light] of lights.entries()) {
    const { position, direction, colour, intensity, range, innerCone, outerCone } = light;
    const numbers = [...position, ...direction, ...colour, intensity, range, innerCone, outerCone];
    yield [`light/${i}`, Float64Array.from(numbers)];
  }
}

async function hashesOf(arrays, sha256) {
  const out = {};
  for (const [name, array] of arrays) out[name] = await sha256(raw(array));
  return out;
}

function joined(parts) {
  const out = new Uint8Array(parts.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}

/** Collects the packets of a track. */
class Sound {
  #parts = [];
  #chunks = [];
  #packets = 0;

  add({ start, packetCount, data }) {
    this.#chunks.push({ start, packets: packetCount, part: data });
    this.#parts.push(data);
    this.#packets += packetCount;
  }

  async report(sha256) {
    const chunks = [];
    for (const { start, packets, part } of this.#chunks)
      chunks.push({ start: integer(start), packets, sha256: await sha256(part) });
    return { packets: this.#packets, start: chunks[0].start, sha256: await sha256(joined(this.#parts)), chunks };
  }
}

/** Errors and warnings that say that something is wrong with the stream. */
class Problems {
  list = [];
  refused = false;
  ended = true;

  take(error) {
    // A file without an index may be complete all the same, but that is not known.
    if (error.code === "no-index") this.ended = false;
    if (damaging.has(error.code)) this.list.push(error);
  }
  issues() {
    const known = this.list.filter(({ issue, offset }) => issue && offset !== null);
    return known.map(({ issue, offset }) => ({ issue: `FVV-${issue}`, offset })).sort((a, b) => a.offset - b.offset);
  }
}

const pieceSize = 977;
async function* pieces(bytes) {
  for (let at = 0; at < bytes.length; at += pieceSize) yield bytes.slice(at, at + pieceSize);
}

/** createDecoder: of @fvv/decoder. sha256(bytes): hex, or a promise of it. options: for createDecoder. */
export async function report(createDecoder, sha256, bytes, live, options = {}) {
  const frames = [];
  const sounds = new Map();
  const problems = new Problems();
  let decoder = null;
  let environments = [];
  try {
    const source = live ? pieces(bytes) : bytes;
    decoder = await createDecoder({ source, video: "encoded", sound: "encoded", rung: 0, ...options });
    decoder.addEventListener("warning", ({ detail }) => problems.take(detail.code === "gap" ? detail.cause : detail));
    decoder.addEventListener("sound", ({ detail }) => {
      if (!sounds.has(detail.track)) sounds.set(detail.track, new Sound());
      sounds.get(detail.track).add(detail);
    });
    for await (const frame of decoder) {
      frames.push({ time: integer(frame.time), arrays: await hashesOf(arraysOf(frame), sha256) });
      frame.close();
    }
  } catch (error) {
    if (!error.code) throw error;
    problems.take(error);
    problems.refused = true;
  }
  if (decoder) {
    // Sound that was read is dispatched after the last frame.
    await new Promise((resolve) => setTimeout(resolve, 0));
    environments = decoder.environments;
    decoder.close();
  }
  const out = { issues: problems.issues(), frames, sounds: {}, environment: {} };
  out.status = problems.refused ? "refused" : problems.list.length ? "damaged" : "whole";
  if (!live) out.summary = { ended: problems.ended && out.status === "whole" };
  for (const [track, sound] of sounds) out.sounds[track] = await sound.report(sha256);
  for (const environment of environments)
    out.environment[environment.track] = await hashesOf(environmentArrays(environment), sha256);
  return out;
}

export const parts = ["live", "mesh", "camera", "visibility", "colours", "texturing", "video", "sound", "environment"];
