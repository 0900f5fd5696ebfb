// Reads structs of libfvv and of wasm/wasm_structs.h from a module's memory. Everything is copied: results stay valid when the
// memory grows or is overwritten.

// The size of each struct, and the type and offset of each field, with the number of elements or what a list holds.
// begin of generated tables (wasm/generate_wasm_structs.mjs)
const layouts = {
  scene: {
    size: 56,
    fields: {
      numerator: ["u32", 0],
      denominator: ["u32", 4],
      frameDuration: ["i64", 8],
      latticeOrigin: ["f64[]", 16, 3],
      latticeStep: ["f64", 40],
      upAxis: ["u8", 48],
      flags: ["u8", 49],
    },
  },
  track: {
    size: 32,
    fields: {
      id: ["u16", 0],
      kind: ["u8", 2],
      alternateGroup: ["u16", 4],
      rank: ["u16", 6],
      bitRate: ["u32", 8],
      size: ["u32", 12],
      numerator: ["u32", 16],
      denominator: ["u32", 20],
      name: ["text", 24],
    },
  },
  camera: {
    size: 232,
    fields: {
      id: ["u16", 0],
      lens: ["u8", 2],
      flags: ["u8", 3],
      width: ["u32", 4],
      height: ["u32", 8],
      fx: ["f64", 16],
      fy: ["f64", 24],
      cx: ["f64", 32],
      cy: ["f64", 40],
      skew: ["f64", 48],
      distortion: ["f64[]", 56, 8],
      rMax: ["f64", 120],
      rotation: ["f64[]", 128, 9],
      translation: ["f64[]", 200, 3],
      name: ["text", 224],
    },
  },
  rect: {
    size: 8,
    fields: {
      x: ["u16", 0],
      y: ["u16", 2],
      width: ["u16", 4],
      height: ["u16", 6],
    },
  },
  tile: {
    size: 18,
    fields: {
      cameraId: ["u16", 0],
      source: ["in", 2, "rect"],
      destination: ["in", 10, "rect"],
    },
  },
  video_config: {
    size: 36,
    fields: {
      codec: ["u32", 0],
      width: ["u32", 4],
      height: ["u32", 8],
      shows: ["u8", 12],
      bitDepth: ["u8", 13],
      colourPrimaries: ["u8", 14],
      transferCharacteristics: ["u8", 15],
      matrixCoefficients: ["u8", 16],
      fullRange: ["u8", 17],
      record: ["bytes", 20],
      codecString: ["text", 28],
    },
  },
  video: {
    size: 48,
    fields: {
      track: ["u16", 0],
      config: ["in", 4, "video_config"],
      tiles: ["list", 40, "tile"],
    },
  },
  audio_config: {
    size: 56,
    fields: {
      codec: ["u32", 0],
      channels: ["u8", 4],
      flags: ["u8", 5],
      packetDuration: ["u32", 8],
      preroll: ["u32", 12],
      position: ["f64[]", 16, 3],
      record: ["bytes", 40],
      language: ["text", 48],
    },
  },
  audio: {
    size: 64,
    fields: {
      track: ["u16", 0],
      config: ["in", 8, "audio_config"],
    },
  },
  text: {
    size: 8,
    fields: {
      text: ["text", 0],
    },
  },
  texturing: {
    size: 40,
    fields: {
      threshold: ["f64", 0],
      depthBias: ["f64", 8],
      depthSlope: ["f64", 16],
      inset: ["f64", 24],
      best: ["u8", 32],
      unseen: ["u8[]", 33, 3],
      blend: ["u8", 36],
    },
  },
  configuration: {
    size: 136,
    fields: {
      scene: ["in", 0, "scene"],
      tracks: ["list", 56, "track"],
      cameras: ["list", 64, "camera"],
      videos: ["list", 72, "video"],
      sounds: ["list", 80, "audio"],
      metadata: ["list", 88, "text"],
      texturing: ["in", 96, "texturing"],
    },
  },
  event: {
    size: 72,
    fields: {
      kind: ["u32", 0],
      offset: ["u64", 8],
      configuration: ["u32", 16],
      repeated: ["u32", 20],
      time: ["i64", 24],
      end: ["i64", 32],
      sequence: ["u32", 40],
      configurationCrc: ["u32", 44],
      chunks: ["u32", 48],
      chunkCount: ["u32", 52],
      whole: ["u32", 56],
      skipped: ["u64", 64],
    },
  },
  group: {
    size: 64,
    fields: {
      offset: ["u64", 0],
      size: ["u64", 8],
      start: ["i64", 16],
      end: ["i64", 24],
      sequence: ["u32", 32],
      frameCount: ["u32", 36],
      intact: ["u32", 40],
      configurationSize: ["u32", 44],
      configurationOffset: ["u64", 48],
      chainCrc: ["u32", 56],
      endSize: ["u32", 60],
    },
  },
  diagnostic: {
    size: 240,
    fields: {
      status: ["i32", 0],
      issue: ["u32", 4],
      chunkType: ["u32", 8],
      offset: ["u64", 16],
      chunkOffset: ["u64", 24],
      message: ["char[]", 32, 208],
    },
  },
  mesh: {
    size: 44,
    fields: {
      track: ["u32", 0],
      profile: ["u32", 4],
      key: ["u32", 8],
      vertexCount: ["u32", 12],
      faceCount: ["u32", 16],
      lattice: ["i32*", 20, 3, "vertexCount"],
      faces: ["u32*", 24, 3, "faceCount"],
      positions: ["f32*", 28, 3, "vertexCount"],
      normals: ["f32*", 32, 3, "vertexCount"],
      texture: ["f32*", 36, 2, "vertexCount"],
      colours: ["u8*", 40, 4, "vertexCount"],
    },
  },
  visibility: {
    size: 28,
    fields: {
      track: ["u32", 0],
      meshTrack: ["u32", 4],
      threshold: ["u32", 8],
      cameraCount: ["u32", 12],
      vertexCount: ["u32", 16],
      cameras: ["u16*", 20, 1, "cameraCount"],
      weights: ["u8*", 24, "cameraCount", "vertexCount"],
    },
  },
  sample: {
    size: 16,
    fields: {
      track: ["u32", 0],
      key: ["u32", 4],
      data: ["bytes", 8],
    },
  },
  layout: {
    size: 12,
    fields: {
      track: ["u32", 0],
      tiles: ["list", 4, "tile"],
    },
  },
  sound: {
    size: 64,
    fields: {
      track: ["u32", 0],
      start: ["i64", 8],
      packetCount: ["u32", 16],
      prerollCount: ["u32", 20],
      position: ["f64[]", 24, 3],
      sizes: ["u16*", 48, 1, "packetCount"],
      data: ["bytes", 52],
    },
  },
  frame: {
    size: 64,
    fields: {
      time: ["i64", 0],
      meshes: ["list", 8, "mesh"],
      visibility: ["list", 16, "visibility"],
      cameras: ["list", 24, "camera"],
      samples: ["list", 32, "sample"],
      layouts: ["list", 40, "layout"],
      environments: ["list", 48, "sample"],
      sounds: ["list", 56, "sound"],
    },
  },
  part: {
    size: 44,
    fields: {
      vertexCount: ["u32", 0],
      faceCount: ["u32", 4],
      lattice: ["i32*", 8, 3, "vertexCount"],
      faces: ["u32*", 12, 3, "faceCount"],
      positions: ["f32*", 16, 3, "vertexCount"],
      texture: ["f32*", 20, 2, "vertexCount"],
      picture: ["u32", 24],
      flags: ["u32", 28],
      colour: ["u32[]", 32, 3],
    },
  },
  picture: {
    size: 20,
    fields: {
      codec: ["u8", 0],
      width: ["u32", 4],
      height: ["u32", 8],
      data: ["bytes", 12],
    },
  },
  light: {
    size: 112,
    fields: {
      type: ["u8", 0],
      flags: ["u8", 1],
      position: ["f64[]", 8, 3],
      direction: ["f64[]", 32, 3],
      colour: ["f64[]", 56, 3],
      intensity: ["f64", 80],
      range: ["f64", 88],
      innerCone: ["f64", 96],
      outerCone: ["f64", 104],
    },
  },
  environment: {
    size: 56,
    fields: {
      codecs: ["u32", 0],
      partCount: ["u32", 4],
      pictures: ["list", 8, "picture"],
      lights: ["list", 16, "light"],
      latticeOrigin: ["f64[]", 24, 3],
      latticeStep: ["f64", 48],
    },
  },
};
// end of generated tables

const decoder = new TextDecoder();
const arrays = {
  "u8*": Uint8Array,
  "u16*": Uint16Array,
  "u32*": Uint32Array,
  "i32*": Int32Array,
  "f32*": Float32Array,
};

/** A struct as an object; a reader of its own converts each struct of a list. */
function read(name, memory, address) {
  const { fields } = layouts[name];
  const view = new DataView(memory.buffer, address);
  const u32 = (at) => view.getUint32(at, true);
  const bytes = (at) => new Uint8Array(memory.buffer, u32(at), u32(at + 4));
  const count = (factor) => (typeof factor === "number" ? factor : u32(fields[factor][1]));
  const scalars = {
    u8: (at) => view.getUint8(at),
    u16: (at) => view.getUint16(at, true),
    u32,
    i32: (at) => view.getInt32(at, true),
    u64: (at) => Number(view.getBigUint64(at, true)),
    i64: (at) => view.getBigInt64(at, true),
    f64: (at) => view.getFloat64(at, true),
    text: (at) => decoder.decode(bytes(at).slice()),
    bytes: (at) => bytes(at).slice(),
    "u8[]": (at, length) => Array.from({ length }, (_, i) => view.getUint8(at + i)),
    "u32[]": (at, length) => Array.from({ length }, (_, i) => u32(at + 4 * i)),
    "f64[]": (at, length) => Array.from({ length }, (_, i) => view.getFloat64(at + 8 * i, true)),
    "char[]": (at, length) => {
      const all = new Uint8Array(memory.buffer, address + at, length);
      return decoder.decode(all.slice(0, all.indexOf(0)));
    },
    in: (at, kind) => read(kind, memory, address + at),
    list: (at, kind) => {
      const one = readers[kind] ?? ((m, a) => read(kind, m, a));
      return Array.from({ length: u32(at + 4) }, (_, i) => one(memory, u32(at) + i * layouts[kind].size));
    },
  };
  const out = {};
  for (const [field, [type, at, ...rest]] of Object.entries(fields)) {
    const Type = arrays[type];
    if (!Type) out[field] = scalars[type](at, ...rest);
    else out[field] = u32(at) ? new Type(memory.buffer, u32(at), count(rest[0]) * count(rest[1])).slice() : null;
  }
  return out;
}

const lenses = ["none", "radtan", "fisheye"];
const kinds = ["", "mesh", "video", "calibration", "visibility", "environment", "data", "audio", "colours"];
const shows = ["tiles", "atlas"];
const profiles = ["raw", "draco", "delta", "field", "fast", "patched"];
const blends = ["viewer", "paper"];
const upAxes = ["unknown", "x", "y", "z", "-x", "-y", "-z"];
const pictureTypes = ["image/jpeg", "image/png"];
const lightTypes = ["directional", "point", "spot"];
const NO_PICTURE = 0xffffffff;

function fourcc(code) {
  return String.fromCharCode(code & 255, (code >> 8) & 255, (code >> 16) & 255, code >>> 24);
}

export const CAMERA_SIZE = layouts.camera.size;
/** The size of fvv_diagnostic of types.h, which is the same in all modules. */
export const DIAGNOSTIC_SIZE = layouts.diagnostic.size;

/** A camera of the configuration: one that moves is calibrated in frames only. */
function readCamera(memory, address) {
  const { lens, flags, ...camera } = read("camera", memory, address);
  const moves = (flags & 1) !== 0;
  return { ...camera, lens: lenses[lens], moves, calibrated: !moves };
}

/** The inverse of readCamera, for projection: everything but the name. */
export function writeCamera(memory, address, camera) {
  const view = new DataView(memory.buffer, address, CAMERA_SIZE);
  const values = { ...camera, lens: lenses.indexOf(camera.lens), flags: 0 };
  for (const [field, [type, at]] of Object.entries(layouts.camera.fields)) {
    const value = values[field];
    if (type === "text") view.setBigUint64(at, 0n, true);
    else if (type === "u8") view.setUint8(at, value);
    else if (type === "u16") view.setUint16(at, value, true);
    else if (type === "u32") view.setUint32(at, value, true);
    else [value].flat().forEach((x, i) => view.setFloat64(at + 8 * i, x, true));
  }
}

const readers = {
  camera: readCamera,
  sample: readSample,
  track(memory, address) {
    const track = read("track", memory, address);
    const { id, name, alternateGroup, rank, bitRate, size, numerator, denominator } = track;
    const timeBase = denominator ? { numerator, denominator } : null;
    return { id, kind: kinds[track.kind] ?? "unknown", name, timeBase, alternateGroup, rank, bitRate, size };
  },
  text: (memory, address) => read("text", memory, address).text,
  tile(memory, address) {
    const { cameraId, source, destination } = read("tile", memory, address);
    return { camera: cameraId, source, destination };
  },
  video(memory, address) {
    const { track, config, tiles } = read("video", memory, address);
    return {
      track,
      codec: fourcc(config.codec),
      codecString: config.codecString,
      width: config.width,
      height: config.height,
      shows: shows[config.shows],
      bitDepth: config.bitDepth,
      colour: {
        primaries: config.colourPrimaries,
        transfer: config.transferCharacteristics,
        matrix: config.matrixCoefficients,
        fullRange: config.fullRange !== 0,
      },
      record: config.record,
      tiles,
    };
  },
  audio(memory, address) {
    const { track, config } = read("audio", memory, address);
    const { codec, channels, flags, packetDuration, preroll, position, record, language } = config;
    return {
      track,
      codec: fourcc(codec),
      channels,
      packetDuration,
      preroll,
      position: flags & 1 ? position : null,
      moves: (flags & 2) !== 0,
      record,
      language,
    };
  },
  mesh(memory, address) {
    const mesh = read("mesh", memory, address);
    const { track, profile, key, vertexCount, faceCount, lattice, faces, positions, normals, texture, colours } = mesh;
    return {
      track,
      profile: profiles[profile] ?? "unknown",
      key: key !== 0,
      vertexCount,
      faceCount,
      lattice,
      faces,
      positions,
      normals,
      uvs: texture,
      colours,
    };
  },
  visibility(memory, address) {
    const { cameraCount, cameras, threshold, ...seen } = read("visibility", memory, address);
    return { ...seen, threshold: threshold / 256, cameras: Array.from(cameras) };
  },
  picture(memory, address) {
    const { codec, ...picture } = read("picture", memory, address);
    return { ...picture, type: pictureTypes[codec] };
  },
  light(memory, address) {
    const { type, flags, ...light } = read("light", memory, address);
    return { ...light, type: lightTypes[type], castsShadows: (flags & 1) !== 0 };
  },
};

/** Steps of the lattice: local positions count from a place near the scene, as 32 bits hold those of maps to decimetres only. */
const UNIT = 2 ** 20;

/**
 * The lattice's origin in whole multiples of 2^20 steps, as libfvv's tools have it: floats hold indices beside them to a
 * fraction of a step, and scenes whose lattices begin near 0 stay where they are.
 */
export function localOriginOf({ origin, step }) {
  const unit = step * UNIT;
  return origin.map((x) => {
    const multiple = Math.sign(x) * Math.round(Math.abs(x) / unit) * unit;
    return Number.isFinite(multiple) ? multiple + 0 : 0; // never -0
  });
}

/**
 * positions, of a mesh whose indices on the lattice are given, relative to origin; the same array if origin is 0, where there
 * is no difference. Differences are formed in doubles and rounded once.
 */
export function localPositionsOf({ positions, lattice: indices }, lattice, origin) {
  if (!positions || origin.every((x) => x === 0)) return positions;
  const { step } = lattice;
  const [x, y, z] = lattice.origin.map((value, k) => value - origin[k]);
  const local = new Float32Array(indices.length);
  for (let i = 0; i < indices.length; i += 3) {
    local[i] = x + step * indices[i];
    local[i + 1] = y + step * indices[i + 1];
    local[i + 2] = z + step * indices[i + 2];
  }
  return local;
}

const latticeOf = ({ latticeOrigin, latticeStep }) => ({ origin: latticeOrigin, step: latticeStep });

/** The lattice of a configuration alone, which is the same in all of a stream. */
export const readLattice = (memory, address) => latticeOf(read("scene", memory, address));

export function readConfiguration(memory, address) {
  const { scene, tracks, cameras, videos, sounds, metadata, texturing } = read("configuration", memory, address);
  const [red, green, blue] = texturing.unseen;
  const lattice = latticeOf(scene);
  return {
    timeBase: { numerator: scene.numerator, denominator: scene.denominator },
    frameDuration: scene.frameDuration,
    lattice,
    localOrigin: localOriginOf(lattice),
    upAxis: upAxes[scene.upAxis] ?? "unknown",
    scaleKnown: (scene.flags & 1) === 0,
    tracks,
    cameras,
    videos,
    sounds,
    metadata,
    texturing: { ...texturing, unseen: (red << 16) | (green << 8) | blue, blend: blends[texturing.blend] },
  };
}

export function readSample(memory, address) {
  const { track, key, data } = read("sample", memory, address);
  return { track, key: key !== 0, data };
}

/** lattice: of the configuration; without one there are no meshes. */
export function readFrame(memory, address, lattice) {
  const { cameras, meshes, ...frame } = read("frame", memory, address);
  const origin = lattice && localOriginOf(lattice);
  return {
    ...frame,
    meshes: meshes.map((mesh) => ({ ...mesh, origin, localPositions: localPositionsOf(mesh, lattice, origin) })),
    moving: cameras.map((camera) => ({ ...camera, calibrated: true })),
  };
}

/** lattice: of the environment; origin: of the stream's local positions. */
export function readPart(memory, address, lattice, origin) {
  const { flags, faces, texture, picture, colour, lattice: indices, ...part } = read("part", memory, address);
  return {
    ...part,
    origin,
    localPositions: localPositionsOf({ ...part, lattice: indices }, lattice, origin),
    faces,
    uvs: texture,
    picture: picture === NO_PICTURE ? null : picture,
    unlit: (flags & 1) !== 0,
    doubleSided: (flags & 2) !== 0,
    clamped: (flags & 4) !== 0,
    colour: colour.map((part) => part / 65535),
  };
}

export function readEnvironmentList(memory, address) {
  const { latticeOrigin, latticeStep, ...list } = read("environment", memory, address);
  return { ...list, lattice: latticeOf({ latticeOrigin, latticeStep }) };
}

export function readEvent(memory, address) {
  const { offset, skipped, time, end, sequence, configurationCrc, whole } = read("event", memory, address);
  return { offset, skipped, start: time, end, sequence, configuration: configurationCrc, whole: whole !== 0 };
}

/** count groups that are one after the other. A month has millions of them: fields are read one by one. */
export function readGroups(memory, address, count) {
  const { size: step, fields } = layouts.group;
  const place = Object.fromEntries(Object.entries(fields).map(([name, [, at]]) => [name, at]));
  const view = new DataView(memory.buffer, address, count * step);
  const u32 = (at) => view.getUint32(at, true);
  const u64 = (at) => u32(at) + 2 ** 32 * u32(at + 4);
  return Array.from({ length: count }, (_, i) => {
    const base = i * step;
    return {
      offset: u64(base + place.offset),
      size: u64(base + place.size),
      start: view.getBigInt64(base + place.start, true),
      end: view.getBigInt64(base + place.end, true),
      sequence: u32(base + place.sequence),
      frameCount: u32(base + place.frameCount),
      intact: u32(base + place.intact) !== 0,
      endSize: u32(base + place.endSize),
      configurationOffset: u64(base + place.configurationOffset),
      configurationSize: u32(base + place.configurationSize),
      firstFrame: 0,
    };
  });
}

export function readDiagnostic(memory, address) {
  const { chunkType, ...diagnostic } = read("diagnostic", memory, address);
  return { ...diagnostic, chunk: chunkType ? fourcc(chunkType) : "" };
}
