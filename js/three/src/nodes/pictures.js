// The pictures of a frame as one texture of display values, for WebGPURenderer: as glsl/pictures.js of @fvv/shading converts them.

import { conversionOf, layoutOf } from "@fvv/shading";
import {
  LinearMipmapLinearFilter,
  Mesh,
  NoBlending,
  NodeMaterial,
  OrthographicCamera,
  PlaneGeometry,
  RenderTarget,
  Scene,
  Vector2,
  Vector3,
} from "three/webgpu";
import { Fn, texture, uniform, uv, varyingProperty, vec2, vec4 } from "three/tsl";

import { offScreen, Sources } from "../textures.js";
import { copied, fromPlanes } from "./conversion.js";

/** What draws one picture, with the values that it needs. */
class Tile {
  values = {
    place: uniform(new Vector2()),
    size: uniform(new Vector2(1, 1)),
    targetSize: uniform(new Vector2(1, 1)),
    range: uniform(new Vector3()),
    kr: uniform(0),
    kb: uniform(0),
  };
  textures;
  mesh;

  /** kind(at, values, textures): the colour of a pixel of the picture. */
  constructor(kind, textures, geometry) {
    this.textures = textures.map((one) => texture(one));
    const material = new NodeMaterial();
    Object.assign(material, { depthTest: false, depthWrite: false, blending: NoBlending, fog: false });
    const { place, size, targetSize } = this.values;
    const at = varyingProperty("vec2", "vAt");
    material.vertexNode = Fn(() => {
      // The first row is at the top, as it is where textures that were drawn are sampled.
      at.assign(vec2(uv().x, uv().y.oneMinus()).mul(size));
      const corner = at.add(place).div(targetSize).mul(2).sub(1).toVar();
      return vec4(corner.x, corner.y.negate(), 0, 1);
    })();
    material.fragmentNode = kind(at, this.values, this.textures);
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
  }

  show(textures, values) {
    textures.forEach((one, i) => (this.textures[i].value = one));
    for (const [name, value] of Object.entries(values)) {
      const node = this.values[name];
      if (typeof value === "number") node.value = value;
      else node.value.fromArray(value);
    }
  }

  dispose() {
    this.mesh.material.dispose();
  }
}

export class NodePictures {
  texture = null;
  width = 1;
  height = 1;
  #sources = new Sources();
  #target = null;
  #scene = new Scene();
  #viewer = new OrthographicCamera();
  #geometry = new PlaneGeometry(2, 2);
  #tiles = new Map(); // by place and kind
  #hasLevels = false;
  #wantsLevels = false;

  /** Uploads the pictures of loadPictures. Returns where the picture of each track is: Map from track to {x, y}. */
  show(renderer, pictures) {
    const { places, width, height } = layoutOf(pictures);
    if (!pictures.length) return places;
    Object.assign(this, { width, height });
    this.#resize(width, height);
    this.texture = this.#target.texture;
    const tiles = pictures.map((picture, i) => this.#tile(renderer, picture, places.get(picture.video.track), i));
    this.#hasLevels = this.#wantsLevels;
    this.texture.mipmapsAutoUpdate = this.#wantsLevels;
    this.#wantsLevels = false;
    this.#draw(renderer, tiles);
    return places;
  }

  #draw(renderer, tiles, options) {
    this.#scene.clear();
    for (const { mesh } of tiles) this.#scene.add(mesh);
    const draw = () => {
      renderer.setRenderTarget(this.#target);
      renderer.render(this.#scene, this.#viewer);
    };
    offScreen(renderer, draw, options);
  }

  /**
   * Has all levels of the texture made, of which show() writes the first one alone. This is called while a scene is drawn: the next
   * one has them. Returns whether they are there.
   */
  makeLevels(renderer) {
    const isFirst = !this.#wantsLevels && !this.#hasLevels;
    this.#wantsLevels = true;
    if (!isFirst) return this.#hasLevels;
    queueMicrotask(() => {
      if (this.#hasLevels || !this.#target) return;
      this.#hasLevels = this.texture.mipmapsAutoUpdate = true;
      this.#draw(renderer, [], { clears: false });
    });
    return false;
  }

  #resize(width, height) {
    if (this.#target?.width === width && this.#target.height === height) return;
    this.#target?.dispose();
    const filters = { generateMipmaps: true, minFilter: LinearMipmapLinearFilter };
    this.#target = new RenderTarget(width, height, { depthBuffer: false, ...filters });
  }

  #tile(renderer, picture, { x, y }, i) {
    const { width, height, colour } = picture.video;
    const { kr, kb, range } = conversionOf(colour);
    const values = { place: [x, y], size: [width, height], targetSize: [this.width, this.height], range, kr, kb };
    const tile = (kind, textures) => {
      const key = `${i} ${kind.name}`;
      if (!this.#tiles.has(key)) this.#tiles.set(key, new Tile(kind, textures, this.#geometry));
      const found = this.#tiles.get(key);
      found.show(textures, values);
      return found;
    };
    if (picture.planes) return tile(fromPlanes, this.#sources.planesOf(i, picture));
    return tile(copied, [this.#sources.imageOf(i, picture)]);
  }

  dispose() {
    this.#sources.dispose();
    for (const tile of this.#tiles.values()) tile.dispose();
    this.#tiles.clear();
    this.#target?.dispose();
    this.#geometry.dispose();
    this.#target = this.texture = null;
  }
}
