// What the surface of a frame is drawn with, whatever the renderer: the parameters of its material, and the textures that it reads.
// gl/ has the material for WebGLRenderer, nodes/ that for WebGPURenderer.

import { definesOf, MAX_WEIGHT_TEXELS, nearPlaneOf, texturingOf, usesLevels, viewsOf } from "@fvv/shading";
import { DataArrayTexture, DataTexture, Matrix4, Vector2, Vector3, Vector4 } from "three";

import { ViewTexture, VisibilityWeightTexture } from "./textures.js";

/** Varyings other than visibility weights: point, normal, texture coordinates, colour, and three's depth, fog and a shadow. */
const OTHER_VARYINGS = 7;
/** The part of the colour that a shadow of the page's lamps takes: the pictures have light of other lamps, too. */
export const SHADOW = 0.5;

const worldToMesh = new Matrix4();
const bufferSize = new Vector2();

// Every sampler requires a texture.
export const noTexture = new DataTexture(new Uint8Array(4), 1, 1);
export const noLayers = new DataArrayTexture(new Uint8Array(4), 1, 1, 1);
noTexture.needsUpdate = noLayers.needsUpdate = true;

/** The values of the material's parameters before the first frame, by their names in the shaders of @fvv/shading. */
const INITIAL = {
  pictureSize: () => new Vector2(1, 1),
  viewCount: () => 0,
  atlas: () => new Vector4(),
  nearPlane: () => 0,
  threshold: () => 0,
  eye: () => new Vector3(),
  viewerRight: () => new Vector3(),
  viewerUp: () => new Vector3(),
  tolerance: () => new Vector2(),
  inset: () => 0,
  handedness: () => 1,
  pixelAngle: () => 0,
  unseen: () => new Vector3(),
};

/** {name: parameter(value)} of the material. */
export const parametersOf = (parameter) =>
  Object.fromEntries(Object.entries(INITIAL).map(([name, initial]) => [name, parameter(initial())]));

/**
 * A material with its parameters and textures. Classes derived from it have material, pictures, depths, maxVaryings, define(name,
 * value), and ready(), after which the renderer can draw.
 */
export class Drawing {
  renderer;
  geometry;
  views = new ViewTexture();
  visibilityWeights = new VisibilityWeightTexture();
  /** Parameters and textures of the material by name, {value}: set by derived classes. */
  uniforms = {};
  #texturing;
  #shown = { views: [], atlas: null };

  constructor({ renderer, geometry, texturing }) {
    this.renderer = renderer;
    this.geometry = geometry;
    this.#texturing = texturing;
  }

  /** Uploads what a frame shows, whose mesh the geometry has already. Returns the number of cameras that give colours. */
  show(frame, pictures) {
    const { mesh } = frame;
    const { min, max } = this.geometry.boundingBox;
    const nearPlane = nearPlaneOf({ min: min.toArray(), max: max.toArray() });
    this.depths.nearPlane = this.uniforms.nearPlane.value = nearPlane;
    // An explicit colour overrides those of the stream.
    this.define("COLOURS", mesh.colours && (this.#texturing.unseen ?? null) === null ? 1 : undefined);
    const layout = this.pictures.show(this.renderer, pictures);
    if (layout.size) {
      this.uniforms.pictures.value = this.pictures.texture;
      this.uniforms.pictureSize.value.set(this.pictures.width, this.pictures.height);
    }
    this.#setTexturing(frame.configuration);
    const views = viewsOf(frame, layout);
    this.#showViews(frame, views);
    const atlas = frame.configuration.videos.find((video) => video.shows === "atlas" && layout.has(video.track));
    const place = atlas && layout.get(atlas.track);
    // A texture atlas is used if there are no cameras.
    this.#setAtlas(place && mesh.uvs && !views.length ? [place.x, place.y, atlas.width, atlas.height] : null);
    this.#shown.views = views;
    return views.length;
  }

  #setTexturing(configuration) {
    const { blend, best, threshold, unseen, tolerance, inset } = texturingOf(configuration, this.#texturing);
    this.define("BEST", best);
    this.define("PAPER", blend === "paper" ? 1 : undefined);
    this.uniforms.threshold.value = threshold;
    this.uniforms.unseen.value.fromArray(unseen);
    this.uniforms.tolerance.value.fromArray(tolerance);
    this.define("INSET", inset ? 1 : undefined);
    this.uniforms.inset.value = inset;
  }

  #showViews(frame, views) {
    const maxTexels = Math.min(MAX_WEIGHT_TEXELS, this.maxVaryings - OTHER_VARYINGS);
    const texels = this.visibilityWeights.show(frame, frame.mesh, views, maxTexels);
    this.define("WEIGHT_TEXELS", texels);
    if (texels) this.uniforms.visibilityWeights.value = this.visibilityWeights.texture;
    this.depths.plan(views);
    const { LENSES, VIEW_BLOCKS, DEPTHS } = definesOf(views);
    this.define("LENSES", LENSES);
    this.define("VIEW_BLOCKS", VIEW_BLOCKS);
    this.define("DEPTHS", DEPTHS);
    this.views.show(views);
    this.depths.render(this.renderer, views);
    this.uniforms.depths.value = this.depths.texture ?? noLayers;
    this.uniforms.viewCount.value = views.length;
  }

  /** atlas: its place, [x, y, width, height], or null. */
  #setAtlas(atlas) {
    this.define("ATLAS", atlas ? 1 : undefined);
    if (atlas) this.uniforms.atlas.value.fromArray(atlas);
    this.#shown.atlas = atlas;
  }

  /** Draws into textures again what was lost with the context. pictures: of the frame that is shown. */
  redraw(pictures) {
    this.pictures.show(this.renderer, pictures);
    this.depths.render(this.renderer, this.#shown.views);
  }

  /** Sets what depends on the viewer, before a mesh with this material is drawn. */
  prepare(renderer, camera, mesh) {
    const { eye, viewerRight, viewerUp, handedness } = this.uniforms;
    worldToMesh.copy(mesh.matrixWorld).invert();
    eye.value.setFromMatrixPosition(camera.matrixWorld).applyMatrix4(worldToMesh);
    viewerRight.value.setFromMatrixColumn(camera.matrixWorld, 0).transformDirection(worldToMesh);
    viewerUp.value.setFromMatrixColumn(camera.matrixWorld, 1).transformDirection(worldToMesh);
    handedness.value = mesh.matrixWorld.determinant() < 0 ? -1 : 1;
    this.#prepareLevels(renderer, camera);
  }

  /** Pictures have levels above the first only if the viewer is far away. */
  #prepareLevels(renderer, camera) {
    const { eye, pixelAngle } = this.uniforms;
    const { height } = camera.viewport ?? renderer.getRenderTarget() ?? renderer.getDrawingBufferSize(bufferSize);
    pixelAngle.value = 2 / (camera.projectionMatrix.elements[5] * height);
    const { center, radius } = this.geometry.boundingSphere;
    const sphere = { centre: center.toArray(), radius };
    const isFar = camera.isPerspectiveCamera && usesLevels(this.#shown, sphere, eye.value.toArray(), pixelAngle.value);
    this.define("LEVELS", isFar && this.pictures.makeLevels(renderer) ? 1 : undefined);
  }

  dispose() {
    this.material.dispose();
    this.pictures.dispose();
    this.views.dispose();
    this.visibilityWeights.dispose();
    this.depths.dispose();
  }
}
