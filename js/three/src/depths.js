// Depth maps of the cameras without visibility weights, in the layers of one target. They are drawn once per frame of the
// stream, not for each picture of the viewer.

import { DepthPlan, depthSizes } from "@fvv/shading";
import { Mesh, OrthographicCamera, Scene } from "three";

import { offScreen } from "./textures.js";

export class DepthMaps {
  #target = null;
  #plan = new DepthPlan();
  #material;
  #uniforms;
  #newTarget;
  #scene = new Scene();
  #viewer = new OrthographicCamera();

  /**
   * uniforms: of the material, which draws the map of one view: view, layerSize and nearPlane, each {value}. newTarget(width,
   * height, layers): a render target.
   */
  constructor({ geometry, material, uniforms, newTarget }) {
    this.#material = material;
    this.#uniforms = uniforms;
    this.#newTarget = newTarget;
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    this.#scene.add(mesh);
  }

  get texture() {
    return this.#target?.texture ?? null;
  }

  /** The depth from which on cameras see something. */
  set nearPlane(depth) {
    this.#uniforms.nearPlane.value = depth;
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
    this.#target = this.#newTarget(width, height, layers);
    this.#uniforms.layerSize.value.set(width, height);
  }

  render(renderer, views) {
    if (!views.some((view) => view.depth)) return;
    offScreen(renderer, () =>
      views.forEach((view, i) => {
        if (!view.depth) return;
        this.#uniforms.view.value = i;
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
