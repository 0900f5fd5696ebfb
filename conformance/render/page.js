// Draws a frame as a view sees it: by the renderer of the player, and by the object for three.js.

import { createDecoder } from "@fvv/decoder";
import { FvvObject3D, lookThrough } from "@fvv/three";
import { PerspectiveCamera, Scene, WebGLRenderer } from "three";

import { Renderer } from "../../js/player/src/renderer/index.js";

const newCanvas = () => document.body.appendChild(document.createElement("canvas"));

/** Each takes a frame and a view, and returns {width, height, data: RGBA from the top}. */
const renderers = {
  player() {
    const renderer = new Renderer(newCanvas(), { contextAttributes: { antialias: false, alpha: false } });
    return async (frame, view) => {
      await renderer.show(frame);
      renderer.draw(view, { shadows: false, environment: false });
      return renderer.readPixels();
    };
  },
  three() {
    const renderer = new WebGLRenderer({ canvas: newCanvas(), antialias: false, preserveDrawingBuffer: true });
    return async (frame, view) => {
      const scene = new Scene();
      const viewer = new PerspectiveCamera(50, 1, 0.05, 100);
      const object = new FvvObject3D({ renderer });
      scene.add(object.add(viewer));
      await object.show(frame);
      const { width, height } = view;
      renderer.setSize(width, height, false);
      lookThrough(viewer, view);
      renderer.render(scene, viewer);
      const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
      copy.drawImage(renderer.domElement, 0, 0);
      object.dispose();
      return { width, height, data: copy.getImageData(0, 0, width, height).data };
    };
  },
};
const made = {};

function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

/** view: of the protocol. Returns {width, height, rgba: base64}, or {unsupported: reason} if the browser lacks a codec. */
window.render = async (which, file, number, view) => {
  const draw = (made[which] ??= renderers[which]());
  const decoder = await createDecoder({ source: file, worker: new URL("worker.js", import.meta.url) });
  const warnings = [];
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail.message));
  try {
    await decoder.seek({ frame: number });
    const frame = await decoder.next();
    if (!frame?.mesh) throw new Error(`no mesh in frame ${number}`);
    try {
      const lost = frame.configuration.videos.filter(({ track }) => !frame.picture(track));
      if (lost.length)
        return {
          unsupported: `no picture of track ${lost[0].track}, codec ${lost[0].codec}, ${lost[0].bitDepth} bits${warnings.map((text) => `; ${text}`).join("")}`,
        };
      const { width, height, data } = await draw(frame, { skew: 0, ...view });
      return { width, height, rgba: base64(data) };
    } finally {
      frame.close();
    }
  } finally {
    decoder.close();
  }
};
document.documentElement.dataset.ready = "";
