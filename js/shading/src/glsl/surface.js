// Shaders of the surface: projection through the cameras of the table of views, their depth maps, and the blending of the
// best cameras at a point, by the rules of docs/fvvrender.md. All coordinates are those of the stream; only the viewer's
// matrices include the surrounding scene.

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

/** For vertex shaders: passes on the visibility weights of the vertex, four cameras in each of WEIGHT_TEXELS varyings. */
export const visibilityWeightsVertex = /* glsl */ `
#if WEIGHT_TEXELS > 0
uniform highp sampler2D visibilityWeights;
out vec4 vVisibility[WEIGHT_TEXELS];
#endif

void passVisibilityWeights() {
#if WEIGHT_TEXELS > 0
  for (int i = 0; i < WEIGHT_TEXELS; i++) {
    int at = gl_VertexID * WEIGHT_TEXELS + i;
    vVisibility[i] = texelFetch(visibilityWeights, ivec2(at & 2047, at >> 11), 0);
  }
#endif
}
`;

/**
 * Follows projection in a fragment shader. WEIGHT_TEXELS: number of varyings with visibility weights. BEST: maximum number of
 * cameras at a point. SOFT: the weight of a camera falls to 0 where another one replaces it or it drops out (Buehler et al.,
 * "Unstructured Lumigraph Rendering", 2001).
 */
export const blending = /* glsl */ `
uniform highp sampler2D pictures;
uniform highp sampler2DArray depths;
uniform vec2 pictureSize;
uniform vec2 tolerance; // in pixel widths, and relative to the change of depth from pixel to pixel
uniform int viewCount;
uniform float threshold;
#if WEIGHT_TEXELS > 0
in vec4 vVisibility[WEIGHT_TEXELS];
#endif
#ifdef SOFT
uniform float soft; // 0 to 1
#define KEPT (BEST + 1)
#else
#define KEPT BEST
#endif

// Whether the mesh hides a point of a face; point and normal are in the camera's frame.
bool hidden(int view, vec3 at, vec3 normal) {
  vec4 plan = texel(view, 10), sizes = texel(view, 11);
  if (!(at.z >= 0.01)) return true;
  vec2 place = floor(at.xy / at.z * plan.xy + plan.zw);
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, sizes.xy))) return true;
  uvec4 bytes = uvec4(texelFetch(depths, ivec3(ivec2(place), view), 0) * 255.0 + 0.5);
  float nearest = uintBitsToFloat(bytes.x | bytes.y << 8 | bytes.z << 16 | bytes.w << 24);
  if (nearest == 0.0) return false;
  float facing = abs(dot(normal, at)) / at.z;
  float slope = facing > 0.0 ? at.z * length(normal.xy * sizes.zw) / facing : 0.0;
  return at.z > nearest + tolerance.x * at.z * max(sizes.z, sizes.w) + tolerance.y * slope;
}

uvec2 seenByVisibilityWeights() {
  uvec2 seen = uvec2(0u);
#if WEIGHT_TEXELS > 0
  for (int i = 0; i < WEIGHT_TEXELS; i++) {
    // 127.5 of 255
    uvec4 bits = uvec4(greaterThanEqual(vVisibility[i], vec4(0.5)));
    uint four = bits.x | bits.y << 1 | bits.z << 2 | bits.w << 3;
    if (i < 8) seen.x |= four << uint(4 * i);
    else seen.y |= four << uint(4 * (i - 8));
  }
#endif
  return seen;
}

// Whether a view shows the point; at: where, in texels of pictures.
bool shows(int view, vec3 point, vec3 faceNormal, uvec2 seen, out vec2 at) {
  vec3 inCamera = toCamera(view, point);
  vec4 source = texel(view, 8), place = texel(view, 9), centre = texel(view, 3);
  vec2 pixel;
  if (!toPicture(view, inCamera, pixel)) return false;
  vec2 inTile = (pixel - source.xy) * place.zw / source.zw;
  if (any(lessThan(inTile, vec2(0.5))) || any(greaterThan(inTile, place.zw - 0.5))) return false;
  if (!(dot(faceNormal, centre.xyz - point) > 0.0)) return false;
  at = place.xy + inTile;
  int flags = int(centre.w);
  if ((flags & BY_WEIGHTS) != 0 && ((view < 32 ? seen.x >> uint(view) : seen.y >> uint(view - 32)) & 1u) == 0u)
    return false;
  if ((flags & BY_DEPTH) == 0) return true;
  vec3 normalInCamera = vec3(dot(texel(view, 0).xyz, faceNormal), dot(texel(view, 1).xyz, faceNormal),
                             dot(texel(view, 2).xyz, faceNormal));
  return !hidden(view, inCamera, normalInCamera);
}

// The weight of a view at the point, or 0 where it is below the threshold.
float weightOf(int view, vec3 point, vec3 normal) {
  vec4 centre = texel(view, 3);
  if ((int(centre.w) & OFF) != 0) return 0.0;
  float weight = dot(normal, normalize(centre.xyz - point));
  return weight >= threshold ? weight : 0.0;
}

// The best views by descending weight: their numbers, weights, and where they show the point. chosen is -1 after the last.
void chooseViews(vec3 point, vec3 faceNormal, vec3 normal, out int chosen[KEPT], out float weights[KEPT],
                 out vec2 places[KEPT]) {
  uvec2 seen = seenByVisibilityWeights();
  for (int i = 0; i < KEPT; i++) chosen[i] = -1, weights[i] = 0.0, places[i] = vec2(0.0);
  // Software rasterisers execute both sides of branches and skip only loop iterations: first find the candidates.
  uvec2 facing = uvec2(0u);
  for (int view = 0; view < viewCount; view++) {
    uint bit = weightOf(view, point, normal) > 0.0 ? 1u << uint(view & 31) : 0u;
    facing |= view < 32 ? uvec2(bit, 0u) : uvec2(0u, bit);
  }
  while ((facing.x | facing.y) != 0u) {
    uint bits = facing.x != 0u ? facing.x : facing.y;
    uint lowest = bits & (~bits + 1u);
    int view = int(log2(float(lowest)) + 0.5) + (facing.x != 0u ? 0 : 32);
    facing ^= facing.x != 0u ? uvec2(lowest, 0u) : uvec2(0u, lowest);
    float weight = weightOf(view, point, normal);
    // Of equal weights the first one wins.
    if (!(weight > weights[KEPT - 1])) continue;
    vec2 at;
    if (!shows(view, point, faceNormal, seen, at)) continue;
    int i = KEPT - 1;
    for (; i > 0 && weight > weights[i - 1]; i--)
      chosen[i] = chosen[i - 1], weights[i] = weights[i - 1], places[i] = places[i - 1];
    chosen[i] = view, weights[i] = weight, places[i] = at;
  }
#ifdef SOFT
  float least = soft * max(threshold, weights[BEST]);
  for (int i = 0; i < BEST; i++) weights[i] = max(weights[i] - least, 1e-4 * weights[i]);
  weights[BEST] = 0.0;
#endif
}

/** The weighted mean of the best views, in display values; false if no view shows the point. */
bool blended(vec3 point, vec3 faceNormal, vec3 normal, out vec3 colour) {
  int chosen[KEPT];
  float weights[KEPT];
  vec2 places[KEPT];
  chooseViews(point, faceNormal, normal, chosen, weights, places);
  float sum = 0.0;
  colour = vec3(0.0);
  for (int i = 0; i < BEST; i++) {
    if (weights[i] == 0.0) break;
    sum += weights[i];
    colour += weights[i] * textureLod(pictures, places[i] / pictureSize, 0.0).rgb;
  }
  if (!(sum > 0.0)) return false;
  colour /= sum;
  return true;
}
`;

/**
 * Follows blending in a fragment shader: the colour of a point that no view shows. COLOURS: the mesh has colours of vertices,
 * interpolated in colour. Without any view the surface is shaded, as if the viewer at eye held a light.
 */
export const withoutCameras = /* glsl */ `
uniform vec3 unseen;

vec3 withoutCameras(vec3 point, vec3 normal, vec3 eye, vec3 colour) {
#ifndef COLOURS
  colour = unseen;
#endif
  return viewCount > 0 ? colour : colour * (0.6 + 0.4 * max(dot(normal, normalize(eye - point)), 0.0));
}
`;
