// The pictures of a frame on their way into one texture of display values. A picture on the GPU, or in RGB, can be uploaded
// as it is. Planes in memory are uploaded one by one and converted by a shader: browsers use the nearest chroma sample for
// each pixel, and are not consistent in matrix and range.

/** Kr and Kb of ITU-T H.273's matrix coefficients; others, and 2, mean BT.709. */
const luma = { 4: [0.3, 0.11], 5: [0.299, 0.114], 6: [0.299, 0.114], 7: [0.212, 0.087], 9: [0.2627, 0.0593] };
const bt709 = [0.2126, 0.0722];

/** Rounds samples of 10 bits to 8; black, white and grey are exact. */
function narrow(bytes) {
  const wide = new Uint16Array(bytes.buffer);
  const out = new Uint8Array(wide.length);
  for (let i = 0; i < wide.length; i++) out[i] = Math.min(255, (wide[i] + 2) >> 2);
  return out;
}

/** Bytes of a sample, by the formats whose planes are uploaded; those of other formats stay on the GPU. */
const sampleBytes = { I420: 1, I420P10: 2 };

/** Returns {video, picture} or, for planes in memory, {video, planes}. */
export async function loadPicture(video, picture) {
  const bytes = sampleBytes[picture?.format];
  if (!bytes) return { video, picture };
  const { width, height } = picture.visibleRect;
  const [columns, rows] = [Math.ceil(width / 2), Math.ceil(height / 2)];
  const chroma = columns * rows;
  const copied = new Uint8Array((width * height + 2 * chroma) * bytes);
  const layout = [
    { offset: 0, stride: width * bytes },
    { offset: width * height * bytes, stride: columns * bytes },
    { offset: (width * height + chroma) * bytes, stride: columns * bytes },
  ];
  await picture.copyTo(copied, { layout });
  const samples = bytes === 1 ? copied : narrow(copied);
  const plane = (offset, width, height) => ({ data: samples.subarray(offset, offset + width * height), width, height });
  const planes = [
    plane(0, width, height),
    plane(width * height, columns, rows),
    plane(width * height + chroma, columns, rows),
  ];
  return { video, planes };
}

/** The pictures of all videos of a frame that have one. */
export async function loadPictures(frame) {
  const pictures = frame.configuration.videos.map((video) => loadPicture(video, frame.picture(video.track)));
  return (await Promise.all(pictures)).filter(({ picture, planes }) => picture || planes);
}

/** A picture that outlives its frame, for closePictures. Of a JPEG picture the file is kept. */
function keepPicture(loaded, frame) {
  const { video, picture, planes } = loaded;
  if (planes) return loaded;
  if (typeof VideoFrame === "function" && picture instanceof VideoFrame) return { video, picture: picture.clone() };
  const sample = frame.samples?.find(({ track }) => track === video.track);
  return { video, file: sample?.data ?? null };
}
/** Pictures that outlive their frame, until closePictures. */
export function keepPictures(pictures, frame) {
  return pictures.map((picture) => keepPicture(picture, frame));
}
/** What loadPictures has returned, of kept pictures; files are decoded again. */
export async function loadKept(kept) {
  const decode = async ({ video, file }) => {
    const blob = new Blob([file], { type: "image/jpeg" });
    return { video, picture: await createImageBitmap(blob, { colorSpaceConversion: "none" }) };
  };
  const there = kept.filter(({ picture, planes, file }) => picture || planes || file);
  return Promise.all(there.map((picture) => (picture.file ? decode(picture) : picture)));
}
export function closePictures(kept) {
  for (const { picture } of kept) picture?.close();
}

/** Where the picture of each track is, one below the other, in a texture of width x height. */
export function layoutOf(pictures) {
  const places = new Map();
  let width = 0;
  let height = 0;
  for (const { video } of pictures) {
    places.set(video.track, { x: 0, y: height });
    width = Math.max(width, video.width);
    height += video.height;
  }
  return { places, width, height };
}

/** Uniforms of planesFragment for the colours of a video. range: black, and the scales of luma and chroma. */
export function conversionOf({ matrix, fullRange }) {
  const [kr, kb] = luma[matrix] ?? bt709;
  return { kr, kb, range: fullRange ? [0, 1, 1] : [16 / 255, 255 / 219, 255 / 224] };
}

/** The minimum number of significant pixels, and the minimum fraction of them that equals libyuv's result exactly; with
 * interpolated chroma it is less than half. */
const MIN_SIGNIFICANT = 256;
const MIN_EQUAL = 0.9;

/** Matrix coefficients of ITU-T H.273 by their names in WebCodecs. */
const matrices = { bt709: 1, bt470bg: 5, smpte170m: 6, "bt2020-ncl": 9 };

/** libyuv's step of Y and offset of Y = 0, in 64ths; its 255 / 219 has fewer digits for older matrices. */
const lumaOf = (matrix, fullRange) => {
  const scale = fullRange ? 16320 : matrix === matrices["bt2020-ncl"] ? 19003 : 18997;
  return [(257 * scale) / 65536, fullRange ? 32 : -1160];
};

/** Uniforms of replicatedFragment and replicationFragment, in addition to those of conversionOf. */
export function replicationOf({ video, picture }) {
  // The browser's choice, which may differ from the file's.
  const { matrix, fullRange } = picture.colorSpace ?? {};
  const used = {
    matrix: matrices[matrix] ?? video.colour.matrix,
    fullRange: fullRange ?? video.colour.fullRange,
  };
  const { kr, kb, range } = conversionOf(used);
  const [u, v] = [kb, kr].map((k) => 64 * 2 * (1 - k) * range[2]);
  const green = 1 - kr - kb;
  // libyuv has signed bytes, at most 128.
  const mixing = [(u * kb) / green, Math.min(128, u), v, (v * kr) / green].map(Math.round);
  return { mixing, luma: lumaOf(used.matrix, used.fullRange) };
}

/** Whether chroma was replicated, by the RGBA pixels that replicationFragment draws; null: too little colour to decide. */
function isReplicated(pixels) {
  let [significant, equal] = [0, 0];
  for (let i = 0; i < pixels.length; i += 4) {
    significant += pixels[i] >> 7;
    equal += pixels[i + 1] >> 7;
  }
  return significant < MIN_SIGNIFICANT ? null : equal > MIN_EQUAL * significant;
}

/**
 * Detects replicated chroma in the tracks of a stream. Firefox returns the video that it decodes as RGB, for which libyuv
 * has used each chroma sample for four pixels, in integers. That costs 6 dB and can be undone: the samples are recovered,
 * except those of colours outside RGB, and converted like those of planes.
 */
export class Replication {
  #tracks = new Map(); // track -> {replicated, frames}

  /** Whether the chroma of a picture was replicated. test(): draws it with replicationFragment and returns RGBA pixels. */
  isSeenIn({ video, picture }, test) {
    if (typeof VideoFrame !== "function" || !(picture instanceof VideoFrame)) return false;
    if (!this.#tracks.has(video.track)) this.#tracks.set(video.track, { replicated: null, frames: 0 });
    const known = this.#tracks.get(video.track);
    // Reading back is slow: until the question is decided, only the frames 1, 2, 4, 8 ... are tested.
    if (known.replicated === null && Number.isInteger(Math.log2(++known.frames)))
      known.replicated = isReplicated(test());
    return known.replicated === true;
  }
}
