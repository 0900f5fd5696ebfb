// The textures that the shaders read beside the pictures: cameras, visibility weights, depth maps.

import {
  Color,
  DataTexture,
  DoubleSide,
  FloatType,
  GLSL3,
  Mesh,
  NearestFilter,
  NoBlending,
  OrthographicCamera,
  RGBAFormat,
  Scene,
  ShaderMaterial,
  UnsignedByteType,
  Vector2,
  WebGLArrayRenderTarget,
} from "three";
import {
  depthFragment,
  DepthPlan,
  depthSizes,
  depthVertex,
  MAX_VIEWS,
  packVisibilityWeights,
  WEIGHT_COLUMNS,
  visibilityWeightTexels,
  VIEW_TEXELS,
  writeViews,
} from "@fvv/shading";

/** Draws into targets before the scene is drawn, and restores the renderer. draw(): sets targets and renders; each target is
 * cleared to zeros before, unless clears is false. */
export function offScreen(renderer, draw, { clears = true } = {}) {
  const target = renderer.getRenderTarget();
  const layer = renderer.getActiveCubeFace();
  const level = renderer.getActiveMipmapLevel();
  const colour = renderer.getClearColor(new Color());
  const alpha = renderer.getClearAlpha();
  const { autoClear } = renderer;
  const { enabled } = renderer.xr;
  renderer.xr.enabled = false;
  renderer.autoClear = clears;
  renderer.setClearColor(0, 0);
  try {
    draw();
  } finally {
    renderer.setClearColor(colour, alpha);
    renderer.autoClear = autoClear;
    renderer.xr.enabled = enabled;
    renderer.setRenderTarget(target, layer, level);
  }
}

/** The table of views. */
export class ViewTexture extends DataTexture {
  constructor() {
    super(new Float32Array(4 * VIEW_TEXELS * MAX_VIEWS), VIEW_TEXELS, MAX_VIEWS, RGBAFormat, FloatType);
    this.minFilter = this.magFilter = NearestFilter;
  }

  show(views) {
    writeViews(views, this.image.data);
    this.needsUpdate = true;
  }
}

/** The visibility weights of each vertex and camera. */
export class VisibilityWeightTexture {
  #texture = null;

  get texture() {
    return this.#texture;
  }

  /** Returns the number of texels per vertex, at most maxTexels; 0: the frame has no visibility weights. */
  show(frame, mesh, views, maxTexels) {
    const texels = visibilityWeightTexels(frame, mesh, views, maxTexels);
    if (!texels) return 0;
    packVisibilityWeights(views, mesh.vertexCount, texels, this.#room(texels * mesh.vertexCount));
    this.#texture.needsUpdate = true;
    return texels;
  }

  #room(texels) {
    const rows = Math.ceil(texels / WEIGHT_COLUMNS);
    if (!this.#texture || this.#texture.image.height < rows) {
      this.#texture?.dispose();
      const height = Math.ceil(1.25 * rows);
      const bytes = new Uint8Array(4 * WEIGHT_COLUMNS * height);
      this.#texture = new DataTexture(bytes, WEIGHT_COLUMNS, height, RGBAFormat, UnsignedByteType);
      this.#texture.minFilter = this.#texture.magFilter = NearestFilter;
    }
    return this.#texture.image.data;
  }

  dispose() {
    this.#texture?.dispose();
    this.#texture = null;
  }
}

/**
 * Depth maps of the cameras without visibility weights, in the layers of one target. They are drawn once per frame of the
 * stream, not for each picture of the viewer.
 */
export class DepthMaps {
  #target = null;
  #plan = new DepthPlan();
  #material;
  #scene = new Scene();
  #viewer = new OrthographicCamera();

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
        nearPlane: { value: 0 },
      },
    });
    const mesh = new Mesh(geometry, this.#material);
    mesh.frustumCulled = false;
    this.#scene.add(mesh);
  }

  get texture() {
    return this.#target?.texture ?? null;
  }

  /** The depth from which on cameras see something. */
  set nearPlane(depth) {
    this.#material.uniforms.nearPlane.value = depth;
  }

  /** Assigns a place in the maps to every view without visibility weights. */
  plan(views) {
    const wanted = this.#plan.place(views, (view) => !view.hasVisibilityWeights);
    if (wanted) this.#resize(wanted);
  }

  #resize(wanted) {
    const former = this.#target && {
      width: this.#target.width,
      height: this.#target.height,
      layers: this.#target.depth,
    };
    const { width, height, layers } = depthSizes(wanted, former);
    if (former && width === former.width && height === former.height && layers === former.layers) return;
    this.#target?.dispose();
    this.#target = new WebGLArrayRenderTarget(width, height, layers, {
      format: RGBAFormat,
      type: UnsignedByteType,
      minFilter: NearestFilter,
      magFilter: NearestFilter,
      generateMipmaps: false,
    });
    this.#material.uniforms.layerSize.value.set(width, height);
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
