// The mesh of a frame, coloured by its cameras: the shaders, the table of cameras, and the passes that draw it.

import {
  blending,
  definesOf,
  depthFragment,
  DepthPlan,
  depthSizes,
  depthVertex,
  MAX_VIEWS,
  MAX_WEIGHT_TEXELS,
  normalise,
  packVisibilityWeights,
  projection,
  texturingOf,
  usesLevels,
  VIEW_TEXELS,
  visibilityWeightsVertex,
  visibilityWeightTexels,
  WEIGHT_COLUMNS,
  writeViews,
} from "@fvv/shading";

import { Layer, layerVisibility, placedFragment } from "./layer.js";
import { raysOf, sphereOf } from "./matrices.js";
import { DataTexture, Layers, MeshBuffers } from "./resources.js";

/** MODE of the fragment shader. */
export const MODES = { textured: 0, weights: 1, visibility: 2, normals: 3, depth: 4, wireframe: 5 };

const vertex = /* glsl */ `
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 colour;
uniform mat4 worldToClip;
invariant gl_Position;
out vec3 vPoint, vNormal;
out vec2 vUv;
out vec4 vColour; // and depth
${visibilityWeightsVertex}
void main() {
  vPoint = position;
  vNormal = normal;
  vUv = uv;
  passVisibilityWeights();
  gl_Position = worldToClip * vec4(position, 1.0);
  vColour = vec4(colour.rgb, gl_Position.w);
}
`;

const fragment = /* glsl */ `
uniform vec4 atlas; // x y width height, in texels of pictures
uniform vec2 depthRange;
layout(location = 0) out highp vec4 outColour;
${projection}
${blending}
uniform mat3 pixelToRay; // of gl_FragCoord
in vec3 vPoint, vNormal;
in vec2 vUv;
in vec4 vColour;

// The front side by the winding of the face, not as the viewer sees it.
vec3 faceNormalHere() {
  return normalize(cross(dFdx(vPoint), dFdy(vPoint))) * (gl_FrontFacing ? 1.0 : -1.0);
}

// The intersection of the face with the ray through the middle of the pixel. Rasterisers round vertices to a sixteenth of a
// pixel, and interpolated values have errors of that size.
vec3 exactPoint(vec3 faceNormal) {
  vec3 ray = pixelToRay * vec3(gl_FragCoord.xy, 1.0);
  vec3 point = eye + ray * (dot(faceNormal, vPoint - eye) / dot(faceNormal, ray));
  // Not for faces that are seen edge-on.
  return distance(point, vPoint) < 0.1 * (length(dFdx(vPoint)) + length(dFdy(vPoint))) ? point : vPoint;
}

#if MODE < 3
// A different colour for each camera: hues a golden section apart.
vec3 cameraColour(int view) {
  float hue = fract(texel(view, 5).w * 0.61803399);
  return 0.15 + 0.8 * clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
}

#if MODE == 0
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal, vec3 own) {
  return surfaceColour(point, faceNormal, normal, own);
}
#elif MODE == 1
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal, vec3 own) {
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
// The number of cameras that show the point, from blue to yellow; dark red, without green, for none.
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal, vec3 own) {
  int count = 0, all = 0;
  vec3 shown = shownPlace(point, normal);
  vec4 limits[VIEW_BLOCKS], facings[VIEW_BLOCKS];
  limitsAt(point, normal, normalize(eye - point), limits, facings);
  for (int view = 0; view < viewCount; view++) {
    all += (int(texel(view, 3).w) & OFF) == 0 ? 1 : 0;
    vec2 at;
    if (limits[view >> 2][view & 3] > 0.0 && shows(view, point, shown, faceNormal, at) > 0.0) count++;
  }
  float fraction = float(count) / float(max(all, 1));
  return count == 0 ? vec3(0.4, 0.0, 0.0) : mix(vec3(0.05, 0.25, 0.75), vec3(1.0, 0.9, 0.2), min(1.0, 2.0 * fraction));
}
#endif
#elif MODE == 3
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal, vec3 own) { return 0.5 + 0.5 * normal; }
#elif MODE == 4
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal, vec3 own) {
  return vec3(mix(1.0, 0.08, clamp((vColour.w - depthRange.x) / (depthRange.y - depthRange.x), 0.0, 1.0)));
}
#else
vec3 shaded(vec3 point, vec3 faceNormal, vec3 normal, vec3 own) {
  return vec3(0.10, 0.11, 0.13) * (0.5 + abs(dot(faceNormal, normalize(eye - point))));
}
#endif

#ifdef IN_LAYER
${layerVisibility}
#endif

void main() {
  vec3 faceNormal = faceNormalHere(), point = exactPoint(faceNormal), normal = normalize(vNormal);
#ifdef IN_LAYER
  bool first = isFirst();
#else
  const bool first = true;
#endif
#ifdef ATLAS
  outColour = vec4(atlasColour(atlas, vUv), 1.0);
#else
  // At most once: software executes both sides of branches.
  for (int i = first ? 0 : 1; i < 1; i++) outColour = vec4(shaded(point, faceNormal, normal, vColour.rgb), 1.0);
#endif
  if (!first) discard;
}
`;

const surface = { vertex, fragment };

const placed = { vertex, fragment: placedFragment };

/** Draws depth only, because the colours of hidden fragments would be expensive. */
const cover = {
  vertex,
  fragment: /* glsl */ `
layout(location = 0) out highp vec4 outColour;
void main() { outColour = vec4(0.0); }
`,
};

const wires = {
  vertex,
  fragment: /* glsl */ `
layout(location = 0) out highp vec4 outColour;
void main() { outColour = vec4(0.62, 0.74, 0.85, 1.0); }
`,
};

/** The colour of a camera in the mode "weights", [r, g, b] of 0 to 1; the same as in the shader. */
export function cameraColour(id) {
  const hue = (id * 0.61803399) % 1;
  return [0, 2, 1].map((third) => {
    const wave = Math.abs(((hue + third / 3) % 1) * 6 - 3) - 1;
    return 0.15 + 0.8 * Math.min(1, Math.max(0, wave));
  });
}

/** Varyings other than visibility weights: point, normal, texture coordinates, colour with depth. */
const OTHER_VARYINGS = 4;
const VISIBLE_BY = ["auto", "bits", "depth", "both"];

const depthShaders = { vertex: `layout(location = 0) in vec3 position;${depthVertex}`, fragment: depthFragment };

export class Surface {
  #gl;
  #programs;
  #counters;
  #mesh;
  #views;
  #visibilityWeights;
  #depths;
  #layer;
  #plan;
  #content = null;
  #texels = 0; // of visibility weights, per vertex
  #visibleBy = null;
  #off = null;
  #table = new Float32Array(4 * VIEW_TEXELS * MAX_VIEWS);

  constructor(gl, programs, counters, depthTexels) {
    this.#gl = gl;
    this.#programs = programs;
    this.#counters = counters;
    this.#plan = new DepthPlan(depthTexels);
    const { uploads } = counters;
    this.#mesh = new MeshBuffers(gl, uploads);
    const floats = { internal: gl.RGBA32F, format: gl.RGBA, type: gl.FLOAT, texelBytes: 16, filter: gl.NEAREST };
    const bytes = { internal: gl.RGBA8, format: gl.RGBA, type: gl.UNSIGNED_BYTE, texelBytes: 4, filter: gl.NEAREST };
    this.#views = new DataTexture(gl, uploads, floats);
    this.#views.resize(VIEW_TEXELS, MAX_VIEWS);
    this.#visibilityWeights = new DataTexture(gl, uploads, bytes);
    this.#visibilityWeights.resize(WEIGHT_COLUMNS, 1);
    this.#depths = new Layers(gl, {
      internal: gl.RGBA8,
      attachment: gl.COLOR_ATTACHMENT0,
      depth: gl.DEPTH_COMPONENT24,
    });
    this.#layer = new Layer(gl);
  }

  get mesh() {
    return this.#mesh;
  }

  /** content: the mesh, views and visibility weights of a frame. */
  show(content) {
    this.#content = content;
    this.#visibleBy = this.#off = null;
    this.#mesh.show(content.mesh);
    const { views, frame, mesh } = content;
    const maxTexels = Math.min(MAX_WEIGHT_TEXELS, this.#gl.getParameter(this.#gl.MAX_VARYING_VECTORS) - OTHER_VARYINGS);
    this.#texels = visibilityWeightTexels(frame, mesh, views, maxTexels);
    if (this.#texels) this.#writeVisibilityWeights(views, mesh.vertexCount);
  }

  #writeVisibilityWeights(views, vertexCount) {
    const rows = Math.ceil((this.#texels * vertexCount) / WEIGHT_COLUMNS);
    if (this.#visibilityWeights.height < rows) this.#visibilityWeights.resize(WEIGHT_COLUMNS, Math.ceil(1.25 * rows));
    const bytes = new Uint8Array(4 * WEIGHT_COLUMNS * rows);
    packVisibilityWeights(views, vertexCount, this.#texels, bytes);
    this.#visibilityWeights.write(bytes, WEIGHT_COLUMNS, rows);
  }

  /** Updates depth maps and the table of views, if the frame or the options have changed. */
  prepare({ visibleBy, cameras }) {
    if (!VISIBLE_BY.includes(visibleBy)) throw new TypeError(`visibleBy: expected one of ${VISIBLE_BY.join(", ")}`);
    const { views } = this.#content;
    const off = cameras && views.map((view) => !cameras.has(view.camera.id)).join();
    if (visibleBy === this.#visibleBy && off === this.#off) return;
    const drawn = visibleBy === this.#visibleBy;
    this.#visibleBy = visibleBy;
    this.#off = off;
    for (const view of views) {
      view.off = cameras !== null && !cameras.has(view.camera.id);
      view.hasVisibilityWeights = view.visibilityWeights !== null && visibleBy !== "depth";
    }
    const wanted = this.#plan.place(views, (view) => visibleBy === "both" || !view.hasVisibilityWeights);
    writeViews(views, this.#table);
    if (views.length)
      this.#views.write(this.#table.subarray(0, 4 * VIEW_TEXELS * views.length), VIEW_TEXELS, views.length);
    if (wanted && !drawn) this.#drawDepths(wanted, views);
  }

  #drawDepths(wanted, views) {
    this.#depths.resize(depthSizes(wanted, this.#depths));
    const layerSize = [this.#depths.width, this.#depths.height];
    const program = this.#programs.get(depthShaders);
    const mapped = Array.from(views.keys()).filter((i) => views[i].depth);
    this.#depths.draw(mapped, (view) => {
      program.use({ view, layerSize, nearPlane: this.#content.nearPlane }, { views: this.#views.texture });
      this.#mesh.draw();
      this.#counters.depthPasses++;
    });
  }

  /**
   * pictures: the PictureTexture; target: {framebuffer, view}. The surface is coloured directly, or with options.surfaceScale in
   * a layer.
   */
  draw(pictures, viewer, options, target) {
    const gl = this.#gl;
    const wired = options.mode === "wireframe";
    // Edges coincide with the faces, and would be drawn only in part.
    if (wired) gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.enable(gl.DEPTH_TEST);
    if (options.surfaceScale) this.#drawPlaced(pictures, viewer, options, target);
    else this.#drawDirectly(this.#shading(pictures, viewer, options));
    gl.disable(gl.POLYGON_OFFSET_FILL);
    if (wired) this.#drawWires({ worldToClip: viewer.worldToClip });
  }

  /** What colours the surface for a viewer: uniforms, textures and defines of the shaders. */
  #shading(pictures, { worldToClip, pixelToRay, depthRange, eye }, options) {
    const { views, atlas, frame, bounds, nearPlane } = this.#content;
    const { best, blend, ...texturing } = texturingOf(frame.configuration, options);
    const pixelAngle = Math.hypot(...pixelToRay.subarray(0, 3));
    const far = options.mode === "textured" && usesLevels(this.#content, sphereOf(bounds), eye, pixelAngle);
    if (far) pictures.makeLevels();
    const uniforms = {
      worldToClip,
      pixelToRay,
      depthRange,
      eye,
      nearPlane,
      pixelAngle,
      pictureSize: pictures.size,
      viewCount: views.length,
      ...texturing,
      viewerRight: normalise(pixelToRay.subarray(0, 3)),
      viewerUp: normalise(pixelToRay.subarray(3, 6)),
      atlas: atlas ?? [0, 0, 1, 1],
    };
    const textures = {
      pictures: pictures.texture,
      views: this.#views.texture,
      visibilityWeights: this.#visibilityWeights.texture,
      depths: this.#depths.texture,
    };
    const defines = { MODE: MODES[options.mode], WEIGHT_TEXELS: this.#texels, BEST: best, ...definesOf(views) };
    if (blend === "paper") defines.PAPER = 1;
    if (atlas && options.mode === "textured") defines.ATLAS = 1;
    if (far) defines.LEVELS = 1;
    if (texturing.inset) defines.INSET = 1;
    // An explicit colour overrides those of the stream.
    if (this.#content.mesh.colours && (options.unseen ?? null) === null) defines.COLOURS = 1;
    return { uniforms, textures, defines };
  }

  /** Depth first, because colours of hidden fragments are expensive. */
  #drawDirectly(shading) {
    const gl = this.#gl;
    gl.depthFunc(gl.LESS);
    gl.colorMask(false, false, false, false);
    this.#programs.get(cover, { WEIGHT_TEXELS: 0 }).use(shading.uniforms);
    this.#draw();
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    this.#colour(shading);
  }

  #drawPlaced(pictures, viewer, options, { framebuffer, view }) {
    const gl = this.#gl;
    const layer = this.#layer;
    const size = [view.width, view.height].map((pixels) => Math.max(1, Math.round(options.surfaceScale * pixels)));
    const layerScale = [size[0] / view.width, size[1] / view.height];
    layer.resize(...size);
    const scaled = { ...view, x: 0, y: 0, width: size[0], height: size[1] };
    for (const [focal, centre, i] of [
      ["fx", "cx", 0],
      ["fy", "cy", 1],
    ]) {
      scaled[focal] *= layerScale[i];
      scaled[centre] *= layerScale[i];
    }
    this.#colourLayer(this.#shading(pictures, { ...viewer, pixelToRay: raysOf(scaled) }, options));
    const { x = 0, y = 0, width, height } = view;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(x, y, width, height);
    gl.depthFunc(gl.LESS);
    const { worldToClip } = viewer;
    const defines = { WEIGHT_TEXELS: 0, ...(options.surfaceScale < 1 && { SCALED: 1 }) };
    this.#programs
      .get(placed, defines)
      .use(
        { worldToClip, layerScale, layerSize: size, corner: [x, y] },
        { layerColours: layer.colours, layerDepths: layer.depths },
      );
    this.#draw();
  }

  #colourLayer({ uniforms, textures, defines }) {
    const gl = this.#gl;
    const layer = this.#layer;
    layer.drawDepths();
    gl.depthFunc(gl.LESS);
    this.#programs.get(cover, { WEIGHT_TEXELS: 0 }).use(uniforms);
    this.#draw();
    layer.drawColours();
    gl.disable(gl.DEPTH_TEST);
    this.#colour({
      uniforms,
      textures: { ...textures, layerDepths: layer.depths },
      defines: { ...defines, IN_LAYER: 1 },
    });
    gl.enable(gl.DEPTH_TEST);
  }

  #colour({ uniforms, textures, defines }) {
    const program = this.#programs.get(surface, defines).use(uniforms, textures);
    this.#counters.samplers = program.samplers;
    this.#draw();
  }

  #draw() {
    this.#mesh.draw();
    this.#counters.drawCalls++;
  }

  #drawWires(uniforms) {
    this.#programs.get(wires, { WEIGHT_TEXELS: 0 }).use(uniforms);
    this.#mesh.drawEdges();
    this.#counters.drawCalls++;
  }

  close() {
    this.#mesh.close();
    this.#views.close();
    this.#visibilityWeights.close();
    this.#depths.close();
    this.#layer.close();
  }
}
