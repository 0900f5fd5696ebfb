// Who sees what, found out for cameras of which the file does not tell: a depth map of each, drawn once for a frame of
// the stream and not once for each picture of the viewer, in the layers of one target.

import {
  Camera,
  DoubleSide,
  GLSL3,
  Mesh,
  NearestFilter,
  NoBlending,
  RGBAFormat,
  Scene,
  ShaderMaterial,
  UnsignedByteType,
  Vector2,
  WebGLArrayRenderTarget,
} from "three";

import { offScreen } from "./off_screen.js";
import { depthFragment, depthVertex } from "./shaders.js";

/** Samples along a pixel of the tile, where there is room for them. */
const SAMPLES = 3;
/** x / z and y / z: a lens that shows more than 76 degrees off its axis has no such map. */
const WIDEST = 4;
const BORDER_STEPS = 32;
const MOST_TEXELS = 2 ** 24;
const LARGEST_SIDE = 4096;

/** Bounds of x / z and y / z that the border of a rectangle of the picture encloses, as the lens shows it. */
function fieldOf(camera, { x, y, width, height }) {
  const { rMax, lens } = camera;
  const rim = lens === "fisheye" ? Math.tan(Math.min(rMax, 1.5)) : rMax;
  const field = { left: Infinity, right: -Infinity, top: Infinity, bottom: -Infinity };
  const add = (u, v) => {
    field.left = Math.min(field.left, u);
    field.right = Math.max(field.right, u);
    field.top = Math.min(field.top, v);
    field.bottom = Math.max(field.bottom, v);
  };
  const look = (u, v) => {
    const ray = camera.unproject(u, v);
    if (ray) return add(ray[0], ray[1]);
    add(-rim, -rim);
    add(rim, rim);
  };
  for (let i = 0; i <= BORDER_STEPS; i++) {
    const [u, v] = [x + (width * i) / BORDER_STEPS, y + (height * i) / BORDER_STEPS];
    look(u, y);
    look(u, y + height);
    look(x, v);
    look(x + width, v);
  }
  return field;
}

export class DepthMaps {
  #target = null;
  #fields = new WeakMap(); // camera -> {key, field}; cameras that stand still are the same object in every frame
  #material;
  #scene = new Scene();
  #viewer = new Camera();

  constructor(geometry, viewTexture) {
    this.#material = new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: depthVertex,
      fragmentShader: depthFragment,
      side: DoubleSide,
      blending: NoBlending,
      toneMapped: false,
      uniforms: {
        views: { value: viewTexture },
        view: { value: 0 },
        layerSize: { value: new Vector2(1, 1) },
      },
    });
    const mesh = new Mesh(geometry, this.#material);
    mesh.frustumCulled = false;
    this.#scene.add(mesh);
  }

  get texture() {
    return this.#target?.texture ?? null;
  }

  #field(camera, source) {
    const key = `${source.x} ${source.y} ${source.width} ${source.height}`;
    const known = this.#fields.get(camera);
    if (known?.key === key) return known.field;
    const field = fieldOf(camera, source);
    this.#fields.set(camera, { key, field });
    return field;
  }

  /** Gives every view that needs one its place in the maps: view.depth. */
  plan(views) {
    const wanted = [];
    for (const view of views) {
      view.depth = null;
      if (view.hasShares) continue;
      const field = this.#field(view.camera, view.source);
      if (!(Math.max(-field.left, field.right, -field.top, field.bottom) <= WIDEST)) continue;
      const fx = (view.camera.fx * view.place.width) / view.source.width;
      const fy = (view.camera.fy * view.place.height) / view.source.height;
      wanted.push({
        view,
        field,
        fx,
        fy,
        columns: (field.right - field.left) * fx,
        rows: (field.bottom - field.top) * fy,
      });
    }
    if (!wanted.length) return;
    const columns = Math.max(...wanted.map((one) => one.columns)) + 2;
    const rows = Math.max(...wanted.map((one) => one.rows)) + 2;
    const samples = Math.min(
      SAMPLES,
      Math.sqrt(MOST_TEXELS / (views.length * columns * rows)),
      LARGEST_SIDE / Math.max(columns, rows),
    );
    // A sample may be farther away than the tolerance allows for when there is less than one to a pixel.
    const breadth = Math.max(1, 1 / samples);
    for (const { view, field, fx, fy, ...own } of wanted)
      view.depth = {
        scale: [fx * samples, fy * samples],
        offset: [(1 - field.left * fx) * samples, (1 - field.top * fy) * samples],
        size: [Math.ceil((own.columns + 2) * samples), Math.ceil((own.rows + 2) * samples)],
        breadth: [breadth / fx, breadth / fy],
      };
    this.#resize(Math.ceil(columns * samples), Math.ceil(rows * samples), views.length);
  }

  /** Layouts of groups differ a little: room that was made is kept. */
  #resize(width, height, layers) {
    const had = this.#target;
    if (had && had.width >= width && had.height >= height && had.depth >= layers) return;
    const size = [
      Math.max(width, had?.width ?? 0),
      Math.max(height, had?.height ?? 0),
      Math.max(layers, had?.depth ?? 0),
    ];
    had?.dispose();
    this.#target = new WebGLArrayRenderTarget(...size, {
      format: RGBAFormat,
      type: UnsignedByteType,
      minFilter: NearestFilter,
      magFilter: NearestFilter,
      generateMipmaps: false,
    });
    this.#material.uniforms.layerSize.value.set(size[0], size[1]);
  }

  render(renderer, views) {
    if (!views.some((view) => view.depth)) return;
    offScreen(renderer, () =>
      views.forEach((view, i) => {
        if (!view.depth) return;
        this.#material.uniforms.view.value = i;
        this.#material.uniformsNeedUpdate = true;
        renderer.setRenderTarget(this.#target, i);
        renderer.render(this.#scene, this.#viewer);
      }),
    );
  }

  dispose() {
    this.#target?.dispose();
    this.#material.dispose();
    this.#target = null;
  }
}
