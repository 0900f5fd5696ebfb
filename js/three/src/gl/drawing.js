// The material for WebGLRenderer, with the shaders of @fvv/shading.

import { blending, projection, visibilityWeightsVertex } from "@fvv/shading";
import { DoubleSide, GLSL3, ShaderMaterial, UniformsLib, UniformsUtils } from "three";

import { Drawing, noLayers, noTexture, parametersOf, SHADOW } from "../drawing.js";
import { glDepthMaps } from "./depths.js";
import { PictureTexture } from "./pictures.js";

/** The shaders of three's material, built from those of @fvv/shading. */
const surfaceVertex = /* glsl */ `
out vec3 vPoint, vNormal;
out vec2 vUv;
#ifdef COLOURS
in vec4 vertexColour;
out vec3 vColour;
#endif
${visibilityWeightsVertex}
#include <common>
#include <logdepthbuf_pars_vertex>
#include <shadowmap_pars_vertex>
#include <fog_pars_vertex>
void main() {
  vPoint = position;
  vNormal = normal;
#ifdef ATLAS
  vUv = uv;
#endif
#ifdef COLOURS
  vColour = vertexColour.rgb;
#endif
  passVisibilityWeights();
  #include <beginnormal_vertex>
  #include <defaultnormal_vertex>
  #include <begin_vertex>
  #include <project_vertex>
  #include <logdepthbuf_vertex>
  #include <worldpos_vertex>
  #include <shadowmap_vertex>
  #include <fog_vertex>
}
`;

const surfaceFragment = /* glsl */ `
precision highp sampler2DArray;
uniform vec4 atlas; // x y width height, in texels of pictures
uniform float handedness;
in vec3 vPoint, vNormal;
in vec2 vUv;
#ifdef COLOURS
in vec3 vColour;
#else
const vec3 vColour = vec3(0.0);
#endif
layout(location = 0) out highp vec4 outColour;
#define gl_FragColor outColour
#include <common>
#include <logdepthbuf_pars_fragment>
#include <fog_pars_fragment>
#ifdef USE_SHADOWMAP
#include <packing>
#include <bsdfs>
#include <lights_pars_begin>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
#endif
${projection}
${blending}

void main() {
  #include <logdepthbuf_fragment>
#ifdef ATLAS
  vec3 colour = atlasColour(atlas, vUv);
#else
  // The front side by the winding of the face, not as the viewer sees it.
  vec3 faceNormal = normalize(cross(dFdx(vPoint), dFdy(vPoint))) * (gl_FrontFacing ? handedness : -handedness);
  vec3 colour = surfaceColour(vPoint, faceNormal, normalize(vNormal), vColour);
#endif
  // Cameras are mixed as display values; three continues in linear light and converts back at the end.
  outColour = sRGBTransferEOTF(vec4(colour, 1.0));
#ifdef USE_SHADOWMAP
  outColour.rgb *= mix(1.0, getShadowMask(), ${SHADOW.toFixed(2)});
#endif
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
  #include <fog_fragment>
}
`;

export class GlDrawing extends Drawing {
  constructor(given) {
    super(given);
    this.pictures = new PictureTexture();
    this.depths = glDepthMaps(this.geometry, this.views);
    this.uniforms = {
      // What three sets itself: shadows and fog of the scene.
      ...UniformsUtils.merge([UniformsLib.lights, UniformsLib.fog]),
      pictures: { value: noTexture },
      views: { value: this.views },
      visibilityWeights: { value: noTexture },
      depths: { value: noLayers },
      ...parametersOf((value) => ({ value })),
    };
    this.material = new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: surfaceVertex,
      fragmentShader: surfaceFragment,
      side: DoubleSide,
      // The colours are those of photographs, which have been tone mapped by the camera.
      toneMapped: false,
      lights: true,
      fog: true,
      defines: { WEIGHT_TEXELS: 0, BEST: 1 },
      uniforms: this.uniforms,
    });
  }

  get maxVaryings() {
    const gl = this.renderer.getContext();
    return gl.getParameter(gl.MAX_VARYING_VECTORS);
  }

  async ready() {}

  prepare(renderer, camera, mesh) {
    super.prepare(renderer, camera, mesh);
    this.material.uniformsNeedUpdate = true;
  }

  define(name, value) {
    const { defines } = this.material;
    if (defines[name] === value) return;
    if (value === undefined) delete defines[name];
    else defines[name] = value;
    this.material.needsUpdate = true;
  }
}
