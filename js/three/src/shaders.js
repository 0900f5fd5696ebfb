// The shaders of three's materials, built from those of @fvv/shading.

import { blending, projection, visibilityWeightsVertex } from "@fvv/shading";

export const surfaceVertex = /* glsl */ `
out vec3 vPoint, vNormal;
out vec2 vUv;
${visibilityWeightsVertex}
void main() {
  vPoint = position;
  vNormal = normal;
#ifdef ATLAS
  vUv = uv;
#endif
  passVisibilityWeights();
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}
`;

export const surfaceFragment = /* glsl */ `
precision highp sampler2DArray;
uniform vec4 atlas; // x y width height, in texels of pictures
uniform float handedness;
uniform vec3 unseen;
in vec3 vPoint, vNormal;
in vec2 vUv;
layout(location = 0) out highp vec4 outColour;
#define gl_FragColor outColour
${projection}
${blending}

void main() {
  vec3 colour;
#ifdef ATLAS
  vec2 at = atlas.xy + clamp(vUv * atlas.zw, vec2(0.5), atlas.zw - 0.5);
  colour = textureLod(pictures, at / pictureSize, 0.0).rgb;
#else
  // The front side by the winding of the face, not as the viewer sees it.
  vec3 faceNormal = normalize(cross(dFdx(vPoint), dFdy(vPoint))) * (gl_FrontFacing ? handedness : -handedness);
  if (!blended(vPoint, faceNormal, normalize(vNormal), colour)) colour = unseen;
#endif
  // Cameras are mixed as display values; three continues in linear light and converts back at the end.
  outColour = sRGBTransferEOTF(vec4(colour, 1.0));
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

export const wholeVertex = /* glsl */ `
void main() {
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;
