// Reads the structs of wasm/flat.h from the module's memory. The numbers here are its offsets, which are checked by
// assertions there. Everything is copied: results stay valid when the memory grows or is overwritten.

const text = new TextDecoder();

/** A struct at an address; words are 32 bits wide. */
class Struct {
  constructor(memory, address) {
    this.buffer = memory.buffer;
    this.address = address;
    this.view = new DataView(memory.buffer, address);
  }
  u32(offset) {
    return this.view.getUint32(offset, true);
  }
  i32(offset) {
    return this.view.getInt32(offset, true);
  }
  i64(offset) {
    return this.view.getBigInt64(offset, true);
  }
  f64(offset) {
    return this.view.getFloat64(offset, true);
  }
  f64s(offset, count) {
    return Array.from({ length: count }, (_, i) => this.f64(offset + 8 * i));
  }
  bytes(pointer, size) {
    return new Uint8Array(this.buffer, this.u32(pointer), this.u32(size)).slice();
  }
  text(pointer, size) {
    return text.decode(this.bytes(pointer, size));
  }
  /** count elements of a typed array; null for a null pointer. */
  array(Type, pointer, count) {
    const address = this.u32(pointer);
    return address ? new Type(this.buffer, address, count).slice() : null;
  }
  /** The structs of a list. */
  list(memory, pointer, count, size, read) {
    const address = this.u32(pointer);
    return Array.from({ length: this.u32(count) }, (_, i) => read(memory, address + i * size));
  }
}

const lenses = ["none", "radtan", "fisheye"];
const kinds = ["", "mesh", "video", "calibration", "visibility", "background", "metadata", "audio"];
const shows = ["tiles", "camera", "atlas"];
const domains = ["faces", "vertices", "weights"];
const profiles = ["raw", "draco", "delta", "field", "fast"];
const upAxes = ["unknown", "x", "y", "z", "-x", "-y", "-z"];

function fourcc(code) {
  return String.fromCharCode(code & 255, (code >> 8) & 255, (code >> 16) & 255, code >>> 24);
}

export const CAMERA_SIZE = 240;

function readCamera(memory, address) {
  const s = new Struct(memory, address);
  return {
    id: s.u32(208),
    name: s.text(232, 236),
    width: s.u32(220),
    height: s.u32(224),
    fx: s.f64(0),
    fy: s.f64(8),
    cx: s.f64(16),
    cy: s.f64(24),
    skew: s.f64(32),
    lens: lenses[s.u32(212)],
    distortion: s.f64s(40, 8),
    rMax: s.f64(104),
    rotation: s.f64s(112, 9),
    translation: s.f64s(184, 3),
    moves: (s.u32(216) & 1) !== 0,
    calibrated: s.u32(228) !== 0,
  };
}

/** The inverse of readCamera, for projection: everything but the name. */
export function writeCamera(memory, address, camera) {
  const view = new DataView(memory.buffer, address, CAMERA_SIZE);
  const numbers = [camera.fx, camera.fy, camera.cx, camera.cy, camera.skew, ...camera.distortion, camera.rMax];
  [...numbers, ...camera.rotation, ...camera.translation].forEach((x, i) => view.setFloat64(8 * i, x, true));
  const words = [camera.id, lenses.indexOf(camera.lens), 0, camera.width, camera.height, 1, 0, 0];
  words.forEach((x, i) => view.setUint32(208 + 4 * i, x, true));
}

function readRect(s, at) {
  return { x: s.u32(at), y: s.u32(at + 4), width: s.u32(at + 8), height: s.u32(at + 12) };
}

function readTile(memory, address) {
  const s = new Struct(memory, address);
  return { camera: s.u32(0), source: readRect(s, 4), destination: readRect(s, 20) };
}

function readVideo(memory, address) {
  const s = new Struct(memory, address);
  const shown = shows[s.u32(16)];
  return {
    track: s.u32(0),
    codec: fourcc(s.u32(4)),
    codecString: s.text(52, 56),
    width: s.u32(8),
    height: s.u32(12),
    shows: shown,
    camera: shown === "camera" ? s.u32(24) : null,
    bitDepth: s.u32(20),
    colour: { primaries: s.u32(28), transfer: s.u32(32), matrix: s.u32(36), fullRange: s.u32(40) !== 0 },
    record: s.bytes(44, 48),
    tiles: s.list(memory, 60, 64, 36, readTile),
  };
}

function readTrack(memory, address) {
  const s = new Struct(memory, address);
  return { id: s.u32(0), kind: kinds[s.u32(4)] ?? "unknown", name: s.text(8, 12) };
}

export function readConfiguration(memory, address) {
  const s = new Struct(memory, address);
  return {
    timeBase: { numerator: s.u32(40), denominator: s.u32(44) },
    frameDuration: s.i64(32),
    lattice: { origin: s.f64s(0, 3), step: s.f64(24) },
    upAxis: upAxes[s.u32(48)] ?? "unknown",
    scaleKnown: (s.u32(52) & 1) === 0,
    tracks: s.list(memory, 56, 60, 16, readTrack),
    cameras: s.list(memory, 64, 68, CAMERA_SIZE, readCamera),
    videos: s.list(memory, 72, 76, 68, readVideo),
    metadata: s.list(memory, 80, 84, 8, (m, a) => new Struct(m, a).text(0, 4)),
    texturing: {
      threshold: s.f64(88),
      best: s.u32(112),
      unseen: s.u32(116),
      depthBias: s.f64(96),
      depthSlope: s.f64(104),
    },
  };
}

function readMesh(memory, address) {
  const s = new Struct(memory, address);
  const vertices = s.u32(12);
  return {
    track: s.u32(0),
    profile: profiles[s.u32(4)] ?? "unknown",
    key: s.u32(8) !== 0,
    vertexCount: vertices,
    faceCount: s.u32(16),
    lattice: s.array(Int32Array, 20, 3 * vertices),
    indices: s.array(Uint32Array, 24, 3 * s.u32(16)),
    positions: s.array(Float32Array, 28, 3 * vertices),
    normals: s.array(Float32Array, 32, 3 * vertices),
    uvs: s.array(Float32Array, 36, 2 * vertices),
  };
}

function readVisibility(memory, address) {
  const s = new Struct(memory, address);
  const cameras = s.u32(16);
  const elements = s.u32(20);
  return {
    track: s.u32(0),
    meshTrack: s.u32(4),
    domain: domains[s.u32(8)],
    threshold: s.u32(12) / 256,
    cameras: Array.from(s.array(Uint16Array, 24, cameras)),
    elementCount: elements,
    states: s.array(Uint8Array, 28, cameras * elements),
    vertexCount: s.u32(36),
    weights: s.array(Uint8Array, 32, cameras * s.u32(36)),
  };
}

export function readSample(memory, address) {
  const s = new Struct(memory, address);
  return { track: s.u32(0), key: s.u32(4) !== 0, data: s.bytes(8, 12) };
}

function readLayout(memory, address) {
  const s = new Struct(memory, address);
  return { track: s.u32(0), tiles: s.list(memory, 4, 8, 36, readTile) };
}

export function readFrame(memory, address) {
  const s = new Struct(memory, address);
  return {
    time: s.i64(0),
    meshes: s.list(memory, 8, 12, 48, readMesh),
    visibility: s.list(memory, 16, 20, 40, readVisibility),
    moving: s.list(memory, 24, 28, CAMERA_SIZE, readCamera),
    samples: s.list(memory, 32, 36, 16, readSample),
    layouts: s.list(memory, 40, 44, 12, readLayout),
    backgrounds: s.list(memory, 48, 52, 16, readSample),
  };
}

const NO_PICTURE = 0xffffffff;
const pictureTypes = ["image/jpeg", "image/png"];
const lightTypes = ["directional", "point", "spot"];

export function readPart(memory, address) {
  const s = new Struct(memory, address);
  const vertices = s.u32(0);
  const faces = s.u32(4);
  const flags = s.u32(24);
  return {
    vertexCount: vertices,
    faceCount: faces,
    indices: s.array(Uint32Array, 8, 3 * faces),
    positions: s.array(Float32Array, 12, 3 * vertices),
    uvs: s.array(Float32Array, 16, 2 * vertices),
    picture: s.u32(20) === NO_PICTURE ? null : s.u32(20),
    unlit: (flags & 1) !== 0,
    doubleSided: (flags & 2) !== 0,
    clamped: (flags & 4) !== 0,
    colour: [28, 32, 36].map((at) => s.u32(at) / 65535),
  };
}

function readPicture(memory, address) {
  const s = new Struct(memory, address);
  return { type: pictureTypes[s.u32(0)], width: s.u32(4), height: s.u32(8), data: s.bytes(12, 16) };
}

function readLight(memory, address) {
  const s = new Struct(memory, address);
  return {
    type: lightTypes[s.u32(104)],
    position: s.f64s(0, 3),
    direction: s.f64s(24, 3),
    colour: s.f64s(48, 3),
    intensity: s.f64(72),
    range: s.f64(80),
    innerCone: s.f64(88),
    outerCone: s.f64(96),
    castsShadows: (s.u32(108) & 1) !== 0,
  };
}

export function readBackgroundList(memory, address) {
  const s = new Struct(memory, address);
  return {
    codecs: s.u32(0),
    partCount: s.u32(4),
    pictures: s.list(memory, 8, 12, 20, readPicture),
    lights: s.list(memory, 16, 20, 112, readLight),
  };
}

export function readEvent(memory, address) {
  const s = new Struct(memory, address);
  return {
    offset: Number(s.i64(0)),
    skipped: Number(s.i64(8)),
    start: s.i64(16),
    end: s.i64(24),
    sequence: s.u32(32),
    configuration: s.u32(36),
  };
}

export function readGroup(memory, address) {
  const s = new Struct(memory, address);
  return {
    offset: Number(s.i64(0)),
    size: Number(s.i64(8)),
    start: s.i64(16),
    end: s.i64(24),
    sequence: s.u32(32),
    frameCount: s.u32(36),
    intact: s.u32(40) !== 0,
    endSize: s.u32(44),
  };
}

/** The size of fvv_diagnostic of types.h, which is the same in all modules. */
export const DIAGNOSTIC_SIZE = 232;

export function readDiagnostic(memory, address) {
  const s = new Struct(memory, address);
  const bytes = new Uint8Array(memory.buffer, address + 24, 208);
  const type = s.u32(8);
  return {
    status: s.i32(0),
    issue: s.u32(4),
    chunk: type ? fourcc(type) : "",
    offset: Number(s.i64(16)),
    message: text.decode(bytes.slice(0, bytes.indexOf(0))),
  };
}
