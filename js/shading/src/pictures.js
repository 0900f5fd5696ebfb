// The pictures of a frame on their way to one texture of display values. A picture that lies on the GPU, or is RGB, can go
// there as it is. One of planes in memory is uploaded plane by plane and converted by a shader: browsers take the nearest
// sample of colour for each pixel, and matrix and range from wherever they like.

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
