// The renderers of three that tests draw with, and what they draw.

import * as forWebGL from "@fvv/three";
import * as forWebGPU from "@fvv/three/webgpu";
import { FloatType, RenderTarget, WebGLRenderer } from "three";
import { WebGLNodesHandler } from "three/addons/tsl/WebGLNodesHandler.js";
import { WebGPURenderer } from "three/webgpu";

const newNodeRenderer = (kind, options) => new WebGPURenderer({ ...options, forceWebGL: kind === "force-webgl" });
const renderers = {};
/** kind: "webgl", "webgl-nodes" (WebGLRenderer with node materials), "force-webgl" or "webgpu". depth: "standard", "reversed" or "logarithmic". */
export async function rendererOf(kind, depth) {
  const key = `${kind} ${depth}`;
  if (renderers[key]) return renderers[key];
  const options = {
    antialias: false,
    preserveDrawingBuffer: true,
    reversedDepthBuffer: depth === "reversed",
    logarithmicDepthBuffer: depth === "logarithmic",
  };
  const renderer = ["webgl", "webgl-nodes"].includes(kind)
    ? new WebGLRenderer(options)
    : newNodeRenderer(kind, options);
  if (kind === "webgl-nodes") renderer.setNodesHandler(new WebGLNodesHandler());
  await renderer.init?.();
  document.body.append(renderer.domElement);
  return (renderers[key] = renderer);
}
export const objectOf = (kind, options) => new (kind === "webgl" ? forWebGL : forWebGPU).FvvObject3D(options);

export function pixels(source, { width, height }) {
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  context.drawImage(source, 0, 0);
  return context.getImageData(0, 0, width, height).data;
}

/**
 * RGBA of the scene as the renderer draws it, in display values. Chromium's WebGPU on the processor has no canvas to draw into: there
 * a target of linear light is read.
 */
export async function drawn(renderer, scene, camera, size) {
  if (!renderer.backend?.isWebGPUBackend) {
    renderer.render(scene, camera);
    return pixels(renderer.domElement, size);
  }
  const target = new RenderTarget(size.width, size.height, { type: FloatType });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  renderer.setRenderTarget(null);
  const light = await renderer.readRenderTargetPixelsAsync(target, 0, 0, size.width, size.height);
  target.dispose();
  const toDisplay = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
  return Uint8ClampedArray.from(light, (x, i) => 255 * (i % 4 === 3 ? x : toDisplay(x)));
}
