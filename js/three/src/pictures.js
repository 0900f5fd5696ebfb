// The pictures of a frame as one texture of display values. Most streams have one video with all cameras. A picture that
// lies on the GPU, or is RGB, goes to the texture as it is. One of planes in memory is converted here: browsers take the
// nearest sample of colour for each pixel, and matrix and range from wherever they like.

import {
  Camera,
  DataTexture,
  LinearFilter,
  Mesh,
  NearestFilter,
  NoBlending,
  NoColorSpace,
  PlaneGeometry,
  RedFormat,
  Scene,
  ShaderMaterial,
  GLSL3,
  Texture,
  UnsignedByteType,
  Vector2,
  Vector3,
  WebGLRenderTarget,
} from "three";

import { offScreen } from "./off_screen.js";
import { copyFragment, planesFragment, wholeVertex } from "./shaders.js";

/** Kr and Kb of ITU-T H.273's matrix coefficients; others, and 2, are taken for BT.709. */
const luma = { 4: [0.3, 0.11], 5: [0.299, 0.114], 6: [0.299, 0.114], 7: [0.212, 0.087], 9: [0.2627, 0.0593] };
const bt709 = [0.2126, 0.0722];

/** What has to be waited for: [{video, image}] or, of planes in memory, [{video, planes}]. */
export async function loadPictures(frame) {
  const pictures = frame.configuration.videos.map(async (video) => {
    const image = frame.picture(video.track);
    if (image?.format !== "I420") return { video, image };
    const { width, height } = image.visibleRect;
    const [columns, rows] = [Math.ceil(width / 2), Math.ceil(height / 2)];
    const chroma = columns * rows;
    const bytes = new Uint8Array(width * height + 2 * chroma);
    const layout = [
      { offset: 0, stride: width },
      { offset: width * height, stride: columns },
      { offset: width * height + chroma, stride: columns },
    ];
    await image.copyTo(bytes, { layout });
    const plane = ({ offset, stride }, height) => ({
      data: bytes.subarray(offset, offset + stride * height),
      width: stride,
      height,
    });
    return { video, planes: [plane(layout[0], height), plane(layout[1], rows), plane(layout[2], rows)] };
  });
  return (await Promise.all(pictures)).filter(({ image, planes }) => image || planes);
}

function upload(Type, ...parameters) {
  const texture = new Type(...parameters);
  // Tiles are found by their rows from the top, and ImageBitmaps can't be turned over.
  texture.flipY = false;
  texture.colorSpace = NoColorSpace;
  texture.generateMipmaps = false;
  texture.unpackAlignment = 1;
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

function sizeOf(image) {
  return [image.displayWidth ?? image.width, image.displayHeight ?? image.height];
}

export class PictureTexture {
  texture = null;
  width = 1;
  height = 1;
  #sources = new Map(); // key -> texture that is uploaded to
  #target = null;
  #scene = new Scene();
  #quad;
  #materials = new Map();

  constructor() {
    this.#quad = new Mesh(new PlaneGeometry(2, 2));
    this.#quad.frustumCulled = false;
    this.#scene.add(this.#quad);
  }

  /** Uploads what loadPictures had. Answers where the picture of each track stands: Map from track to {x, y}. */
  show(renderer, pictures) {
    const layout = new Map();
    let width = 0;
    let height = 0;
    for (const { video } of pictures) {
      layout.set(video.track, { x: 0, y: height });
      width = Math.max(width, video.width);
      height += video.height;
    }
    if (!pictures.length) return layout;
    Object.assign(this, { width, height });
    if (pictures.length === 1 && pictures[0].image) {
      this.texture = this.#source("image", Texture, pictures[0].image, ...sizeOf(pictures[0].image));
      // Now: the caller may close the frame as soon as it has been shown.
      renderer.initTexture(this.texture);
    } else {
      this.#resize(width, height);
      this.texture = this.#target.texture;
      offScreen(renderer, () => {
        pictures.forEach((picture, i) => this.#draw(renderer, picture, layout.get(picture.video.track), i));
      });
    }
    return layout;
  }

  /** A texture of a size is kept, and gets the next picture. */
  #source(key, Type, image, width, height) {
    const known = this.#sources.get(key);
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
    this.#sources.set(key, { texture, width, height });
    return texture;
  }

  #resize(width, height) {
    if (this.#target?.width === width && this.#target.height === height) return;
    this.#target?.dispose();
    this.#target = new WebGLRenderTarget(width, height, { depthBuffer: false, generateMipmaps: false });
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

  #draw(renderer, { video, image, planes }, { x, y }, i) {
    const place = new Vector2(x, y);
    if (planes) {
      const [Y, U, V] = planes.map((plane, k) =>
        this.#source(`${i} ${k}`, DataTexture, plane, plane.width, plane.height),
      );
      const [kr, kb] = luma[video.colour.matrix] ?? bt709;
      const { fullRange } = video.colour;
      const range = fullRange ? new Vector3(0, 1, 1) : new Vector3(16 / 255, 255 / 219, 255 / 224);
      this.#quad.material = this.#material(planesFragment, { Y, U, V, range, place, kr, kb });
    } else {
      const picture = this.#source(`${i}`, Texture, image, ...sizeOf(image));
      picture.minFilter = picture.magFilter = NearestFilter;
      this.#quad.material = this.#material(copyFragment, { picture, place });
    }
    this.#target.viewport.set(x, y, video.width, video.height);
    this.#target.scissor.set(x, y, video.width, video.height);
    this.#target.scissorTest = true;
    renderer.setRenderTarget(this.#target);
    renderer.render(this.#scene, noViewer);
  }

  dispose() {
    for (const { texture } of this.#sources.values()) texture.dispose();
    for (const material of this.#materials.values()) material.dispose();
    this.#sources.clear();
    this.#materials.clear();
    this.#target?.dispose();
    this.#quad.geometry.dispose();
    this.#target = this.texture = null;
  }
}

const noViewer = new Camera();
