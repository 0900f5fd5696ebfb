// The shaders: what docs/fvvrender.md says a player draws, for each fragment. Everything is in the coordinates of the
// stream, which are those of the object; only the viewer's matrices know of the scene around it.

/** Of the ranges of clause 9.1, as libfvv projects. Reads rows of ViewTexture. */
const project = /* glsl */ `
uniform highp sampler2D views;

vec4 texel(int view, int i) { return texelFetch(views, ivec2(i, view), 0); }

vec3 toCamera(int view, vec3 point) {
  vec4 p = vec4(point, 1.0);
  return vec3(dot(texel(view, 0), p), dot(texel(view, 1), p), dot(texel(view, 2), p));
}

// Pixel of the camera's picture. false: behind the camera or beyond its lens.
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
`;

export const surfaceVertex = /* glsl */ `
#if SHARES > 0
uniform highp sampler2D shares;
out vec4 vShares[SHARES];
#endif
out vec3 vPoint, vNormal;
out vec2 vUv;

void main() {
  vPoint = position;
  vNormal = normal;
#ifdef ATLAS
  vUv = uv;
#endif
#if SHARES > 0
  for (int i = 0; i < SHARES; i++) {
    int at = gl_VertexID * SHARES + i;
    vShares[i] = texelFetch(shares, ivec2(at & 2047, at >> 11), 0);
  }
#endif
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}
`;

const visibility = /* glsl */ `
uniform highp sampler2DArray depths;
uniform vec2 tolerance; // in pixels' breadths, and in what the surface recedes from pixel to pixel

// A point of a face whose normal is given in the camera's frame; whether the mesh stands in front of it.
bool hidden(int view, vec3 at, vec3 normal) {
  vec4 plan = texel(view, 10), sizes = texel(view, 11);
  if (!(at.z >= 0.01)) return true;
  vec2 place = floor(at.xy / at.z * plan.xy + plan.zw);
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, sizes.xy))) return true;
  uvec4 bytes = uvec4(texelFetch(depths, ivec3(ivec2(place), view), 0) * 255.0 + 0.5);
  float nearest = uintBitsToFloat(bytes.x | bytes.y << 8 | bytes.z << 16 | bytes.w << 24);
  if (nearest == 0.0) return false;
  float facing = abs(dot(normal, at)) / at.z;
  float recede = facing > 0.0 ? at.z * length(normal.xy * sizes.zw) / facing : 0.0;
  return at.z > nearest + tolerance.x * at.z * max(sizes.z, sizes.w) + tolerance.y * recede;
}
`;

export const surfaceFragment = /* glsl */ `
precision highp sampler2DArray;
uniform sampler2D pictures;
uniform vec2 pictureSize;
uniform vec4 atlas; // x y width height, in texels of pictures
uniform int viewCount;
uniform float threshold, handedness;
uniform vec3 unseen;
#if SHARES > 0
in vec4 vShares[SHARES];
#endif
in vec3 vPoint, vNormal;
in vec2 vUv;
layout(location = 0) out highp vec4 outColour;
#define gl_FragColor outColour
${project}
${visibility}

uvec2 seenByShares() {
  uvec2 seen = uvec2(0u);
#if SHARES > 0
  for (int i = 0; i < SHARES; i++) {
    // 127.5 of 255
    uvec4 bits = uvec4(greaterThanEqual(vShares[i], vec4(0.5)));
    uint four = bits.x | bits.y << 1 | bits.z << 2 | bits.w << 3;
    if (i < 8) seen.x |= four << uint(4 * i);
    else seen.y |= four << uint(4 * (i - 8));
  }
#endif
  return seen;
}

// Whether a view can show the point; at: where, in texels of pictures.
bool shows(int view, vec3 faceNormal, uvec2 seen, out vec2 at) {
  vec3 inCamera = toCamera(view, vPoint);
  vec4 source = texel(view, 8), place = texel(view, 9), centre = texel(view, 3);
  vec2 pixel;
  if (!toPicture(view, inCamera, pixel)) return false;
  vec2 inTile = (pixel - source.xy) * place.zw / source.zw;
  if (any(lessThan(inTile, vec2(0.5))) || any(greaterThan(inTile, place.zw - 0.5))) return false;
  if (!(dot(faceNormal, centre.xyz - vPoint) > 0.0)) return false;
  at = place.xy + inTile;
  if (centre.w > 0.5) return ((view < 32 ? seen.x >> uint(view) : seen.y >> uint(view - 32)) & 1u) != 0u;
  if (texel(view, 5).w < 0.5) return true;
  vec3 normalInCamera = vec3(dot(texel(view, 0).xyz, faceNormal), dot(texel(view, 1).xyz, faceNormal),
                             dot(texel(view, 2).xyz, faceNormal));
  return !hidden(view, inCamera, normalInCamera);
}

vec3 texturedByCameras() {
  // Front, as the faces wind, and not as the viewer sees it.
  vec3 faceNormal = normalize(cross(dFdx(vPoint), dFdy(vPoint))) * (gl_FrontFacing ? handedness : -handedness);
  vec3 normal = normalize(vNormal);
  uvec2 seen = seenByShares();
  vec3 weights = vec3(0.0);
  vec2 at0 = vec2(0.0), at1 = vec2(0.0), at2 = vec2(0.0);
  for (int view = 0; view < viewCount; view++) {
    float weight = dot(normal, normalize(texel(view, 3).xyz - vPoint));
    // Of equal weights the first is better.
    if (!(weight >= threshold) || !(weight > weights.z)) continue;
    vec2 at;
    if (!shows(view, faceNormal, seen, at)) continue;
    if (weight > weights.x) {
      weights = vec3(weight, weights.xy);
      at2 = at1, at1 = at0, at0 = at;
    } else if (weight > weights.y) {
      weights.yz = vec2(weight, weights.y);
      at2 = at1, at1 = at;
    } else {
      weights.z = weight;
      at2 = at;
    }
  }
  float sum = weights.x + weights.y + weights.z;
  if (!(sum > 0.0)) return unseen;
  return (weights.x * textureLod(pictures, at0 / pictureSize, 0.0).rgb +
          weights.y * textureLod(pictures, at1 / pictureSize, 0.0).rgb +
          weights.z * textureLod(pictures, at2 / pictureSize, 0.0).rgb) / sum;
}

void main() {
#ifdef ATLAS
  vec2 at = atlas.xy + clamp(vUv * atlas.zw, vec2(0.5), atlas.zw - 0.5);
  vec3 colour = textureLod(pictures, at / pictureSize, 0.0).rgb;
#else
  vec3 colour = texturedByCameras();
#endif
  // Cameras are mixed as display values; three goes on with light and comes back to them at its end.
  outColour = sRGBTransferEOTF(vec4(colour, 1.0));
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

/** One view's depth, without its lens, as the bytes of a float; 0 where there is no surface. */
export const depthVertex = /* glsl */ `
uniform int view;
uniform vec2 layerSize;
out float vDepth;
${project}
void main() {
  vec3 at = toCamera(view, position);
  vec4 plan = texel(view, 10);
  vDepth = at.z;
  // Clipped at 1 cm, never at the back.
  gl_Position = vec4(2.0 * (at.xy * plan.xy + plan.zw * at.z) / layerSize - at.z, at.z - 0.02, at.z);
}
`;

export const depthFragment = /* glsl */ `
in float vDepth;
layout(location = 0) out highp vec4 outBytes;

void main() {
  uint bits = floatBitsToUint(vDepth);
  outBytes = vec4((uvec4(bits) >> uvec4(0, 8, 16, 24)) & 255u) / 255.0;
}
`;

export const wholeVertex = /* glsl */ `
void main() {
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;

/**
 * 4:2:0 to RGB. Chroma is interpolated and stands in the middle of four pixels, as in all that fvvmux writes: browsers do
 * not tell where. place: of the picture's corner in the target.
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
