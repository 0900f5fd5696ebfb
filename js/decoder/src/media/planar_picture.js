// A picture as planes in memory, with the part of VideoFrame's interface that readers of pixels use. For Node and browsers
// without WebCodecs; elsewhere callers get a VideoFrame.

import { FvvError } from "../errors.js";

/** Names of WebCodecs for code points of ITU-T H.273; null for others. 2, unspecified, means BT.709 by clause 10.6. */
const primaries = { 1: "bt709", 2: "bt709", 5: "bt470bg", 6: "smpte170m", 9: "bt2020", 12: "smpte432" };
const transfers = {
  1: "bt709",
  2: "bt709",
  6: "smpte170m",
  8: "linear",
  13: "iec61966-2-1",
  14: "bt709",
  16: "pq",
  18: "hlg",
};
const matrices = { 0: "rgb", 1: "bt709", 2: "bt709", 5: "bt470bg", 6: "smpte170m", 9: "bt2020-ncl" };

function colorSpaceOf({ primaries: p, transfer, matrix, fullRange }) {
  return {
    primaries: primaries[p] ?? null,
    transfer: transfers[transfer] ?? null,
    matrix: matrices[matrix] ?? null,
    fullRange,
  };
}

/** Bytes per sample of the supported formats. */
const sampleBytes = { I420: 1, I420P10: 2 };

/** Width and height of Y, U and V of a rectangle, in samples. */
export function planesOf(width, height) {
  const half = { width: Math.ceil(width / 2), height: Math.ceil(height / 2) };
  return [{ width, height }, half, half];
}

export class PlanarPicture {
  /** fields: format, codedWidth, codedHeight, timestamp, colorSpace, data with the planes one after the other. */
  constructor(fields) {
    Object.assign(this, fields);
    this.duration = null;
  }
  get displayWidth() {
    return this.codedWidth;
  }
  get displayHeight() {
    return this.codedHeight;
  }
  get codedRect() {
    return this.format && { x: 0, y: 0, width: this.codedWidth, height: this.codedHeight };
  }
  get visibleRect() {
    return this.codedRect;
  }
  /** The plan of copyTo: where each plane is in data and in the destination, and the size of the destination. */
  #plan({ rect = this.codedRect, layout, format = this.format } = {}) {
    if (!this.format) throw new FvvError({ code: "state", fatal: false, message: "the picture was closed" });
    if (format !== this.format)
      throw new FvvError({
        code: "unsupported",
        fatal: false,
        message: `a picture in ${this.format} has no ${format}`,
      });
    const { x, y, width, height } = rect;
    const inside = x >= 0 && y >= 0 && x + width <= this.codedWidth && y + height <= this.codedHeight;
    if (!inside || x % 2 || y % 2 || !(width > 0 && height > 0))
      throw new FvvError({
        code: "argument",
        fatal: false,
        message: "rect: expected even coordinates inside the picture",
      });
    const bytes = sampleBytes[this.format];
    const whole = planesOf(this.codedWidth, this.codedHeight);
    let from = 0;
    let end = 0;
    let size = 0;
    const planes = planesOf(width, height).map((part, i) => {
      const source = { start: from, stride: whole[i].width * bytes };
      source.start += (i ? y / 2 : y) * source.stride + (i ? x / 2 : x) * bytes;
      from += source.stride * whole[i].height;
      const { offset, stride } = layout?.[i] ?? { offset: end, stride: part.width * bytes };
      if (stride < part.width * bytes)
        throw new FvvError({ code: "argument", fatal: false, message: `rows of plane ${i} are ${stride} bytes apart` });
      end = offset + stride * part.height;
      size = Math.max(size, end);
      return { source, offset, stride, row: part.width * bytes, rows: part.height };
    });
    return { planes, size };
  }
  allocationSize(options) {
    return this.#plan(options).size;
  }
  async copyTo(destination, options) {
    const { planes, size } = this.#plan(options);
    const out = ArrayBuffer.isView(destination)
      ? new Uint8Array(destination.buffer, destination.byteOffset, destination.byteLength)
      : new Uint8Array(destination);
    if (out.length < size)
      throw new FvvError({
        code: "argument",
        fatal: false,
        message: `destination: expected ${size} bytes, found ${out.length}`,
      });
    for (const { source, offset, stride, row, rows } of planes)
      for (let i = 0; i < rows; i++) {
        const start = source.start + i * source.stride;
        out.set(this.data.subarray(start, start + row), offset + i * stride);
      }
    return planes.map(({ offset, stride }) => ({ offset, stride }));
  }
  clone() {
    if (!this.format) throw new FvvError({ code: "state", fatal: false, message: "the picture was closed" });
    return new PlanarPicture({ ...this });
  }
  close() {
    this.format = this.data = null;
    this.codedWidth = this.codedHeight = 0;
  }
}

/** A VideoFrame if the environment has one for the format, else a PlanarPicture. data belongs to the picture. */
export function createPicture({ format, width, height, timestamp, colour, data }) {
  const fields = { format, codedWidth: width, codedHeight: height, timestamp, colorSpace: colorSpaceOf(colour) };
  if (typeof VideoFrame === "function")
    try {
      return new VideoFrame(data, { ...fields, transfer: [data.buffer] });
    } catch (error) {
      // Not every browser with VideoFrame supports 10 bits.
      if (format === "I420") throw error;
    }
  return new PlanarPicture({ ...fields, data });
}

/** Structured clones of pictures lose their methods. */
export function revivePicture(image) {
  return image.close ? image : new PlanarPicture(image);
}
