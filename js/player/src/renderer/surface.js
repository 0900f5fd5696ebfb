// The mesh of a frame, coloured by its cameras: the table of these, what they see, and the drawing of it all.

import {
  DepthPlan,
  MOST_SHARE_TEXELS,
  MOST_VIEWS,
  SHARE_COLUMNS,
  VIEW_TEXELS,
  depthFragment,
  depthSizes,
  depthVertex,
  packShares,
  shareTexels,
  texturingOf,
  writeViews,
} from "@fvv/shading";

import { Layers } from "./layers.js";
import { MeshBuffers } from "./mesh.js";
import { MODES, cover, surface, wires } from "./surface_shaders.js";
import { DataTexture } from "./textures.js";

/** Varyings that are not shares: point, normal, texture coordinates, depth. */
const OTHER_VARYINGS = 4;
const VISIBLE_BY = ["auto", "bits", "depth", "both"];

const depthShaders = { vertex: `layout(location = 0) in vec3 position;${depthVertex}`, fragment: depthFragment };

export class Surface {
  #gl;
  #programs;
  #counters;
  #mesh;
  #views;
  #shares;
  #depths;
  #plan;
  #content = null;
  #texels = 0; // of shares, for each vertex
  #visibleBy = null;
  #off = null;
  #table = new Float32Array(4 * VIEW_TEXELS * MOST_VIEWS);

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
    this.#views.resize(VIEW_TEXELS, MOST_VIEWS);
    this.#shares = new DataTexture(gl, uploads, bytes);
    this.#shares.resize(SHARE_COLUMNS, 1);
    this.#depths = new Layers(gl, {
      internal: gl.RGBA8,
      attachment: gl.COLOR_ATTACHMENT0,
      depth: gl.DEPTH_COMPONENT24,
    });
  }

  get mesh() {
    return this.#mesh;
  }

  /** content: a frame's mesh, its views, and what the file says that they see. */
  show(content) {
    this.#content = content;
    this.#visibleBy = this.#off = null;
    this.#mesh.show(content.mesh);
    const { views, frame, mesh } = content;
    const most = Math.min(MOST_SHARE_TEXELS, this.#gl.getParameter(this.#gl.MAX_VARYING_VECTORS) - OTHER_VARYINGS);
    this.#texels = shareTexels(frame, mesh, views, most);
    if (this.#texels) this.#writeShares(views, mesh.vertexCount);
  }

  #writeShares(views, vertexCount) {
    const rows = Math.ceil((this.#texels * vertexCount) / SHARE_COLUMNS);
    if (this.#shares.height < rows) this.#shares.resize(SHARE_COLUMNS, Math.ceil(1.25 * rows));
    const bytes = new Uint8Array(4 * SHARE_COLUMNS * rows);
    packShares(views, vertexCount, this.#texels, bytes);
    this.#shares.write(bytes, SHARE_COLUMNS, rows);
  }

  /** Sees to it that the maps and the table are those of the frame and the options, once for each. */
  prepare({ visibleBy, cameras }) {
    if (!VISIBLE_BY.includes(visibleBy)) throw new TypeError(`visibleBy is one of ${VISIBLE_BY.join(", ")}`);
    const { views } = this.#content;
    const off = cameras && views.map((view) => !cameras.has(view.camera.id)).join();
    if (visibleBy === this.#visibleBy && off === this.#off) return;
    const drawn = visibleBy === this.#visibleBy;
    this.#visibleBy = visibleBy;
    this.#off = off;
    for (const view of views) {
      view.off = cameras !== null && !cameras.has(view.camera.id);
      view.hasShares = view.shares !== null && visibleBy !== "depth";
    }
    const wanted = this.#plan.place(views, (view) => visibleBy === "both" || !view.hasShares);
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
      program.use({ view, layerSize }, { views: this.#views.texture });
      this.#mesh.draw();
      this.#counters.depthPasses++;
    });
  }

  /** pictures: the texture of all of them. */
  draw(pictures, { worldToClip, pixelToRay, depthRange, eye }, options) {
    const gl = this.#gl;
    const { views, atlas, frame } = this.#content;
    const { best, ...texturing } = texturingOf(frame.configuration, options);
    const uniforms = {
      worldToClip,
      pixelToRay,
      depthRange,
      eye,
      pictureSize: pictures.size,
      viewCount: views.length,
      ...texturing,
      soft: options.soft,
      atlas: atlas ?? [0, 0, 1, 1],
    };
    const textures = {
      pictures: pictures.texture,
      views: this.#views.texture,
      shares: this.#shares.texture,
      depths: this.#depths.texture,
    };
    const defines = { MODE: MODES[options.mode], SHARES: this.#texels, BEST: best };
    if (options.soft > 0) defines.SOFT = 1;
    if (atlas) defines.ATLAS = 1;
    const wired = options.mode === "wireframe";
    // Edges lie on the faces, and would be drawn in part.
    if (wired) gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    gl.colorMask(false, false, false, false);
    this.#programs.get(cover, { SHARES: 0 }).use(uniforms);
    this.#draw();
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    const program = this.#programs.get(surface, defines).use(uniforms, textures);
    this.#counters.samplers = program.samplers;
    this.#draw();
    gl.disable(gl.POLYGON_OFFSET_FILL);
    if (wired) this.#drawWires(uniforms);
  }

  #draw() {
    this.#mesh.draw();
    this.#counters.drawCalls++;
  }

  #drawWires(uniforms) {
    this.#programs.get(wires, { SHARES: 0 }).use(uniforms);
    this.#mesh.drawEdges();
    this.#counters.drawCalls++;
  }

  close() {
    this.#mesh.close();
    this.#views.close();
    this.#shares.close();
    this.#depths.close();
  }
}
