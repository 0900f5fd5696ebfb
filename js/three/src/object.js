// A frame of free-viewpoint video in a scene: its mesh, coloured at each point by the cameras that see it best.

import { pick } from "@fvv/analysis";
import {
  blending,
  checkTexturing,
  definesOf,
  closePictures,
  keepPictures,
  loadKept,
  loadPictures,
  MAX_WEIGHT_TEXELS,
  nearPlaneOf,
  originOf,
  pointsOf,
  projection,
  texturingOf,
  usesLevels,
  viewsOf,
  visibilityWeightsVertex,
} from "@fvv/shading";
import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  DataArrayTexture,
  DataTexture,
  DoubleSide,
  GLSL3,
  Matrix4,
  Mesh,
  Object3D,
  ShaderMaterial,
  Sphere,
  Vector2,
  Vector3,
  Vector4,
} from "three";

import { PictureTexture } from "./pictures.js";
import { DepthMaps, ViewTexture, VisibilityWeightTexture } from "./textures.js";

/** The shaders of three's material, built from those of @fvv/shading. */
const surfaceVertex = /* glsl */ `
out vec3 vPoint, vNormal;
out vec2 vUv;
#ifdef COLOURS
in vec4 vertexColour;
out vec3 vColour;
#endif
${visibilityWeightsVertex}
bool isPerspectiveMatrix(mat4 projection) {
  return projection[2][3] == -1.0;
}
#include <logdepthbuf_pars_vertex>
void main() {
  vPoint = position;
  vNormal = normal;
#ifdef ATLAS
  vUv = uv;
#endif
#ifdef COLOURS
  vColour = vertexColour.rgb;
#endif
  passVisibilityWeights();
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  #include <logdepthbuf_vertex>
}
`;

const surfaceFragment = /* glsl */ `
precision highp sampler2DArray;
uniform vec4 atlas; // x y width height, in texels of pictures
uniform float handedness;
in vec3 vPoint, vNormal;
in vec2 vUv;
#ifdef COLOURS
in vec3 vColour;
#else
const vec3 vColour = vec3(0.0);
#endif
layout(location = 0) out highp vec4 outColour;
#define gl_FragColor outColour
#include <logdepthbuf_pars_fragment>
${projection}
${blending}

void main() {
  #include <logdepthbuf_fragment>
#ifdef ATLAS
  vec3 colour = atlasColour(atlas, vUv);
#else
  // The front side by the winding of the face, not as the viewer sees it.
  vec3 faceNormal = normalize(cross(dFdx(vPoint), dFdy(vPoint))) * (gl_FrontFacing ? handedness : -handedness);
  vec3 colour = surfaceColour(vPoint, faceNormal, normalize(vNormal), vColour);
#endif
  // Cameras are mixed as display values; three continues in linear light and converts back at the end.
  outColour = sRGBTransferEOTF(vec4(colour, 1.0));
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

/** Allocates a quarter more: sizes of meshes with changing topology differ by less from frame to frame. */
const SPARE = 1.25;

/** A mesh that changes with every frame, in one BufferGeometry whose arrays are written in place. */
class MeshGeometry extends BufferGeometry {
  #extent = new Box3();

  /** mesh: the mesh of a frame. Its arrays are copied. */
  show(mesh) {
    const points = pointsOf(mesh);
    this.#fill("position", points, 3);
    this.#fill("normal", mesh.normals, 3);
    this.#fill("uv", mesh.uvs, 2);
    this.#fill("vertexColour", mesh.colours, 4);
    this.#fill("index", mesh.faces, 1);
    this.setDrawRange(0, mesh.faces.length);
    this.#extent.setFromArray(points);
    this.boundingBox = this.#extent.clone();
    this.boundingSphere = this.#extent.getBoundingSphere(this.boundingSphere ?? new Sphere());
  }

  #fill(name, values, components) {
    const former = name === "index" ? this.index : this.getAttribute(name);
    if (!values) {
      if (former) this.deleteAttribute(name);
      return;
    }
    let attribute = former;
    if (!attribute || attribute.array.length < values.length) {
      const room = components * Math.ceil((SPARE * values.length) / components);
      attribute = new BufferAttribute(new values.constructor(room), components, values instanceof Uint8Array);
      // three frees the buffers of a disposed geometry, and creates them again when it is drawn.
      if (former) this.dispose();
      if (name === "index") this.setIndex(attribute);
      else this.setAttribute(name, attribute);
    }
    attribute.array.set(values);
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, values.length);
    attribute.needsUpdate = true;
  }
}

/** Varyings other than visibility weights: point, normal, texture coordinates, colour, and one for three. */
const OTHER_VARYINGS = 5;

const worldToMesh = new Matrix4();

// WebGL requires a texture for every sampler.
const noTexture = new DataTexture(new Uint8Array(4), 1, 1);
const noLayers = new DataArrayTexture(new Uint8Array(4), 1, 1, 1);
noTexture.needsUpdate = noLayers.needsUpdate = true;

export class FvvObject3D extends Object3D {
  #renderer;
  #material;
  #geometry = new MeshGeometry();
  #pictures = new PictureTexture();
  #views = new ViewTexture();
  #visibilityWeights = new VisibilityWeightTexture();
  #depths = new DepthMaps(this.#geometry, this.#views);
  #mesh;
  #texturing;
  #turn = 0;
  #kept = []; // pictures of the frame that is shown
  #redraw = () => this.#drawAgain();
  #shown = { views: [], atlas: null };
  #frame = null; // that is shown, whose pictures may be closed

  constructor({ renderer, ...texturing }) {
    super();
    checkTexturing(texturing);
    this.#renderer = renderer;
    this.#texturing = texturing;
    this.#material = new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: surfaceVertex,
      fragmentShader: surfaceFragment,
      side: DoubleSide,
      // The colours are those of photographs, which have been tone mapped by the camera.
      toneMapped: false,
      defines: { WEIGHT_TEXELS: 0, BEST: 1 },
      uniforms: {
        pictures: { value: noTexture },
        pictureSize: { value: new Vector2(1, 1) },
        views: { value: this.#views },
        viewCount: { value: 0 },
        atlas: { value: new Vector4() },
        visibilityWeights: { value: noTexture },
        depths: { value: noLayers },
        nearPlane: { value: 0 },
        threshold: { value: 0 },
        eye: { value: new Vector3() },
        viewerRight: { value: new Vector3() },
        viewerUp: { value: new Vector3() },
        tolerance: { value: new Vector2() },
        inset: { value: 0 },
        handedness: { value: 1 },
        pixelAngle: { value: 0 },
        unseen: { value: new Vector3() },
      },
    });
    this.#mesh = new Mesh(this.#geometry, this.#material);
    this.#mesh.visible = false;
    this.#mesh.onBeforeRender = (renderer, scene, camera) => {
      const { eye, viewerRight, viewerUp } = this.#material.uniforms;
      worldToMesh.copy(this.#mesh.matrixWorld).invert();
      eye.value.setFromMatrixPosition(camera.matrixWorld).applyMatrix4(worldToMesh);
      viewerRight.value.setFromMatrixColumn(camera.matrixWorld, 0).transformDirection(worldToMesh);
      viewerUp.value.setFromMatrixColumn(camera.matrixWorld, 1).transformDirection(worldToMesh);
      this.#material.uniforms.handedness.value = this.#mesh.matrixWorld.determinant() < 0 ? -1 : 1;
      this.#prepareLevels(renderer, camera);
      this.#material.uniformsNeedUpdate = true;
    };
    this.add(this.#mesh);
    // After the renderer's own listener. What was uploaded or drawn into textures is lost.
    renderer.domElement.addEventListener("webglcontextrestored", this.#redraw);
    this.frame = null;
    this.viewCount = 0;
  }

  get mesh() {
    return this.#mesh;
  }

  /** Returns whether the frame is shown: of several concurrent calls only the last one is. */
  async show(frame) {
    if (frame.mesh && !frame.mesh.normals)
      throw new TypeError("the mesh has no normals: create the decoder with normals: true");
    const turn = ++this.#turn;
    const pictures = await loadPictures(frame);
    if (turn !== this.#turn) return false;
    this.frame = { number: frame.number, seconds: frame.seconds };
    this.#frame = frame;
    this.#mesh.visible = frame.mesh !== null && frame.mesh.faceCount > 0;
    closePictures(this.#kept);
    this.#kept = [];
    if (!this.#mesh.visible) return true;
    this.#kept = keepPictures(pictures, frame);
    this.#showMesh(frame, pictures);
    return true;
  }

  /** What a ray of the scene's world, a Ray of three, meets first of the frame, as pick of @fvv/analysis returns it. */
  pick(ray) {
    if (!this.#frame) return null;
    this.updateWorldMatrix(true, false);
    // In doubles, to the coordinates of the stream.
    const { origin, direction } = ray.clone().applyMatrix4(worldToMesh.copy(this.matrixWorld).invert());
    return pick(this.#frame, { origin: origin.toArray(), direction: direction.toArray() });
  }

  async #drawAgain() {
    const turn = this.#turn;
    if (!this.#mesh.visible) return;
    const pictures = await loadKept(this.#kept);
    if (turn !== this.#turn) return;
    this.#pictures.show(this.#renderer, pictures);
    this.#depths.render(this.#renderer, this.#shown.views);
    this.dispatchEvent({ type: "restored" });
  }

  #showMesh(frame, pictures) {
    const { mesh } = frame;
    this.#geometry.show(mesh);
    // three multiplies matrices in doubles, and the geometry counts from the origin.
    this.#mesh.position.fromArray(originOf(frame));
    const { min, max } = this.#geometry.boundingBox;
    const nearPlane = nearPlaneOf({ min: min.toArray(), max: max.toArray() });
    this.#depths.nearPlane = this.#material.uniforms.nearPlane.value = nearPlane;
    // An explicit colour overrides those of the stream.
    this.#define("COLOURS", mesh.colours && (this.#texturing.unseen ?? null) === null ? 1 : undefined);
    const layout = this.#pictures.show(this.#renderer, pictures);
    const { uniforms } = this.#material;
    if (layout.size) {
      uniforms.pictures.value = this.#pictures.texture;
      uniforms.pictureSize.value.set(this.#pictures.width, this.#pictures.height);
    }
    this.#setTexturing(frame.configuration);
    const views = viewsOf(frame, layout);
    this.#showViews(frame, views);
    const atlas = frame.configuration.videos.find((video) => video.shows === "atlas" && layout.has(video.track));
    const place = atlas && layout.get(atlas.track);
    // A texture atlas is used if there are no cameras.
    this.#setAtlas(place && mesh.uvs && !views.length ? [place.x, place.y, atlas.width, atlas.height] : null);
    this.#shown.views = views;
  }

  #setTexturing(configuration) {
    const { blend, best, threshold, unseen, tolerance, inset } = texturingOf(configuration, this.#texturing);
    const { uniforms } = this.#material;
    this.#define("BEST", best);
    this.#define("PAPER", blend === "paper" ? 1 : undefined);
    uniforms.threshold.value = threshold;
    uniforms.unseen.value.fromArray(unseen);
    uniforms.tolerance.value.fromArray(tolerance);
    this.#define("INSET", inset ? 1 : undefined);
    uniforms.inset.value = inset;
  }

  #showViews(frame, views) {
    const { uniforms } = this.#material;
    const gl = this.#renderer.getContext();
    const maxTexels = Math.min(MAX_WEIGHT_TEXELS, gl.getParameter(gl.MAX_VARYING_VECTORS) - OTHER_VARYINGS);
    const texels = this.#visibilityWeights.show(frame, frame.mesh, views, maxTexels);
    this.#define("WEIGHT_TEXELS", texels);
    if (texels) uniforms.visibilityWeights.value = this.#visibilityWeights.texture;
    this.#depths.plan(views);
    const { LENSES, VIEW_BLOCKS, DEPTHS } = definesOf(views);
    this.#define("LENSES", LENSES);
    this.#define("VIEW_BLOCKS", VIEW_BLOCKS);
    this.#define("DEPTHS", DEPTHS);
    this.#views.show(views);
    this.#depths.render(this.#renderer, views);
    uniforms.depths.value = this.#depths.texture ?? noLayers;
    uniforms.viewCount.value = this.viewCount = views.length;
  }

  /** atlas: its place, [x, y, width, height], or null. */
  #setAtlas(atlas) {
    this.#define("ATLAS", atlas ? 1 : undefined);
    if (atlas) this.#material.uniforms.atlas.value.fromArray(atlas);
    this.#shown.atlas = atlas;
  }

  /** Pictures have levels above the first only if the viewer is far away. */
  #prepareLevels(renderer, camera) {
    const { eye, pixelAngle } = this.#material.uniforms;
    const { height } = camera.viewport ?? renderer.getRenderTarget() ?? renderer.getDrawingBufferSize(new Vector2());
    pixelAngle.value = 2 / (camera.projectionMatrix.elements[5] * height);
    const { center, radius } = this.#geometry.boundingSphere;
    const sphere = { centre: center.toArray(), radius };
    const isFar = camera.isPerspectiveCamera && usesLevels(this.#shown, sphere, eye.value.toArray(), pixelAngle.value);
    if (isFar) this.#pictures.makeLevels(renderer);
    this.#define("LEVELS", isFar ? 1 : undefined);
  }

  #define(name, value) {
    const { defines } = this.#material;
    if (defines[name] === value) return;
    if (value === undefined) delete defines[name];
    else defines[name] = value;
    this.#material.needsUpdate = true;
  }

  dispose() {
    this.#turn++;
    this.#renderer.domElement.removeEventListener("webglcontextrestored", this.#redraw);
    closePictures(this.#kept);
    this.#kept = [];
    this.#material.dispose();
    this.#geometry.dispose();
    this.#pictures.dispose();
    this.#views.dispose();
    this.#visibilityWeights.dispose();
    this.#depths.dispose();
  }
}
