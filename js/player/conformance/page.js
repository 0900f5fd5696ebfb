// Renders frames of a stream from poses that the runner provides and compares.

import { createDecoder } from "@fvv/decoder";
import { replicationOf } from "@fvv/shading";

import { Renderer } from "../src/renderer/index.js";
import { viewFromPose } from "../src/view.js";

const canvas = document.body.appendChild(document.createElement("canvas"));
const contextAttributes = { antialias: false, alpha: false };
const renderer = new Renderer(canvas, { contextAttributes });
let decoder = null;
let cameras = [];

function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

function pixels() {
  const { width, height, data } = renderer.readPixels();
  return { width, height, data: base64(data) };
}

/** Environments are reported after the first frame. */
async function environmentsOf({ tracks }) {
  while (tracks.some(({ kind }) => kind === "environment") && !decoder.environments.length) {
    const frame = await decoder.next();
    if (!frame) break;
    frame.close();
  }
  return decoder.environments;
}

/** Shows a frame of a file and returns the facts that poses are made from. options: of the decoder. */
window.openStream = async (file, number, options) => {
  decoder?.close();
  decoder = await createDecoder({
    ...options,
    source: file,
    worker: new URL("worker.js", import.meta.url),
  });
  await decoder.seek({ frame: number });
  const frame = await decoder.next();
  if (!frame?.mesh) throw new Error(`${file}: no mesh in frame ${number}`);
  await renderer.show(frame);
  await renderer.setEnvironments(await environmentsOf(frame.configuration));
  cameras = frame.cameras;
  const facts = {
    bounds: renderer.bounds,
    upAxis: frame.configuration.upAxis,
    frameCount: decoder.frameCount,
    views: renderer.frame.viewCount,
    withBits: [...new Set(frame.visibility.flatMap(({ cameras }) => [...cameras]))],
    cameras: frame.cameras.map(({ id, calibrated, centre, rotation, fx, width }) => ({
      id,
      calibrated,
      centre,
      rotation: [...rotation],
      fx,
      width,
    })),
    pictures: frame.pictures.map(({ picture }) => picture.format ?? picture.constructor.name),
  };
  frame.close();
  return facts;
};

/** Replaces the environment: quads of four corners each, seen from both sides if doubleSided. */
window.surround = (quads) =>
  renderer.setEnvironments([
    {
      lights: [],
      pictures: [],
      parts: quads.map(({ corners, colour, doubleSided }) => ({
        positions: Float32Array.from(corners.flat()),
        faces: Uint32Array.of(0, 1, 2, 0, 2, 3),
        faceCount: 2,
        picture: null,
        colour,
        doubleSided,
      })),
    },
  ]);

/** Shows two frames concurrently. */
window.showTwo = async () => {
  await decoder.seek({ frame: 0 });
  const frames = [await decoder.next(), await decoder.next()];
  const shown = await Promise.all(frames.map((frame) => renderer.show(frame)));
  for (const frame of frames) frame.close();
  return { shown, number: renderer.frame.number, wanted: frames[1].number };
};

/** Draws with the frusta of the frame's cameras. */
function drawn(pose, { frusta, ...options }) {
  return renderer.draw(viewFromPose(pose), { ...options, frusta: frusta && { ...frusta, cameras } });
}

window.draw = (pose, options) => {
  drawn(pose, options);
  return pixels();
};
/** Without reading pixels. */
window.drawOnly = (pose, options) => ({ drew: drawn(pose, options), ...renderer.counters });

/** Loses and restores the context. */
window.loseContext = () =>
  new Promise((resolve) => {
    const extension = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
    renderer.addEventListener("lost", () => setTimeout(() => extension.restoreContext(), 50), { once: true });
    renderer.addEventListener("restored", () => resolve(), { once: true });
    extension.loseContext();
  });

/**
 * Converts noise to RGB by replicationOf's model of browsers, and by this browser. Returns the fraction of equal pixels.
 */
window.replicate = async (matrix, fullRange) => {
  const side = 64;
  const pixels = side * side;
  const data = Uint8Array.from({ length: 1.5 * pixels }, (_, i) => 70 + (((i * i * 7919) % 104729) % 110));
  const colorSpace = { matrix, fullRange, primaries: "bt709", transfer: "bt709" };
  const frame = new VideoFrame(data, { format: "I420", codedWidth: side, codedHeight: side, timestamp: 0, colorSpace });
  const found = new Uint8Array(4 * pixels);
  await frame.copyTo(found, { format: "RGBX" });
  const { mixing, luma } = replicationOf({ video: { colour: {} }, picture: frame });
  frame.close();
  const [uGreen, uBlue, vRed, vGreen] = mixing;
  let alike = 0;
  for (let i = 0; i < pixels; i++) {
    const chroma = pixels + (side / 2) * Math.floor(i / side / 2) + Math.floor((i % side) / 2);
    const [u, v] = [data[chroma] - 128, data[chroma + pixels / 4] - 128];
    const y = Math.floor(luma[0] * data[i]) + luma[1];
    const made = [y + vRed * v, y - uGreen * u - vGreen * v, y + uBlue * u];
    alike += made.every((sum, k) => Math.min(255, Math.max(0, sum >> 6)) === found[4 * i + k]);
  }
  return alike / pixels;
};

document.documentElement.dataset.ready = "";
