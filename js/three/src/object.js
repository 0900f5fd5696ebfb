// A frame of free-viewpoint video in a scene: its mesh, coloured at each point by the cameras that see it best.

import { pick, treeOf } from "@fvv/analysis";
import { checkTexturing, closePictures, keepPictures, loadKept, loadPictures, originOf } from "@fvv/shading";
import { Matrix4, Mesh, Object3D, Ray, Vector2, Vector3 } from "three";

import { MeshGeometry } from "./geometry.js";

const worldToObject = new Matrix4();
const local = new Ray();

/** FvvObject3D for any renderer: Surface is the class of its Drawing. */
export class FrameObject extends Object3D {
  #renderer;
  #geometry = new MeshGeometry();
  #drawing;
  #meshes = []; // that are drawn: the object's own, and those of instances
  #turn = 0;
  #kept = []; // pictures of the frame that is shown
  #redraw = () => this.#drawAgain();
  #frame = null; // that is shown, whose pictures may be closed

  constructor({ renderer, ...texturing }, Surface) {
    super();
    checkTexturing(texturing);
    this.#renderer = renderer;
    this.#drawing = new Surface({ renderer, geometry: this.#geometry, texturing });
    this.add(this.#addMesh());
    this.mesh.visible = false;
    // After the renderer's own listener. What was uploaded or drawn into textures is lost.
    renderer.domElement.addEventListener("webglcontextrestored", this.#redraw);
    this.frame = null;
    this.viewCount = 0;
  }

  #addMesh() {
    const mesh = new Mesh(this.#geometry, this.#drawing.material);
    mesh.onBeforeRender = (current, scene, camera) => {
      this.#drawing.prepare(current, camera, mesh);
      this.viewedBy(camera);
    };
    mesh.raycast = (raycaster, found) => this.#cast(mesh, raycaster, found);
    this.#meshes.push(mesh);
    return mesh;
  }

  /** Called for each camera that draws a mesh of the object. */
  viewedBy() {}

  get mesh() {
    return this.#meshes[0];
  }

  /**
   * Another object that shows what this one shows, for another place of the scene: nothing is decoded or uploaded for it again. It has
   * the coordinates of the stream, as this one has. Its dispose() takes it away.
   */
  instance() {
    const parent = new Object3D();
    const mesh = this.#addMesh();
    const { visible, castShadow, receiveShadow, position } = this.mesh;
    Object.assign(mesh, { visible, castShadow, receiveShadow });
    mesh.position.copy(position);
    parent.dispose = () => {
      this.#meshes = this.#meshes.filter((one) => one !== mesh);
      parent.removeFromParent();
    };
    return parent.add(mesh);
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
    const isVisible = frame.mesh !== null && frame.mesh.faceCount > 0;
    closePictures(this.#kept);
    this.#kept = isVisible ? keepPictures(pictures, frame) : [];
    if (isVisible) {
      this.#geometry.show(frame.mesh);
      this.viewCount = this.#drawing.show(frame, pictures);
    }
    for (const mesh of this.#meshes) {
      mesh.visible = isVisible;
      // three multiplies matrices in doubles, and the geometry counts from the origin.
      if (isVisible) mesh.position.fromArray(originOf(frame));
    }
    return true;
  }

  /** Shows nothing until the next frame. */
  vacate() {
    this.#turn++;
    this.#frame = this.frame = null;
    for (const mesh of this.#meshes) mesh.visible = false;
  }

  /** What a ray of the scene's world, a Ray of three, meets first of the frame, as pick of @fvv/analysis returns it. */
  pick(ray) {
    if (!this.#frame) return null;
    this.updateWorldMatrix(true, false);
    // In doubles, to the coordinates of the stream.
    const { origin, direction } = ray.clone().applyMatrix4(worldToObject.copy(this.matrixWorld).invert());
    return pick(this.#frame, { origin: origin.toArray(), direction: direction.toArray() });
  }

  /** For three's Raycaster: the first triangle of the mesh on the ray. */
  #cast(mesh, { ray, near, far }, found) {
    if (!mesh.visible || !this.#frame?.mesh) return;
    const { faces } = this.#frame.mesh;
    local.copy(ray).applyMatrix4(worldToObject.copy(mesh.matrixWorld).invert());
    const hit = treeOf(this.#frame.mesh).cast(local.origin.toArray(), local.direction.toArray());
    if (!hit) return;
    const [a, b, c] = [0, 1, 2].map((k) => faces[3 * hit.face + k]);
    const blended = (name, Type) => {
      const attribute = this.#geometry.getAttribute(name);
      if (!attribute) return undefined;
      const sum = new Type();
      [a, b, c].forEach((v, k) =>
        sum.addScaledVector(new Type().fromBufferAttribute(attribute, v), hit.barycentric[k]),
      );
      return sum;
    };
    const point = blended("position", Vector3).applyMatrix4(mesh.matrixWorld);
    const distance = ray.origin.distanceTo(point);
    if (distance < near || distance > far) return;
    const [p, q, r] = [a, b, c].map((v) =>
      new Vector3().fromBufferAttribute(this.#geometry.getAttribute("position"), v),
    );
    const normal = q.sub(p).cross(r.sub(p)).normalize();
    const face = { a, b, c, normal, materialIndex: 0 };
    const barycoord = new Vector3(...hit.barycentric);
    found.push({ distance, point, object: mesh, face, faceIndex: hit.face, barycoord, uv: blended("uv", Vector2) });
  }

  async #drawAgain() {
    const turn = this.#turn;
    if (!this.mesh.visible) return;
    const pictures = await loadKept(this.#kept);
    if (turn !== this.#turn) return;
    this.#drawing.redraw(pictures);
    this.dispatchEvent({ type: "restored" });
  }

  dispose() {
    this.vacate();
    this.#renderer.domElement.removeEventListener("webglcontextrestored", this.#redraw);
    closePictures(this.#kept);
    this.#kept = [];
    this.#drawing.dispose();
    this.#geometry.dispose();
  }
}
