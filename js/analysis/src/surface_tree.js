// The triangles of a mesh in a hierarchy of boxes, for rays. It is built when a frame is first touched, so the build has to be
// quick: triangles are sorted along the Morton curve, and the boxes of the sorted list form a complete binary tree. A tree by
// the surface area heuristic takes five times as long to build, and rays are not what takes time here.

import { pointsOf } from "@fvv/shading";

/** Triangles in a box of the lowest level. */
const LEAF = 4;
/** Bits of the Morton code per axis; the sort takes as many at once. */
const BITS = 10;
const CELLS = 1 << BITS;
/** A ray that meets an edge meets one of its triangles at least: by so much barycentric coordinates may be below 0. */
const EDGE = 1e-9;

/** The ten bits of x with two zeros after each. */
function spread(x) {
  x = (x | (x << 16)) & 0x030000ff;
  x = (x | (x << 8)) & 0x0300f00f;
  x = (x | (x << 4)) & 0x030c30c3;
  return (x | (x << 2)) & 0x09249249;
}

/** Sorts order by codes of 3 * BITS bits, each of the triangle with its number. */
function sortByCode(codes, order) {
  let [from, to] = [order, new Uint32Array(order.length)];
  for (let shift = 0; shift < 3 * BITS; shift += BITS) {
    const starts = new Uint32Array(CELLS + 1);
    for (let i = 0; i < from.length; i++) starts[((codes[from[i]] >>> shift) & (CELLS - 1)) + 1]++;
    for (let c = 0; c < CELLS; c++) starts[c + 1] += starts[c];
    for (let i = 0; i < from.length; i++) to[starts[(codes[from[i]] >>> shift) & (CELLS - 1)]++] = from[i];
    [from, to] = [to, from];
  }
  return from;
}

/** Triangles along the Morton curve of their middles. */
function mortonOrder(points, faces) {
  const count = faces.length / 3;
  const middles = new Float32Array(faces.length);
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f];
    const b = 3 * faces[f + 1];
    const c = 3 * faces[f + 2];
    for (let k = 0; k < 3; k++) {
      const middle = points[a + k] + points[b + k] + points[c + k];
      middles[f + k] = middle;
      if (middle < low[k]) low[k] = middle;
      if (middle > high[k]) high[k] = middle;
    }
  }
  const size = Math.max(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  const scale = size > 0 ? (CELLS - 0.01) / size : 0;
  const codes = new Uint32Array(count);
  const order = new Uint32Array(count);
  for (let i = 0; i < count; i++) {
    const x = spread((middles[3 * i] - low[0]) * scale);
    const y = spread((middles[3 * i + 1] - low[1]) * scale);
    const z = spread((middles[3 * i + 2] - low[2]) * scale);
    codes[i] = x | (y << 1) | (z << 2);
    order[i] = i;
  }
  return sortByCode(codes, order);
}

export class SurfaceTree {
  #points;
  #faces;
  #order;
  /** Of node i: least x y z, greatest x y z. Its children are 2 i and 2 i + 1; node 1 is all, and node leaves + k is leaf k. */
  #boxes;
  #leaves = 1;

  /** points: x y z of each vertex; faces: three vertices each. Both are borrowed. */
  constructor(points, faces) {
    this.#points = points;
    this.#faces = faces;
    this.#order = mortonOrder(points, faces);
    while (this.#leaves * LEAF < this.#order.length) this.#leaves *= 2;
    this.#boxes = new Float32Array(12 * this.#leaves);
    this.#fill();
  }

  #fill() {
    const boxes = this.#boxes;
    const order = this.#order;
    const faces = this.#faces;
    const points = this.#points;
    for (let leaf = 0; leaf < this.#leaves; leaf++) {
      const at = 6 * (this.#leaves + leaf);
      let x0 = Infinity;
      let y0 = Infinity;
      let z0 = Infinity;
      let x1 = -Infinity;
      let y1 = -Infinity;
      let z1 = -Infinity;
      const end = Math.min(order.length, (leaf + 1) * LEAF);
      for (let i = leaf * LEAF; i < end; i++)
        for (let corner = 3 * order[i], last = corner + 3; corner < last; corner++) {
          const v = 3 * faces[corner];
          const x = points[v];
          const y = points[v + 1];
          const z = points[v + 2];
          if (x < x0) x0 = x;
          if (x > x1) x1 = x;
          if (y < y0) y0 = y;
          if (y > y1) y1 = y;
          if (z < z0) z0 = z;
          if (z > z1) z1 = z;
        }
      boxes[at] = x0;
      boxes[at + 1] = y0;
      boxes[at + 2] = z0;
      boxes[at + 3] = x1;
      boxes[at + 4] = y1;
      boxes[at + 5] = z1;
    }
    for (let node = this.#leaves - 1; node > 0; node--)
      for (let k = 0; k < 3; k++) {
        const one = 12 * node + k;
        const other = one + 6;
        boxes[6 * node + k] = Math.min(boxes[one], boxes[other]);
        boxes[6 * node + 3 + k] = Math.max(boxes[one + 3], boxes[other + 3]);
      }
  }

  /**
   * The nearest triangle on a ray, from either side: {face, barycentric, distance}, or null. origin: counts as the points do;
   * direction: of any length, by which distance counts. Triangles nearer than `least`, further than `most`, and the face
   * `except` are passed through.
   */
  cast(origin, direction, { least = 0, most = Infinity, except = -1 } = {}) {
    const [ox, oy, oz] = origin;
    // A box whose side the ray runs along is entered by comparison of numbers, not of NaN.
    const [ix, iy, iz] = direction.map((d) => 1 / (d || 1e-300));
    const boxes = this.#boxes;
    const found = { face: -1, distance: most, u: 0, v: 0, least, except };
    const enters = (node) => {
      const at = 6 * node;
      const x0 = (boxes[at] - ox) * ix;
      const x1 = (boxes[at + 3] - ox) * ix;
      const y0 = (boxes[at + 1] - oy) * iy;
      const y1 = (boxes[at + 4] - oy) * iy;
      const z0 = (boxes[at + 2] - oz) * iz;
      const z1 = (boxes[at + 5] - oz) * iz;
      const near = Math.max(Math.min(x0, x1), Math.min(y0, y1), Math.min(z0, z1), least);
      const far = Math.min(Math.max(x0, x1), Math.max(y0, y1), Math.max(z0, z1));
      return near <= far * (1 + 1e-12) ? near : Infinity;
    };
    const nodes = [1];
    const nears = [enters(1)];
    while (nodes.length) {
      const node = nodes.pop();
      if (!(nears.pop() <= found.distance)) continue;
      if (node >= this.#leaves) {
        this.#meet(node - this.#leaves, origin, direction, found);
        continue;
      }
      const one = 2 * node;
      const other = one + 1;
      const oneNear = enters(one);
      const otherNear = enters(other);
      const oneFirst = oneNear <= otherNear;
      // The nearer one is on top.
      if (Math.max(oneNear, otherNear) < Infinity) {
        nodes.push(oneFirst ? other : one);
        nears.push(oneFirst ? otherNear : oneNear);
      }
      if (Math.min(oneNear, otherNear) < Infinity) {
        nodes.push(oneFirst ? one : other);
        nears.push(oneFirst ? oneNear : otherNear);
      }
    }
    if (found.face < 0) return null;
    const [u, v] = [Math.max(0, found.u), Math.max(0, found.v)];
    const sum = Math.max(1, u + v);
    const barycentric = [Math.max(0, 1 - (u + v) / sum), u / sum, v / sum];
    return { face: found.face, barycentric, distance: found.distance };
  }

  /** The triangles of a leaf against a ray, as Möller and Trumbore do. */
  #meet(leaf, [ox, oy, oz], [dx, dy, dz], found) {
    const points = this.#points;
    const faces = this.#faces;
    const end = Math.min(this.#order.length, (leaf + 1) * LEAF);
    for (let i = leaf * LEAF; i < end; i++) {
      const face = this.#order[i];
      const a = 3 * faces[3 * face];
      const b = 3 * faces[3 * face + 1];
      const c = 3 * faces[3 * face + 2];
      const ax = points[a];
      const ay = points[a + 1];
      const az = points[a + 2];
      const bx = points[b] - ax;
      const by = points[b + 1] - ay;
      const bz = points[b + 2] - az;
      const cx = points[c] - ax;
      const cy = points[c + 1] - ay;
      const cz = points[c + 2] - az;
      const px = dy * cz - dz * cy;
      const py = dz * cx - dx * cz;
      const pz = dx * cy - dy * cx;
      const volume = bx * px + by * py + bz * pz;
      if (volume === 0 || face === found.except) continue;
      const tx = ox - ax;
      const ty = oy - ay;
      const tz = oz - az;
      const u = (tx * px + ty * py + tz * pz) / volume;
      if (!(u >= -EDGE && u <= 1 + EDGE)) continue;
      const qx = ty * bz - tz * by;
      const qy = tz * bx - tx * bz;
      const qz = tx * by - ty * bx;
      const v = (dx * qx + dy * qy + dz * qz) / volume;
      if (!(v >= -EDGE && u + v <= 1 + EDGE)) continue;
      const distance = (cx * qx + cy * qy + cz * qz) / volume;
      if (!(distance >= found.least && distance <= found.distance)) continue;
      // Of triangles at the same distance the first one.
      if (distance === found.distance && found.face >= 0 && face > found.face) continue;
      found.face = face;
      found.distance = distance;
      found.u = u;
      found.v = v;
    }
  }
}

const trees = new WeakMap();

/** The hierarchy of a mesh, built by the first call. Its points count from the mesh's origin. */
export function treeOf(mesh) {
  let tree = trees.get(mesh);
  if (!tree) trees.set(mesh, (tree = new SurfaceTree(pointsOf(mesh), mesh.faces)));
  return tree;
}
