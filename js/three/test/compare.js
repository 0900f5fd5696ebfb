// Draws frames of a stream as its cameras see them, and measures how far that is from pictures of fvvrender.

import { createDecoder } from "@fvv/decoder";
import { FvvObject3D, lookThrough } from "@fvv/three";
import { PerspectiveCamera, Scene, WebGLRenderer } from "three";

const renderer = new WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
const scene = new Scene();
const viewer = new PerspectiveCamera();
document.body.append(renderer.domElement);

async function pixels(source, width, height) {
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(source, 0, 0);
  return context.getImageData(0, 0, width, height).data;
}
async function reference(name, width, height) {
  const image = await createImageBitmap(await (await fetch(name)).blob(), { colorSpaceConversion: "none" });
  return pixels(image, width, height);
}

async function decodeFrame(file, number) {
  const decoder = await createDecoder({ source: file, worker: new URL("worker.js", import.meta.url) });
  await decoder.seek({ frame: number });
  const frame = await decoder.next();
  return { decoder, frame };
}

/** Mean square error inside the mask, in display values; and how much of the mask is the colour of unseen surface. */
function measure(drawn, wanted, mask) {
  let sum = 0;
  let count = 0;
  let grey = 0;
  let outside = 0;
  for (let i = 0; i < drawn.length; i += 4) {
    const lit = drawn[i] + drawn[i + 1] + drawn[i + 2] > 0;
    if (mask[i] < 128) {
      outside += lit;
      continue;
    }
    count++;
    grey += drawn[i] === 128 && drawn[i + 1] === 128 && drawn[i + 2] === 128;
    for (let k = 0; k < 3; k++) sum += (drawn[i + k] - wanted[i + k]) ** 2;
  }
  return { psnr: 10 * Math.log10((255 * 255 * 3 * count) / sum), count, grey, outside };
}

/** cases: [{camera, picture, mask}], pictures of fvvrender as cameras of the stream see the frame. */
window.compare = async ({ file, number, cases, rotate = 0 }) => {
  const { decoder, frame } = await decodeFrame(file, number);
  const object = new FvvObject3D({ renderer });
  // A scene may turn, move and scale what is in it: colours stay where they are.
  if (rotate) {
    object.rotation.y = rotate;
    object.position.set(1, 2, 3);
    object.scale.set(2, 2, 2);
  }
  scene.add(object.add(viewer));
  await object.show(frame);
  const results = [];
  for (const { camera: id, picture, mask } of cases) {
    const camera = frame.camera(id);
    const { width, height } = camera;
    renderer.setSize(width, height, false);
    Object.assign(viewer, { near: 0.05, far: 100 });
    lookThrough(viewer, camera);
    renderer.render(scene, viewer);
    const drawn = await pixels(renderer.domElement, width, height);
    const [wanted, inside] = await Promise.all([reference(picture, width, height), reference(mask, width, height)]);
    results.push({ camera: id, ...measure(drawn, wanted, inside) });
  }
  const facts = { results, views: object.viewCount, tiles: frame.tiles(), visibility: frame.visibility.length };
  frame.close();
  decoder.close();
  scene.remove(object);
  object.dispose();
  return facts;
};
document.documentElement.dataset.ready = "";
