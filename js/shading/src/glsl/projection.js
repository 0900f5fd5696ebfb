// Projection through the cameras of the table of views, and their depth maps. All coordinates are those of the stream; only
// the viewer's matrices include the surrounding scene.

/**
 * Within the ranges of clause 9.1, as libfvv projects. A view's row: 0 to 2 rotation and translation, 3 centre and flags, 4 fx
 * fy cx cy, 5 skew, rMax, lens and number, 6 and 7 distortion, 8 source, 9 place in the texture of pictures, 10 scale and
 * offset of the depth map, 11 its size and the width of a pixel at a distance of 1.
 */
export const projection = /* glsl */ `
uniform highp sampler2D views;

const int BY_WEIGHTS = 1, BY_DEPTH = 2, OFF = 4;

vec4 texel(int view, int i) { return texelFetch(views, ivec2(i, view), 0); }

vec3 toCamera(int view, vec3 point) {
  vec4 p = vec4(point, 1.0);
  return vec3(dot(texel(view, 0), p), dot(texel(view, 1), p), dot(texel(view, 2), p));
}

// Pixel of the camera's picture. false: behind the camera or beyond the range of its lens.
bool toPicture(int view, vec3 at, out vec2 pixel) {
  if (!(at.z > 0.0)) return false;
  vec4 intrinsics = texel(view, 4), more = texel(view, 5), k = texel(view, 6), l = texel(view, 7);
  vec2 q = at.xy / at.z;
  float r = length(q);
  if (more.z > 1.5) {
    float angle = atan(r);
    if (r > 0.0) q *= angle / r;
    r = angle;
  }
  if (!(r <= more.y)) return false;
  float s = r * r;
  vec2 d = q;
  if (more.z > 1.5) {
    d = q * (1.0 + s * (k.x + s * (k.y + s * (k.z + s * k.w))));
  } else if (more.z > 0.5) {
    float h = (1.0 + s * (k.x + s * (k.y + s * l.x))) / (1.0 + s * (l.y + s * (l.z + s * l.w)));
    d = q * h + s * k.wz + 2.0 * dot(q, k.wz) * q;
  }
  pixel = vec2(intrinsics.x * d.x + more.x * d.y + intrinsics.z, intrinsics.y * d.y + intrinsics.w);
  return true;
}

// Clip coordinates of a point in a view's frame in its layer of depth maps, clipped at 1 cm, without a far plane.
vec4 toDepthMap(int view, vec3 at, vec2 layerSize) {
  vec4 plan = texel(view, 10);
  return vec4(2.0 * (at.xy * plan.xy + plan.zw * at.z) / layerSize - at.z, at.z - 0.02, at.z);
}
`;

/** Draws one view's depth map, without its lens. Needs the attribute position. */
export const depthVertex = /* glsl */ `
uniform int view;
uniform vec2 layerSize;
out float vDepth;
${projection}
void main() {
  vec3 at = toCamera(view, position);
  vDepth = at.z;
  gl_Position = toDepthMap(view, at, layerSize);
}
`;

/** Linear depth as the bytes of a float: every WebGL 2 can draw into such textures. 0: no surface. */
export const depthFragment = /* glsl */ `
in float vDepth;
layout(location = 0) out highp vec4 outBytes;

void main() {
  uint bits = floatBitsToUint(vDepth);
  outBytes = vec4((uvec4(bits) >> uvec4(0, 8, 16, 24)) & 255u) / 255.0;
}
`;
