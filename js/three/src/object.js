// A frame of free-viewpoint video in a scene: its mesh, coloured at each point by the cameras that see it best.

import { pick } from "@fvv/analysis";
import { checkTexturing, closePictures, keepPictures, loadKept, loadPictures, originOf } from "@fvv/shading";
import { Matrix4, Mesh, Object3D } from "three";

import { MeshGeometry } from "./geometry.js";

const worldToObject = new Matrix4();

/** FvvObject3D for any renderer: Surface is the class of its Drawing. */
export class FrameObject extends Object3D {
  #renderer;
  #geometry = new MeshGeometry();
  #drawing;
  #mesh;
  #turn = 0;
  #kept = []; // pictures of the frame that is shown
  #redraw = () => this.#drawAgain();
  #frame = null; // that is shown, whose pictures may be closed

  constructor({ renderer, ...texturing }, Surface) {
    super();
    checkTexturing(texturing);
    this.#renderer = renderer;
    this.#drawing = new Surface({ renderer, geometry: this.#geometry, texturing });
    this.#mesh = new Mesh(this.#geometry, this.#drawing.material);
    this.#mesh.visible = false;
    this.#mesh.onBeforeRender = (current, scene, camera) => this.#drawing.prepare(current, camera, this.#mesh);
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
    const [pictures] = await Promise.all([loadPictures(frame), this.#drawing.ready()]);
    if (turn !== this.#turn) return false;
    this.frame = { number: frame.number, seconds: frame.seconds };
    this.#frame = frame;
    this.#mesh.visible = frame.mesh !== null && frame.mesh.faceCount > 0;
    closePictures(this.#kept);
    this.#kept = [];
    if (!this.#mesh.visible) return true;
    this.#kept = keepPictures(pictures, frame);
    this.#geometry.show(frame.mesh);
    // three multiplies matrices in doubles, and the geometry counts from the origin.
    this.#mesh.position.fromArray(originOf(frame));
    this.viewCount = this.#drawing.show(frame, pictures);
    return true;
  }

  /** What a ray of the scene's world, a Ray of three, meets first of the frame, as pick of @fvv/analysis returns it. */
  pick(ray) {
    if (!this.#frame) return null;
    this.updateWorldMatrix(true, false);
    // In doubles, to the coordinates of the stream.
    const { origin, direction } = ray.clone().applyMatrix4(worldToObject.copy(this.matrixWorld).invert());
    return pick(this.#frame, { origin: origin.toArray(), direction: direction.toArray() });
  }

  async #drawAgain() {
    const turn = this.#turn;
    if (!this.#mesh.visible) return;
    const pictures = await loadKept(this.#kept);
    if (turn !== this.#turn) return;
    this.#drawing.redraw(pictures);
    this.dispatchEvent({ type: "restored" });
  }

  dispose() {
    this.#turn++;
    this.#renderer.domElement.removeEventListener("webglcontextrestored", this.#redraw);
    closePictures(this.#kept);
    this.#kept = [];
    this.#drawing.dispose();
    this.#geometry.dispose();
  }
}
