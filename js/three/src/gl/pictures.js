// The pictures of a frame as one texture of display values.

import {
  conversionOf,
  copyFragment,
  layoutOf,
  planesFragment,
  replicatedFragment,
  Replication,
  replicationFragment,
  replicationOf,
} from "@fvv/shading";
import {
  GLSL3,
  LinearMipmapLinearFilter,
  Mesh,
  NoBlending,
  OrthographicCamera,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  Vector2,
  Vector3,
  Vector4,
  WebGLRenderTarget,
} from "three";

import { offScreen, Sources } from "../textures.js";

/** A quad that covers the viewport. */
const wholeVertex = /* glsl */ `
void main() {
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;

export class PictureTexture {
  texture = null;
  width = 1;
  height = 1;
  #sources = new Sources();
  #target = null;
  #scene = new Scene();
  #quad;
  #materials = new Map();
  #replication = new Replication();
  #hasLevels = false;

  constructor() {
    this.#quad = new Mesh(new PlaneGeometry(2, 2));
    this.#quad.frustumCulled = false;
    this.#scene.add(this.#quad);
  }

  /** Uploads the pictures of loadPictures. Returns where the picture of each track is: Map from track to {x, y}. */
  show(renderer, pictures) {
    const { places, width, height } = layoutOf(pictures);
    if (!pictures.length) return places;
    Object.assign(this, { width, height });
    this.#hasLevels = false;
    this.#resize(width, height);
    this.texture = this.#target.texture;
    offScreen(renderer, () => {
      pictures.forEach((picture, i) => this.#draw(renderer, picture, places.get(picture.video.track), i));
    });
    return places;
  }

  /** Makes all levels of the texture, of which show() writes the first one alone. Returns true. */
  makeLevels(renderer) {
    if (this.#hasLevels) return true;
    this.#hasLevels = true;
    // three makes levels at the end of what it draws into a target.
    this.texture.mipmapsAutoUpdate = true;
    const drawNothing = () => {
      renderer.setRenderTarget(this.#target);
      renderer.render(nothing, noViewer);
    };
    offScreen(renderer, drawNothing, { clears: false });
    this.texture.mipmapsAutoUpdate = false;
    return true;
  }

  #resize(width, height) {
    if (this.#target?.width === width && this.#target.height === height) return;
    this.#target?.dispose();
    const filters = { generateMipmaps: true, minFilter: LinearMipmapLinearFilter };
    this.#target = new WebGLRenderTarget(width, height, { depthBuffer: false, ...filters });
    this.#target.texture.mipmapsAutoUpdate = false;
  }

  #material(fragmentShader, uniforms) {
    let material = this.#materials.get(fragmentShader);
    if (!material) {
      const found = { glslVersion: GLSL3, vertexShader: wholeVertex, fragmentShader, depthTest: false };
      material = new ShaderMaterial({ ...found, depthWrite: false, blending: NoBlending, toneMapped: false });
      this.#materials.set(fragmentShader, material);
    }
    for (const [name, value] of Object.entries(uniforms)) material.uniforms[name] = { value };
    material.uniformsNeedUpdate = true;
    return material;
  }

  #draw(renderer, picture, { x, y }, i) {
    const { width, height, colour } = picture.video;
    this.#target.viewport.set(x, y, width, height);
    this.#target.scissor.set(x, y, width, height);
    this.#target.scissorTest = true;
    const { kr, kb, range } = conversionOf(colour);
    const common = { place: new Vector2(x, y), range: new Vector3(...range), kr, kb };
    const draw = (fragmentShader, uniforms) => {
      this.#quad.material = this.#material(fragmentShader, { ...common, ...uniforms });
      renderer.setRenderTarget(this.#target);
      renderer.render(this.#scene, noViewer);
    };
    if (picture.planes) {
      const [Y, U, V] = this.#sources.planesOf(i, picture);
      draw(planesFragment, { Y, U, V });
      return;
    }
    const source = this.#sources.imageOf(i, picture);
    const { mixing, luma } = replicationOf(picture);
    const undone = { picture: source, mixing: new Vector4(...mixing), luma: new Vector2(...luma) };
    const isReplicated = this.#replication.isSeenIn(picture, () => {
      draw(replicationFragment, undone);
      const pixels = new Uint8Array(4 * width * height);
      renderer.readRenderTargetPixels(this.#target, x, y, width, height, pixels);
      return pixels;
    });
    draw(isReplicated ? replicatedFragment : copyFragment, undone);
  }

  dispose() {
    this.#sources.dispose();
    for (const material of this.#materials.values()) material.dispose();
    this.#materials.clear();
    this.#target?.dispose();
    this.#quad.geometry.dispose();
    this.#target = this.texture = null;
  }
}

const noViewer = new OrthographicCamera();
const nothing = new Scene();
