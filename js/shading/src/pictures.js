// The pictures of a frame on their way into one texture of display values. A picture on the GPU, or in RGB, can be uploaded
// as it is. Planes in memory are uploaded one by one and converted by a shader: browsers use the nearest chroma sample for
// each pixel, and are not consistent in matrix and range.

/** Kr and Kb of ITU-T H.273's matrix coefficients; others, and 2, are taken for BT.709. */
const luma = { 4: [0.3, 0.11], 5: [0.299, 0.114], 6: [0.299, 0.114], 7: [0.212, 0.087], 9: [0.2627, 0.0593] };
const bt709 = [0.2126, 0.0722];

/** The nearest of 8 bits to samples of 10: black, white and grey stay what they are. */
function narrow(bytes) {
  const wide = new Uint16Array(bytes.buffer);
  const out = new Uint8Array(wide.length);
  for (let i = 0; i < wide.length; i++) out[i] = Math.min(255, (wide[i] + 2) >> 2);
  return out;
}

/** A PlanarPicture of @fvv/decoder can't be uploaded as a VideoFrame can. */
const isPlanar10 = (image) => image?.format === "I420P10" && image.data;

/** {video, image} or, of planes in memory, {video, planes}; they have to be waited for. */
export async function loadPicture(video, image) {
  if (image?.format !== "I420" && !isPlanar10(image)) return { video, image };
  const { width, height } = image.visibleRect;
  const [columns, rows] = [Math.ceil(width / 2), Math.ceil(height / 2)];
  const chroma = columns * rows;
  const bytes = image.format === "I420" ? 1 : 2;
  const copied = new Uint8Array((width * height + 2 * chroma) * bytes);
  const layout = [
    { offset: 0, stride: width * bytes },
    { offset: width * height * bytes, stride: columns * bytes },
    { offset: (width * height + chroma) * bytes, stride: columns * bytes },
  ];
  await image.copyTo(copied, { layout });
  const samples = bytes === 1 ? copied : narrow(copied);
  const plane = (offset, width, height) => ({ data: samples.subarray(offset, offset + width * height), width, height });
  const planes = [
    plane(0, width, height),
    plane(width * height, columns, rows),
    plane(width * height + chroma, columns, rows),
  ];
  return { video, planes };
}

/** Of all videos of a frame that have a picture. */
export async function loadPictures(frame) {
  const pictures = frame.configuration.videos.map((video) => loadPicture(video, frame.picture(video.track)));
  return (await Promise.all(pictures)).filter(({ image, planes }) => image || planes);
}

/** Where the picture of each track stands, one below the other, in a texture of width x height. */
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

/** Uniforms of planesFragment for the colours of a video: range is black, and scales of luma and chroma. */
export function conversionOf({ matrix, fullRange }) {
  const [kr, kb] = luma[matrix] ?? bt709;
  return { kr, kb, range: fullRange ? [0, 1, 1] : [16 / 255, 255 / 219, 255 / 224] };
}

/** Pixels that tell, and the share of them that is to the last digit what libyuv makes; interpolated chroma gives less than half. */
const LEAST_TELLING = 256;
const LEAST_SHARE = 0.9;

/** Matrix coefficients of ITU-T H.273 by their names in WebCodecs. */
const matrices = { bt709: 1, bt470bg: 5, smpte170m: 6, "bt2020-ncl": 9 };

/** Steps of Y and Y = 0 of libyuv, in 64ths; of 255 / 219 it takes fewer digits for older matrices. */
const lumaOf = (matrix, fullRange) => {
  const scale = fullRange ? 16320 : matrix === matrices["bt2020-ncl"] ? 19003 : 18997;
  return [(257 * scale) / 65536, fullRange ? 32 : -1160];
};

/** Uniforms of replicatedFragment and replicationFragment, beside those of conversionOf. */
export function replicationOf({ video, image }) {
  // The browser's own choice, which need not be the file's.
  const { matrix, fullRange } = image.colorSpace ?? {};
  const used = {
    matrix: matrices[matrix] ?? video.colour.matrix,
    fullRange: fullRange ?? video.colour.fullRange,
  };
  const { kr, kb, range } = conversionOf(used);
  const [u, v] = [kb, kr].map((k) => 64 * 2 * (1 - k) * range[2]);
  const green = 1 - kr - kb;
  // Of libyuv's bytes with a sign; 128 is its most.
  const mixing = [(u * kb) / green, Math.min(128, u), v, (v * kr) / green].map(Math.round);
  return { mixing, luma: lumaOf(used.matrix, used.fullRange) };
}

/** Whether it was, of what replicationFragment draws, RGBA; null: there is too little colour to tell. */
function judge(pixels) {
  let [telling, alike] = [0, 0];
  for (let i = 0; i < pixels.length; i += 4) {
    telling += pixels[i] >> 7;
    alike += pixels[i + 1] >> 7;
  }
  return telling < LEAST_TELLING ? null : alike > LEAST_SHARE * telling;
}

/** What is known of the tracks of a stream. */
export class Replication {
  #tracks = new Map(); // track -> {answer, asked}

  /** Whether chroma of a picture was replicated. test(): what replicationFragment draws of it, RGBA. */
  isSeenIn({ video, image }, test) {
    if (typeof VideoFrame !== "function" || !(image instanceof VideoFrame)) return false;
    if (!this.#tracks.has(video.track)) this.#tracks.set(video.track, { answer: null, asked: 0 });
    const known = this.#tracks.get(video.track);
    // Reading back is slow: of what has no colours for long, only the frames 1, 2, 4, 8 ... are asked.
    if (known.answer === null && Number.isInteger(Math.log2(++known.asked))) known.answer = judge(test());
    return known.answer === true;
  }
}
