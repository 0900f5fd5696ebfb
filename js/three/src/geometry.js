// The mesh of a frame as one BufferGeometry, whose arrays are written in place.

import { pointsOf } from "@fvv/shading";
import { Box3, BufferAttribute, BufferGeometry, Sphere } from "three";

/** Allocates a quarter more: sizes of meshes with changing topology differ by less from frame to frame. */
const SPARE = 1.25;

/** A mesh that changes with every frame, in one BufferGeometry whose arrays are written in place. */
export class MeshGeometry extends BufferGeometry {
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
