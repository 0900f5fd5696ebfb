// The textures that the shaders read beside pictures and depth maps: cameras and visibility weights.

import {
  Color,
  DataTexture,
  FloatType,
  LinearFilter,
  NearestFilter,
  NoColorSpace,
  RedFormat,
  RGBAFormat,
  Texture,
  UnsignedByteType,
} from "three";
import {
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

function upload(Type, ...parameters) {
  const texture = new Type(...parameters);
  // Tiles are addressed by rows from the top, and ImageBitmaps cannot be flipped.
  texture.flipY = false;
  texture.colorSpace = NoColorSpace;
  texture.generateMipmaps = false;
  texture.unpackAlignment = 1;
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

/** Textures for uploads of pictures and their planes. One is reused for the next picture of the same size. */
export class Sources {
  #known = new Map();

  /** The three planes of a picture. key: of the picture. */
  planesOf(key, picture) {
    return picture.planes.map((plane, k) => this.#get(`${key} ${k}`, DataTexture, plane, plane.width, plane.height));
  }

  /** A picture without planes, as it is. */
  imageOf(key, { picture: image }) {
    const width = image.displayWidth ?? image.width;
    const height = image.displayHeight ?? image.height;
    const texture = this.#get(`${key}`, Texture, image, width, height);
    texture.minFilter = texture.magFilter = NearestFilter;
    return texture;
  }

  #get(key, Type, image, width, height) {
    const known = this.#known.get(key);
    if (known && known.width === width && known.height === height) {
      known.texture.image = image;
      known.texture.needsUpdate = true;
      return known.texture;
    }
    known?.texture.dispose();
    const texture =
      Type === DataTexture
        ? upload(DataTexture, image.data, width, height, RedFormat, UnsignedByteType)
        : upload(Texture, image);
    this.#known.set(key, { texture, width, height });
    return texture;
  }

  dispose() {
    for (const { texture } of this.#known.values()) texture.dispose();
    this.#known.clear();
  }
}
