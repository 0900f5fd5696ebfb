// The material for WebGPURenderer, in three's shading language.

import { DoubleSide, LightingModel, NodeMaterial, Vector2, WebGPUCoordinateSystem } from "three/webgpu";
import { diffuseColor, float, highpModelViewMatrix, mix, positionLocal, texture, uniform } from "three/tsl";

import { Drawing, noLayers, noTexture, parametersOf, SHADOW } from "../drawing.js";
import { nodeDepthMaps } from "./depths.js";
import { NodePictures } from "./pictures.js";
import { surfaceNode } from "./surface.js";

/** Varyings of WebGPU that every device has, less those that three adds. */
const MAX_VARYINGS = 15;

/** Lamps of the page give no light, but shadows. */
class Shaded extends LightingModel {
  #mask = float(1).toVar("shadowMask");

  direct({ lightNode }) {
    if (lightNode.shadowNode !== null) this.#mask.mulAssign(lightNode.shadowNode);
  }
  finish({ context }) {
    context.outgoingLight.rgb.assign(diffuseColor.rgb.mul(mix(1, this.#mask, SHADOW)));
  }
}

class SurfaceMaterial extends NodeMaterial {
  static get type() {
    return "FvvSurfaceMaterial";
  }

  constructor() {
    super();
    this.side = DoubleSide;
    this.lights = true;
    this.fog = true;
  }

  /** The product of matrices is made in doubles: streams in coordinates of maps are far from the origin. */
  setupPositionView() {
    return highpModelViewMatrix.mul(positionLocal).xyz;
  }

  /** Without lamps. */
  setupOutgoingLight() {
    return diffuseColor.rgb;
  }
  setupLightingModel() {
    return new Shaded();
  }
}

export class NodeDrawing extends Drawing {
  #defines = { WEIGHT_TEXELS: 0, BEST: 1, VIEW_BLOCKS: 1 };
  #isChanged = true;
  #depthRange = uniform(new Vector2(0, 1));

  constructor(given) {
    super(given);
    this.pictures = new NodePictures();
    this.uniforms = {
      pictures: texture(noTexture),
      views: texture(this.views),
      visibilityWeights: texture(noTexture),
      depths: texture(noLayers),
      ...parametersOf((value) => uniform(value)),
    };
    this.depths = nodeDepthMaps(this, this.uniforms.views, this.#depthRange);
    this.material = new SurfaceMaterial();
  }

  get maxVaryings() {
    return MAX_VARYINGS;
  }

  /** A renderer draws only after it has a device, and only then its kind is known. */
  async ready() {
    const { renderer } = this;
    // A WebGLRenderer with three's WebGLNodesHandler has none.
    await renderer.init?.();
    const isHalf = renderer.coordinateSystem === WebGPUCoordinateSystem;
    if (renderer.reversedDepthBuffer) this.#depthRange.value.set(0.5, -0.5);
    else this.#depthRange.value.set(isHalf ? 0.5 : 0, isHalf ? 0.5 : 1);
  }

  show(frame, pictures) {
    const found = super.show(frame, pictures);
    if (this.#isChanged) this.#build();
    return found;
  }

  #build() {
    this.#isChanged = false;
    this.material.colorNode = surfaceNode(this.#defines, this.uniforms);
    this.material.needsUpdate = true;
  }

  define(name, value) {
    if (this.#defines[name] === value) return;
    this.#defines[name] = value;
    this.#isChanged = true;
  }

  prepare(renderer, camera, mesh) {
    super.prepare(renderer, camera, mesh);
    if (this.#isChanged) this.#build();
  }
}
