// Who sees what, found out for cameras of which the file does not tell: a depth map of each, drawn once for a frame of
// the stream and not once for each picture of the viewer, in the layers of one target.

import { DepthPlan, depthFragment, depthSizes, depthVertex } from "@fvv/shading";
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

export class DepthMaps {
  #target = null;
  #plan = new DepthPlan();
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

  /** Gives every view without shares its place in the maps. */
  plan(views) {
    const wanted = this.#plan.place(views, (view) => !view.hasShares);
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
