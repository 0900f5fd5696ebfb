// Pictures into the texture of all of them, pixel by pixel. place: of the picture's corner in the target.

/**
 * 4:2:0 to RGB. Chroma is interpolated and stands in the middle of four pixels, as in all that fvvmux writes: browsers do
 * not tell where.
 */
export const planesFragment = /* glsl */ `
uniform sampler2D Y, U, V;
uniform vec2 place;
uniform vec3 range; // black, and scales of luma and chroma
uniform float kr, kb;
layout(location = 0) out highp vec4 outColour;

void main() {
  vec2 at = gl_FragCoord.xy - place;
  vec2 chroma = at / 2.0 / vec2(textureSize(U, 0));
  float y = (texelFetch(Y, ivec2(at), 0).r - range.x) * range.y;
  float pb = 2.0 * (1.0 - kb) * range.z * (texture(U, chroma).r - 128.0 / 255.0);
  float pr = 2.0 * (1.0 - kr) * range.z * (texture(V, chroma).r - 128.0 / 255.0);
  float green = y - (kb * pb + kr * pr) / (1.0 - kr - kb);
  outColour = vec4(clamp(vec3(y + pr, green, y + pb), 0.0, 1.0), 1.0);
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
