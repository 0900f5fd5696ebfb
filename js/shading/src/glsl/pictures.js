// Draws pictures into the texture of all of them, pixel by pixel. place: the picture's corner in the target.

/** Converts 4:2:0 samples, 0 to 1, to display values. */
const display = /* glsl */ `
uniform vec3 range; // black, and the scales of luma and chroma
uniform float kr, kb;
layout(location = 0) out highp vec4 outColour;

vec4 display(float luma, vec2 chroma) {
  float y = (luma - range.x) * range.y;
  vec2 p = 2.0 * (1.0 - vec2(kb, kr)) * range.z * (chroma - 128.0 / 255.0);
  float green = y - (kb * p.x + kr * p.y) / (1.0 - kr - kb);
  return vec4(clamp(vec3(y + p.y, green, y + p.x), 0.0, 1.0), 1.0);
}
`;

/**
 * 4:2:0 to RGB. Chroma is interpolated. Its samples are in the middle of four pixels, as in all files of fvvmux; browsers
 * do not report their position.
 */
export const planesFragment = /* glsl */ `
uniform sampler2D Y, U, V;
uniform vec2 place;
${display}
void main() {
  vec2 at = gl_FragCoord.xy - place;
  vec2 chroma = at / 2.0 / vec2(textureSize(U, 0));
  outColour = display(texelFetch(Y, ivec2(at), 0).r, vec2(texture(U, chroma).r, texture(V, chroma).r));
}
`;

export const copyFragment = /* glsl */ `
uniform sampler2D picture;
uniform vec2 place;
layout(location = 0) out highp vec4 outColour;

void main() {
  outColour = vec4(texelFetch(picture, ivec2(gl_FragCoord.xy - place), 0).rgb, 1.0);
}
`;

/** Recovers the 4:2:0 samples, 0 to 255, from libyuv's RGB (see Replication in ../pictures.js). */
const samples = /* glsl */ `
uniform sampler2D picture;
uniform vec2 place;
uniform vec4 mixing; // in 64ths: U subtracts from green, adds to blue; V adds to red, subtracts from green
uniform vec2 luma; // in 64ths: a step of Y, and the offset of Y = 0

vec3 pixel(ivec2 at) {
  return round(255.0 * texelFetch(picture, clamp(at, ivec2(0), textureSize(picture, 0) - 1), 0).rgb);
}

// Clipped components carry no information and are used only if all are clipped.
vec3 certainty(vec3 rgb) {
  return 1e-4 + vec3(greaterThan(rgb, vec3(0.0))) * vec3(lessThan(rgb, vec3(255.0)));
}

// The contribution of chroma to red, green and blue.
vec3 added(vec2 uv) {
  return vec3(mixing.z * uv.y, -mixing.x * uv.x - mixing.w * uv.y, mixing.y * uv.x);
}

// U and V of a square of four pixels, minus 128.
vec2 chromaOf(ivec2 square) {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 4; i++) {
    vec3 rgb = pixel(2 * square + ivec2(i & 1, i >> 1));
    vec3 certain = certainty(rgb);
    sum += min(certain.r, min(certain.g, certain.b)) * vec3(rgb.b - rgb.g, rgb.r - rgb.g, 1.0);
  }
  vec2 over = 64.0 * sum.xy / sum.z; // blue and red, minus green
  mat2 more = mat2(mixing.x + mixing.y, mixing.x, mixing.w, mixing.z + mixing.w);
  return clamp(round(inverse(more) * over), -128.0, 127.0);
}

float lumaOf(vec3 rgb, vec2 uv) {
  vec3 certain = certainty(rgb);
  float sum = dot(certain, 64.0 * rgb + 32.0 - added(uv)) / dot(certain, vec3(1.0));
  return clamp(round((sum + 0.5 - luma.y) / luma.x), 0.0, 255.0);
}
`;

/** For RGB with replicated chroma: interpolates chroma as planesFragment does. */
export const replicatedFragment = /* glsl */ `
${samples}
${display}
void main() {
  vec2 at = gl_FragCoord.xy - place;
  ivec2 last = (textureSize(picture, 0) + 1) / 2 - 1;
  vec2 between = at / 2.0 - 0.5;
  ivec2 first = ivec2(floor(between));
  vec2 fraction = between - vec2(first);
  vec2 chroma = vec2(0.0);
  vec2 own = vec2(0.0);
  for (int i = 0; i < 4; i++) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    ivec2 square = clamp(first + corner, ivec2(0), last);
    vec2 uv = chromaOf(square);
    vec2 weight = mix(1.0 - fraction, fraction, vec2(corner));
    chroma += weight.x * weight.y * uv;
    if (square == ivec2(at) / 2) own = uv;
  }
  outColour = display(lumaOf(pixel(ivec2(at)), own) / 255.0, (chroma + 128.0) / 255.0);
}
`;

/** Red: the pixel is significant, because chroma changes here. Green: the pixel equals the result of replication. */
export const replicationFragment = /* glsl */ `
${samples}
layout(location = 0) out highp vec4 outColour;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy - place);
  vec2 uv = chromaOf(at / 2);
  vec2 change = max(abs(uv - chromaOf(at / 2 + ivec2(1, 0))), abs(uv - chromaOf(at / 2 + ivec2(0, 1))));
  vec3 rgb = pixel(at);
  bool tells = max(change.x, change.y) > 1.0 && all(greaterThan(certainty(rgb), vec3(0.5)));
  vec3 made = floor((floor(luma.x * lumaOf(rgb, uv)) + luma.y + added(uv)) / 64.0);
  outColour = vec4(float(tells), float(tells && made == rgb), 0.0, 1.0);
}
`;
