// Draws frames of a stream as its cameras see them, and measures the difference from pictures of fvvrender.

import { createDecoder } from "@fvv/decoder";
import { lookThrough } from "@fvv/three";
import { Mesh, MeshBasicMaterial, PerspectiveCamera, PlaneGeometry, Raycaster, Scene, Vector2, Vector3 } from "three";

import { drawn, objectOf, pixels, rendererOf } from "./renderers.js";

const scene = new Scene();
const viewer = new PerspectiveCamera(50, 1, 0.05, 100);

/** Loses the context, and resolves when the object has been drawn into textures again. */
async function renew(renderer, object) {
  const restored = new Promise((done) => object.addEventListener("restored", done));
  const lost = new Promise((done) => renderer.domElement.addEventListener("webglcontextlost", () => setTimeout(done)));
  renderer.forceContextLoss();
  await lost;
  renderer.forceContextRestore();
  await restored;
}

/** The fraction of the pixels with mask that a plane across the view hides, by its distance. */
async function hidden(renderer, distances, mask, size) {
  const plane = new Mesh(new PlaneGeometry(1000, 1000), new MeshBasicMaterial({ color: 0xff00ff }));
  viewer.add(plane);
  const found = [];
  for (const distance of distances) {
    plane.position.z = -distance;
    const picture = await drawn(renderer, scene, viewer, size);
    let [count, covered] = [0, 0];
    for (let i = 0; i < picture.length; i += 4) {
      if (mask[i] < 255) continue;
      count++;
      covered += picture[i] === 255 && picture[i + 1] === 0 && picture[i + 2] === 255;
    }
    found.push(covered / count);
  }
  viewer.remove(plane);
  return found;
}

/**
 * Rays of three through some pixels: how many meet the object, the fraction that meets it where the mask is white and not where
 * it is black, and the largest distance in pixels between a pixel and the point that was met, as the camera projects it.
 */
function rays(object, camera, mask, { width, height }) {
  const caster = new Raycaster();
  const [hits, right, off] = [[], [], []];
  for (let y = 4; y < height; y += 9)
    for (let x = 4; x < width; x += 9) {
      const white = mask[4 * (y * width + x)];
      if (white > 0 && white < 255) continue;
      caster.setFromCamera(new Vector2((2 * (x + 0.5)) / width - 1, 1 - (2 * (y + 0.5)) / height), viewer);
      const found = object.pick(caster.ray);
      right.push((found !== null) === white > 0);
      if (!found) continue;
      hits.push(found);
      const [u, v] = camera.project(...found.position);
      off.push(Math.hypot(u - x - 0.5, v - y - 0.5));
      const world = object.localToWorld(new Vector3(...found.position));
      const away = world.distanceTo(caster.ray.origin) / object.getWorldScale(new Vector3()).x;
      if (!(Math.abs(away - found.distance) < 1e-3)) throw new Error(`${away} and ${found.distance}`);
    }
  return { hits: hits.length, right: right.filter(Boolean).length / right.length, off: Math.max(...off) };
}

async function reference(name, size) {
  const blob = await (await fetch(name)).blob();
  return pixels(await createImageBitmap(blob, { colorSpaceConversion: "none" }), size);
}

/**
 * PSNR inside the mask, in display values; the number of its pixels; how many of these are grey, the colour of surface that
 * no camera shows; and how many pixels outside the mask are drawn.
 */
function measure(drawn, wanted, mask) {
  let [sum, count, grey, outside] = [0, 0, 0, 0];
  for (let i = 0; i < drawn.length; i += 4) {
    const rgb = [0, 1, 2].map((k) => drawn[i + k]);
    if (mask[i] < 128) {
      outside += rgb.some((value) => value > 0);
      continue;
    }
    count++;
    grey += rgb.every((value) => value === 128);
    rgb.forEach((value, k) => (sum += (value - wanted[i + k]) ** 2));
  }
  return { psnr: 10 * Math.log10((255 * 255 * 3 * count) / sum), count, grey, outside };
}

/** RGBA of a picture of a shrink-th of the size, each pixel the mean of a square. */
function averaged(data, { width, height }, shrink) {
  const [columns, rows] = [Math.floor(width / shrink), Math.floor(height / shrink)];
  const out = new Float32Array(4 * columns * rows);
  for (let y = 0; y < rows * shrink; y++)
    for (let x = 0; x < columns * shrink; x++)
      for (let k = 0; k < 4; k++)
        out[4 * (Math.floor(y / shrink) * columns + Math.floor(x / shrink)) + k] +=
          data[4 * (y * width + x) + k] / shrink ** 2;
  return out;
}

/** The frame with the requested cameras and pictures only. */
function part(frame, { only, pictures }) {
  const { configuration, cameras, mesh, meshes, visibility, number, time, seconds, samples } = frame;
  const camera = (id) => (only === undefined || only === id ? frame.camera(id) : null);
  const picture = (track) => (pictures ? frame.picture(track) : null);
  const tiles = (track) => frame.tiles(track);
  const plain = { configuration, cameras, mesh, meshes, visibility, number, time, seconds, samples };
  return { ...plain, camera, picture, tiles };
}

/**
 * cases: [{camera, picture, mask}], of fvvrender. only: the only camera that gives colour; pictures: false if they are lost;
 * turned: the object is moved, rotated and scaled; tracks: the selected tracks of video; own: options of the object; shrink:
 * pictures are drawn in a shrink-th of their size, as from far away, and compared with means of fvvrender's pixels; near: of the
 * viewer; depth: of the renderer; lose: it loses its context before it draws; planes: distances of planes for hidden(); cast: see rays().
 */
window.compare = async ({
  file,
  number,
  cases,
  only,
  pictures = true,
  turned = false,
  tracks = null,
  own = {},
  shrink = 1,
  near = 0.05,
  kind = "webgl",
  depth = "standard",
  lose = false,
  planes = [],
  cast = false,
}) => {
  const renderer = await rendererOf(kind, depth);
  viewer.near = near;
  const decoder = await createDecoder({
    source: file,
    worker: new URL("worker.js", import.meta.url),
    tracks,
  });
  await decoder.seek({ frame: number });
  const frame = await decoder.next();
  const object = objectOf(kind, { renderer, ...own });
  if (turned) {
    object.rotation.set(0.3, 0.7, -2);
    object.position.set(1, 2, 3);
    object.scale.setScalar(2);
  }
  scene.add(object.add(viewer));
  await object.show(part(frame, { only, pictures }));
  if (lose) {
    renderer.render(scene, viewer);
    await renew(renderer, object);
  }
  const results = [];
  for (const { camera: id, picture, mask } of cases) {
    const camera = frame.camera(id);
    const size = { width: camera.width / shrink, height: camera.height / shrink };
    renderer.setSize(size.width, size.height, false);
    lookThrough(viewer, camera, renderer);
    const seen = await drawn(renderer, scene, viewer, size);
    const [wanted, inside] = await Promise.all([picture, mask].map((name) => reference(name, camera)));
    results.push({
      camera: id,
      hidden: await hidden(renderer, planes, inside, size),
      ...(cast && { rays: rays(object, camera, inside, size) }),
      ...measure(
        seen,
        averaged(wanted, camera, shrink),
        averaged(inside, camera, shrink).map((value) => (value < 255 ? 0 : 255)),
      ),
    });
  }
  const facts = {
    results,
    views: object.viewCount,
    tiles: frame.tiles(),
    tracks: frame.configuration.videos.map(({ track }) => ({ track, tiles: frame.tiles(track) })),
    hasVisibility: frame.visibility.length > 0,
  };
  frame.close();
  decoder.close();
  scene.remove(object);
  object.dispose();
  return facts;
};
document.documentElement.dataset.ready = "";
