// Draws frames of a stream with three from poses, for the comparison that js/player/conformance makes.

import { createDecoder } from "@fvv/decoder";
import { PerspectiveCamera, Scene } from "three";

import { drawn, objectOf, rendererOf } from "./renderers.js";

const scene = new Scene();
const viewer = new PerspectiveCamera();
let renderer = null;
let object = null;
let decoder = null;
let frame = null;
let shown = null; // visibleBy

function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

/** The same frame without visibility weights. */
function withoutWeights() {
  const { configuration, cameras, mesh, meshes, number, seconds, samples } = frame;
  const [camera, picture, tiles] = ["camera", "picture", "tiles"].map((name) => frame[name].bind(frame));
  return { configuration, cameras, mesh, meshes, number, seconds, samples, visibility: [], camera, picture, tiles };
}

/** kind: of the renderer, see rendererOf. Returns the facts that poses are made from. */
window.openStream = async (file, number, { kind }) => {
  frame?.close();
  decoder?.close();
  object?.dispose();
  scene.clear();
  renderer = await rendererOf(kind, "standard");
  object = objectOf(kind, { renderer });
  scene.add(object);
  decoder = await createDecoder({ source: file, worker: new URL("worker.js", import.meta.url) });
  await decoder.seek({ frame: number });
  frame = await decoder.next();
  await object.show(frame);
  shown = "bits";
  const { min, max } = object.mesh.geometry.boundingBox;
  return {
    bounds: { min: min.toArray(), max: max.toArray() },
    upAxis: frame.configuration.upAxis,
    views: object.viewCount,
    backend: renderer.backend?.isWebGPUBackend ? "webgpu" : "webgl",
    withBits: [...new Set(frame.visibility.flatMap(({ cameras }) => [...cameras]))],
    cameras: frame.cameras.map(({ id, calibrated, centre, rotation, fx, width }) => ({
      id,
      calibrated,
      centre,
      rotation: [...rotation],
      fx,
      width,
    })),
  };
};

window.draw = async ({ eye, target, up, fov, width, height }, { visibleBy }) => {
  if (visibleBy !== shown) await object.show(visibleBy === "depth" ? withoutWeights() : frame);
  shown = visibleBy;
  viewer.fov = fov;
  viewer.aspect = width / height;
  viewer.position.fromArray(eye);
  viewer.up.fromArray(up);
  viewer.lookAt(...target);
  viewer.updateProjectionMatrix();
  renderer.setSize(width, height, false);
  const data = await drawn(renderer, scene, viewer, { width, height });
  return { width, height, data: base64(data) };
};
document.documentElement.dataset.ready = "";
