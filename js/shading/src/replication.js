// Firefox hands out the video that it decodes as RGB, of which it has replicated each sample of chroma for four pixels, by
// libyuv and in whole numbers. That loses 6 dB, and can be undone: the samples are found again, all but those of colours
// that RGB does not have, and are converted as those of planes. Whether pictures come that way is seen in them.

import { conversionOf } from "./pictures.js";

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
