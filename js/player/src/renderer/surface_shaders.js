// Shaders of the surface: what its cameras show of it, or one of the ways to look at how that comes about.

import { blending, projection, sharesVertex } from "@fvv/shading";

/** MODE of the fragment shader. */
export const MODES = { textured: 0, weights: 1, visibility: 2, normals: 3, depth: 4, wireframe: 5 };

const vertex = /* glsl */ `
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
uniform mat4 worldToClip;
invariant gl_Position;
out vec3 vPoint, vNormal;
out vec2 vUv;
out float vDepth;
${sharesVertex}
void main() {
  vPoint = position;
  vNormal = normal;
  vUv = uv;
  passShares();
  gl_Position = worldToClip * vec4(position, 1.0);
  vDepth = gl_Position.w;
}
`;

const fragment = /* glsl */ `
uniform vec4 atlas; // x y width height, in texels of pictures
uniform vec2 depthRange;
uniform vec3 unseen, eye;
uniform mat3 pixelToRay; // of gl_FragCoord
in vec3 vPoint, vNormal;
in vec2 vUv;
in float vDepth;
layout(location = 0) out highp vec4 outColour;
${projection}
${blending}

// Where the ray through the middle of the pixel meets the face. Rasterisers round corners to a sixteenth of a pixel, and
// what they interpolate is off by as much.
vec3 exactPoint(vec3 faceNormal) {
  vec3 ray = pixelToRay * vec3(gl_FragCoord.xy, 1.0);
  vec3 point = eye + ray * (dot(faceNormal, vPoint - eye) / dot(faceNormal, ray));
  // Faces that are seen edge-on have no such place.
  return distance(point, vPoint) < 0.1 * (length(dFdx(vPoint)) + length(dFdy(vPoint))) ? point : vPoint;
}

// A colour of its own for each camera: hues a golden section apart.
vec3 cameraColour(int view) {
  float hue = fract(texel(view, 5).w * 0.61803399);
  return 0.15 + 0.8 * clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
}

#if MODE == 0
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal) {
#ifdef ATLAS
  vec2 at = atlas.xy + clamp(vUv * atlas.zw, vec2(0.5), atlas.zw - 0.5);
  return textureLod(pictures, at / pictureSize, 0.0).rgb;
#else
  vec3 colour;
  return blended(point, faceNormal, normal, colour) ? colour : unseen;
#endif
}
#elif MODE == 1
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal) {
  int chosen[KEPT];
  float weights[KEPT];
  vec2 places[KEPT];
  chooseViews(point, faceNormal, normal, chosen, weights, places);
  vec3 colour = vec3(0.0);
  float sum = 0.0;
  for (int i = 0; i < BEST && weights[i] > 0.0; i++) {
    colour += weights[i] * cameraColour(chosen[i]);
    sum += weights[i];
  }
  return sum > 0.0 ? colour / sum : unseen;
}
#elif MODE == 2
// How many of the cameras show the place, from blue to yellow; dark red, without green, where none does.
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal) {
  uvec2 seen = seenByShares();
  int count = 0, all = 0;
  for (int view = 0; view < viewCount; view++) {
    all += (int(texel(view, 3).w) & OFF) == 0 ? 1 : 0;
    vec2 at;
    if (weightOf(view, point, normal) > 0.0 && shows(view, point, faceNormal, seen, at)) count++;
  }
  float share = float(count) / float(max(all, 1));
  return count == 0 ? vec3(0.4, 0.0, 0.0) : mix(vec3(0.05, 0.25, 0.75), vec3(1.0, 0.9, 0.2), min(1.0, 2.0 * share));
}
#elif MODE == 3
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal) { return 0.5 + 0.5 * normal; }
#elif MODE == 4
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal) {
  return vec3(mix(1.0, 0.08, clamp((vDepth - depthRange.x) / (depthRange.y - depthRange.x), 0.0, 1.0)));
}
#else
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal) {
  return vec3(0.10, 0.11, 0.13) * (0.5 + abs(dot(faceNormal, normalize(eye - point))));
}
#endif

void main() {
  // Front, as the faces wind, and not as the viewer sees it.
  vec3 faceNormal = normalize(cross(dFdx(vPoint), dFdy(vPoint))) * (gl_FrontFacing ? 1.0 : -1.0);
  outColour = vec4(shaded(exactPoint(faceNormal), faceNormal, normalize(vNormal)), 1.0);
}
`;

export const surface = { vertex, fragment };

/** What the surface hides, before its colours are found: these are dear. */
export const cover = {
  vertex,
  fragment: /* glsl */ `
layout(location = 0) out highp vec4 outColour;
void main() { outColour = vec4(0.0); }
`,
};

export const wires = {
  vertex,
  fragment: /* glsl */ `
layout(location = 0) out highp vec4 outColour;
void main() { outColour = vec4(0.62, 0.74, 0.85, 1.0); }
`,
};
