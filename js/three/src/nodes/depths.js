// The depth maps' material and target for WebGPURenderer.

import {
  DoubleSide,
  FloatType,
  NearestFilter,
  NoBlending,
  NodeMaterial,
  RedFormat,
  RenderTarget,
  Vector2,
} from "three/webgpu";
import { WebGLArrayRenderTarget } from "three";
import { Fn, float, positionGeometry, uniform, varyingProperty, vec4 } from "three/tsl";

import { DepthMaps } from "../depths.js";
import { toCamera, toDepthMap } from "./projection.js";

// A number per texel: WebGL 2 has an extension that draws into such textures, for which three asks.
const FORM = {
  format: RedFormat,
  type: FloatType,
  minFilter: NearestFilter,
  magFilter: NearestFilter,
  generateMipmaps: false,
};

/** Layers of WebGLRenderer are of a class of their own. */
const targetsOf = (renderer) => (width, height, layers) =>
  renderer.isWebGPURenderer
    ? new RenderTarget(width, height, { ...FORM, depth: layers })
    : new WebGLArrayRenderTarget(width, height, layers, FORM);

/** Linear depth; 0: no surface. views: node of the table of views. depthRange: see toDepthMap. */
export function nodeDepthMaps({ renderer, geometry }, views, depthRange) {
  const uniforms = { view: uniform(0, "int"), layerSize: uniform(new Vector2(1, 1)), nearPlane: uniform(0) };
  const material = new NodeMaterial();
  material.side = DoubleSide;
  material.blending = NoBlending;
  material.fog = false;
  const depth = varyingProperty("float", "vDepth");
  material.vertexNode = Fn(() => {
    const at = toCamera(views, uniforms.view, positionGeometry).toVar();
    depth.assign(at.z);
    return toDepthMap(views, uniforms.view, at, uniforms.layerSize, uniforms.nearPlane, depthRange);
  })();
  material.fragmentNode = vec4(depth, float(0), float(0), float(1));
  return new DepthMaps({ geometry, material, uniforms, newTarget: targetsOf(renderer) });
}
