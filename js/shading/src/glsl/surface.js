// Shaders of the surface: projection through the cameras of the table of views, their depth maps, and the blending of the
// best cameras at a point, by the rules of docs/tools/fvvrender.md. All coordinates are those of the stream, relative to
// originOf; only the viewer's matrices include the surrounding scene.
//
// Software rasterisers execute both sides of branches and skip only loops, and are slow with arrays whose index is not
// constant. Where fragments choose among cameras, branches are selections, and loops over registers are written out.

import { APART, BORDER, FADE } from "../camera_rule.js";
import { LEVELS, MAX_BEST, MAX_VIEWS, SHARP } from "../views.js";

/**
 * Within the ranges of clause 9.1, as libfvv projects. LENSES: what lenses the views have, see definesOf; default: any. A view's
 * row: 0 to 2 rotation and translation, 3 centre and flags, 4 fx fy cx cy, 5 skew, rMax, lens and number, 6 and 7 distortion,
 * 8 source, 9 place in the texture of pictures, 10 scale and offset of the depth map, 11 its size and the width of a pixel at
 * a distance of 1.
 */
export const projection = /* glsl */ `
#ifndef LENSES
#define LENSES 2
#endif
uniform highp sampler2D views;
uniform float nearPlane; // nearPlaneOf

const int BY_WEIGHTS = 1, BY_DEPTH = 2, OFF = 4;

vec4 texel(int view, int i) { return texelFetch(views, ivec2(i, view), 0); }

vec3 toCamera(int view, vec3 point) {
  vec4 p = vec4(point, 1.0);
  return vec3(dot(texel(view, 0), p), dot(texel(view, 1), p), dot(texel(view, 2), p));
}

// Pixel of the camera's picture. false: behind the camera or beyond the range of its lens.
bool toPicture(int view, vec3 at, out vec2 pixel) {
  vec4 intrinsics = texel(view, 4), more = texel(view, 5);
  vec2 q = at.xy / at.z;
  float r = length(q);
#if LENSES > 1
  if (more.z > 1.5) {
    float angle = atan(r);
    if (r > 0.0) q *= angle / r;
    r = angle;
  }
#endif
  vec2 d = q;
#if LENSES > 0
  vec4 k = texel(view, 6), l = texel(view, 7);
  float s = r * r;
  if (more.z > 1.5) {
    d = q * (1.0 + s * (k.x + s * (k.y + s * (k.z + s * k.w))));
  } else if (more.z > 0.5) {
    float h = (1.0 + s * (k.x + s * (k.y + s * l.x))) / (1.0 + s * (l.y + s * (l.z + s * l.w)));
    d = q * h + s * k.wz + 2.0 * dot(q, k.wz) * q;
  }
#endif
  pixel = vec2(intrinsics.x * d.x + more.x * d.y + intrinsics.z, intrinsics.y * d.y + intrinsics.w);
  return at.z > 0.0 && r <= more.y;
}

// Clip coordinates of a point in a view's frame in its layer of depth maps, clipped at nearPlane, without a far plane.
vec4 toDepthMap(int view, vec3 at, vec2 layerSize) {
  vec4 plan = texel(view, 10);
  return vec4(2.0 * (at.xy * plan.xy + plan.zw * at.z) / layerSize - at.z, at.z - 2.0 * nearPlane, at.z);
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
#ifdef USE_REVERSED_DEPTH_BUFFER
  // As three.js defines it: depths from 1, near, to 0.
  gl_Position.z = 0.5 * (gl_Position.w - gl_Position.z);
#endif
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

/** The most texels with a number for each of four views. */
const MOST_BLOCKS = MAX_VIEWS / 4;

const unrolled = (count, text) => Array.from({ length: count }, (_, i) => text(i)).join("\n");
/** text(block), for each block of four views that there is. */
const everyBlock = (text) => unrolled(MOST_BLOCKS, (i) => `#if VIEW_BLOCKS > ${i}\n${text(i)}\n#endif`);

const everyKept = (text) => unrolled(MAX_BEST + 1, (i) => `#if KEPT > ${i}\n${text(i)}\n#endif`);
const everyBest = (text) => unrolled(MAX_BEST, (i) => `#if BEST > ${i}\n${text(i)}\n#endif`);

/** The limits of four views. */
const limitsOfBlock = (block) => /* glsl */ `
  {
    vec4 visibility = vec4(0.0);
#if WEIGHT_TEXELS > ${block}
    visibility = vVisibility[${block}];
#endif
    const ivec4 four = ivec4(${[0, 1, 2, 3].map((i) => 4 * block + i)});
    vec4 limit, facing;
    limit.x = limitOf(texel(four.x, 3), point, normal, towardsEye, visibility.x, facing.x);
    limit.y = limitOf(texel(four.y, 3), point, normal, towardsEye, visibility.y, facing.y);
    limit.z = limitOf(texel(four.z, 3), point, normal, towardsEye, visibility.z, facing.z);
    limit.w = limitOf(texel(four.w, 3), point, normal, towardsEye, visibility.w, facing.w);
    limits[${block}] = mix(vec4(0.0), limit, lessThan(four, ivec4(viewCount)));
    facings[${block}] = facing;
  }`;

/** Takes the first view with the largest limit out of limits, if that is more than the weight of the last view that is kept. */
const takeNext = /* glsl */ `
    limit = weights[KEPT - 1], facing = 0.0, view = -1.0;
${everyBlock((block) =>
  unrolled(
    4,
    (i) => `    more = limits[${block}][${i}] > limit;
    limit = mix(limit, limits[${block}][${i}], more);
    facing = mix(facing, facings[${block}][${i}], more);
    view = mix(view, ${4 * block + i}.0, more);`,
  ),
)}
${everyBlock(
  (block) =>
    `    limits[${block}] = mix(limits[${block}], vec4(0.0), equal(vec4(${[0, 1, 2, 3].map((i) => 4 * block + i)}), vec4(view)));`,
)}`;

/** Puts a view into its place among those that are kept. */
const insert = unrolled(MAX_BEST + 1, (fromLast) => {
  const i = MAX_BEST - fromLast;
  const values = { weights: "weight", numbers: "view", certain: "certainty", places: "at" };
  const assign = (to, of) =>
    Object.keys(values)
      .map((name) => {
        const condition = name === "places" ? "bvec2(more)" : "more";
        return `    ${name}[${to}] = mix(${name}[${to}], ${of(name)}, ${condition});`;
      })
      .join("\n");
  return `#if KEPT > ${i}
    more = weight > weights[${i}];
#if KEPT > ${i + 1}
${assign(i + 1, (name) => `${name}[${i}]`)}
#endif
${assign(i, (name) => values[name])}
#endif`;
});

/**
 * Follows projection in a fragment shader. WEIGHT_TEXELS: number of varyings with visibility weights. BEST: maximum number of
 * cameras at a point. PAPER: defined if cameras are weighted by the normal alone; COLOURS: if the mesh has colours of vertices,
 * which are shown where no camera shows the surface; see clauses 17.5 and 19 of the format. LEVELS: if pictures are sampled at
 * levels, for which see usesLevels. INSET: if the inset is not 0. VIEW_BLOCKS and DEPTHS: see definesOf.
 */
export const blending = /* glsl */ `
uniform highp sampler2D pictures;
uniform highp sampler2DArray depths;
uniform vec2 pictureSize;
uniform vec2 tolerance; // in pixel widths, and relative to the change of depth from pixel to pixel
uniform int viewCount;
uniform float threshold;
#ifdef INSET
uniform float inset; // from the mesh inward to the surface that cameras show
#endif
uniform vec3 unseen;
uniform vec3 eye, viewerRight, viewerUp; // the viewer's place and axes
#ifdef LEVELS
uniform float pixelAngle; // width of a pixel of the viewer's picture at a distance of 1
#endif
#if WEIGHT_TEXELS > 0
in vec4 vVisibility[WEIGHT_TEXELS];
#endif
#ifdef PAPER
#define KEPT BEST
#else
#define KEPT (BEST + 1) // the weight of the last one is subtracted from the others
#endif

// Whether the mesh hides a point of a face; point and normal are in the camera's frame.
bool hidden(int view, vec3 at, vec3 normal) {
  vec4 plan = texel(view, 10), sizes = texel(view, 11);
  if (!(at.z >= nearPlane)) return true;
  vec2 place = floor(at.xy / at.z * plan.xy + plan.zw);
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, sizes.xy))) return true;
  uvec4 bytes = uvec4(texelFetch(depths, ivec3(ivec2(place), view), 0) * 255.0 + 0.5);
  float nearest = uintBitsToFloat(bytes.x | bytes.y << 8 | bytes.z << 16 | bytes.w << 24);
  if (nearest == 0.0) return false;
  float facing = abs(dot(normal, at)) / at.z;
  float slope = facing > 0.0 ? at.z * length(normal.xy * sizes.zw) / facing : 0.0;
  return at.z > nearest + tolerance.x * at.z * max(sizes.z, sizes.w) + tolerance.y * slope;
}

// Where pictures show a point of the mesh.
vec3 shownPlace(vec3 point, vec3 normal) {
#ifdef INSET
  vec3 towardsEye = normalize(eye - point);
  point -= towardsEye * (inset / max(dot(normal, towardsEye), 0.5));
#endif
  return point;
}

// How well the picture of a view shows the point, 0 to 1, its visibility weight aside; shown: its shownPlace; at: where, in
// texels of pictures.
float shows(int view, vec3 point, vec3 shown, vec3 faceNormal, out vec2 at) {
  vec4 source = texel(view, 8), place = texel(view, 9);
  vec2 pixel;
  bool isThere = toPicture(view, toCamera(view, shown), pixel);
  vec2 inTile = (pixel - source.xy) * place.zw / source.zw;
  at = place.xy + inTile;
  vec2 nearest = min(inTile, place.zw - inTile) - 0.5;
  float inside = min(nearest.x, nearest.y); // pixels to the usable border
#ifdef DEPTHS
  vec4 centre = texel(view, 3);
  if ((int(centre.w) & BY_DEPTH) != 0) {
    vec3 normalInCamera = vec3(dot(texel(view, 0).xyz, faceNormal), dot(texel(view, 1).xyz, faceNormal),
                               dot(texel(view, 2).xyz, faceNormal));
    bool faces = dot(faceNormal, centre.xyz - point) > 0.0;
    isThere = isThere && faces && !hidden(view, toCamera(view, point), normalInCamera);
  }
#endif
#ifdef PAPER
  return isThere && inside >= 0.0 ? 1.0 : 0.0;
#else
  return isThere ? clamp(inside / ${BORDER}.0, 0.0, 1.0) : 0.0;
#endif
}

// What the weight is divided by for the angle between a view and the viewer.
float apartness(vec3 ray, vec3 towardsEye) {
  float apart = ${APART} - dot(ray, towardsEye);
  return apart * apart;
}

// The most that a view can weigh at a point: without looking at its picture, which can only take from it. 0: it is not used
// there. centre: texel 3 of the view; visibility: its visibility weight. facing: the limit without the angle to the viewer.
float limitOf(vec4 centre, vec3 point, vec3 normal, vec3 towardsEye, float visibility, out float facing) {
  vec3 away = centre.xyz - point;
  vec3 ray = away * inversesqrt(dot(away, away));
  int flags = int(centre.w);
  float cosine = dot(normal, ray);
#ifdef PAPER
  facing = cosine >= threshold ? max(0.0, cosine) : 0.0;
#else
  facing = max(0.0, (cosine - threshold) / (1.0 - threshold));
#endif
#if WEIGHT_TEXELS > 0
  // A weight of one half is 127.5 of 255.
#ifdef PAPER
  float sees = step(0.5, visibility);
#else
  float sees = max(0.0, 2.0 * visibility - 1.0);
#endif
  facing *= (flags & BY_WEIGHTS) == 0 ? 1.0 : sees;
#endif
  facing *= (flags & OFF) == 0 ? 1.0 : 0.0;
#ifdef PAPER
  return facing;
#else
  return facing / apartness(ray, towardsEye);
#endif
}

// limitOf all views, 0 for those that do not exist.
void limitsAt(vec3 point, vec3 normal, vec3 towardsEye, out vec4 limits[VIEW_BLOCKS], out vec4 facings[VIEW_BLOCKS]) {
${everyBlock(limitsOfBlock)}
}

// The best views by descending weight: their numbers, weights, and where they show the point. chosen is -1 after the last.
// Returns the share of their colour where the surface has a colour of its own.
float chooseViews(vec3 point, vec3 faceNormal, vec3 normal, out int chosen[KEPT], out float weights[KEPT],
                  out vec2 places[KEPT]) {
  float numbers[KEPT], certain[KEPT];
${everyKept((i) => `  numbers[${i}] = -1.0, weights[${i}] = certain[${i}] = 0.0, places[${i}] = vec2(0.0);`)}
  vec3 shown = shownPlace(point, normal);
  vec4 limits[VIEW_BLOCKS], facings[VIEW_BLOCKS];
  limitsAt(point, normal, normalize(eye - point), limits, facings);
  // By descending limit, until no other view can be kept. Of equal weights the first one wins.
  float limit, facing, view;
  bool more;
${takeNext}
  while (view >= 0.0) {
    vec2 at;
    float showing = shows(int(view), point, shown, faceNormal, at);
    float weight = limit * showing, certainty = facing * showing;
${insert}
${takeNext}
  }
${everyKept((i) => `  chosen[${i}] = int(numbers[${i}]);`)}
#ifdef PAPER
  return 1.0;
#else
  float next = weights[BEST] * ${FADE};
  float sum = 0.0, certainty = 0.0;
${everyBest(
  (i) => `  weights[${i}] = max(0.0, weights[${i}] - next);
  sum += weights[${i}];
  certainty += weights[${i}] * certain[${i}];`,
)}
  weights[BEST] = 0.0;
#ifdef COLOURS
  return sum > 0.0 ? min(1.0, 10.0 * certainty / sum) : 1.0;
#else
  return 1.0;
#endif
#endif
}

// What a surface without pictures is multiplied by, so that its shape can be seen: a lamp at the viewer's left shoulder, and
// a sky above a darker ground.
float lightAt(vec3 point, vec3 normal) {
  vec3 towardsEye = normalize(eye - point);
  vec3 n = dot(normal, towardsEye) < 0.0 ? -normal : normal;
  float lamp = max(0.0, dot(n, normalize(towardsEye + 0.6 * viewerUp - 0.5 * viewerRight)));
  return 0.38 + 0.3 * (0.5 + 0.5 * dot(n, viewerUp)) + 0.62 * lamp;
}

#ifdef LEVELS
// The level for a number of texels that a pixel is wide. Sharp pictures are worth a little aliasing: up to SHARP texels.
float levelFor(float texels) { return clamp(log2(texels / ${SHARP.toFixed(2)}), 0.0, ${(LEVELS - 1).toFixed(1)}); }
#endif

vec3 pictureColour(vec2 at, float level) { return textureLod(pictures, at / pictureSize, level).rgb; }

// The colour that a view shows at a point; at: where, in texels of pictures.
vec3 viewColour(int view, vec3 point, vec2 at) {
#ifdef LEVELS
  float width = distance(texel(view, 3).xyz, point) * texel(view, 8).z / (texel(view, 9).z * texel(view, 4).x);
  return pictureColour(at, levelFor(distance(eye, point) * pixelAngle / width));
#else
  return pictureColour(at, 0.0);
#endif
}

// The colour of an atlas, whose place in the texture of pictures is x y width height.
vec3 atlasColour(vec4 atlas, vec2 uv) {
  vec2 at = atlas.xy + clamp(uv * atlas.zw, vec2(0.5), atlas.zw - 0.5);
#ifdef LEVELS
  vec2 dx = dFdx(uv) * atlas.zw, dy = dFdy(uv) * atlas.zw;
  return pictureColour(at, levelFor(sqrt(max(dot(dx, dx), dot(dy, dy)))));
#else
  return pictureColour(at, 0.0);
#endif
}

// The colour of a point as display values. own: the colour of the vertices, interpolated, if COLOURS is defined.
vec3 surfaceColour(vec3 point, vec3 faceNormal, vec3 normal, vec3 own) {
#ifndef COLOURS
  own = unseen;
#endif
  if (viewCount == 0) return own * lightAt(point, normal);
  int chosen[KEPT];
  float weights[KEPT];
  vec2 places[KEPT];
  float share = chooseViews(point, faceNormal, normal, chosen, weights, places);
  float sum = 0.0;
  vec3 colour = vec3(0.0);
${everyBest(
  (i) => `  sum += weights[${i}];
  colour += weights[${i}] * viewColour(chosen[${i}], point, places[${i}]);`,
)}
  return sum > 0.0 ? mix(own, colour / sum, share) : own;
}
`;
