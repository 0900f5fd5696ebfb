// The depth maps' material and target for WebGLRenderer.

import { depthFragment, depthVertex } from "@fvv/shading";
import {
  DoubleSide,
  GLSL3,
  NearestFilter,
  NoBlending,
  RGBAFormat,
  ShaderMaterial,
  UnsignedByteType,
  Vector2,
  WebGLArrayRenderTarget,
} from "three";

import { DepthMaps } from "../depths.js";

const newTarget = (width, height, layers) =>
  new WebGLArrayRenderTarget(width, height, layers, {
    format: RGBAFormat,
    type: UnsignedByteType,
    minFilter: NearestFilter,
    magFilter: NearestFilter,
    generateMipmaps: false,
  });

export function glDepthMaps(geometry, viewTexture) {
  const uniforms = {
    views: { value: viewTexture },
    view: { value: 0 },
    layerSize: { value: new Vector2(1, 1) },
    nearPlane: { value: 0 },
  };
  const material = new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: depthVertex,
    fragmentShader: depthFragment,
    side: DoubleSide,
    blending: NoBlending,
    toneMapped: false,
    uniforms,
  });
  return new DepthMaps({ geometry, material, uniforms, newTarget });
}
