// The connected pieces of a mesh. Vertices at one place are one, as of meshes whose texture has seams.

import { pointsOf } from "@fvv/shading";

/** What the local positions of a mesh count from. */
export const originOf = ({ origin }) => origin ?? [0, 0, 0];

/** The corners of a face, which count from the mesh's origin. */
export function cornersOf(mesh, face) {
  const points = pointsOf(mesh);
  return [0, 1, 2].map((k) => {
    const v = 3 * mesh.faces[3 * face + k];
    return [points[v], points[v + 1], points[v + 2]];
  });
}

/** For each vertex the first one at the same place. */
function firstAlike(points) {
  const count = points.length / 3;
  let size = 16;
  while (size < 2 * count) size *= 2;
  const table = new Int32Array(size).fill(-1);
  const bits = new Int32Array(Float32Array.from(points, (x) => x + 0).buffer); // -0 is 0
  const first = new Uint32Array(count);
  for (let v = 0; v < count; v++) {
    const [x, y, z] = [bits[3 * v], bits[3 * v + 1], bits[3 * v + 2]];
    let hash = Math.imul(x, 0x9e3779b1) ^ Math.imul(y, 0x85ebca6b) ^ Math.imul(z, 0xc2b2ae35);
    let slot = (hash ^ (hash >>> 15)) & (size - 1);
    for (; table[slot] >= 0; slot = (slot + 1) & (size - 1)) {
      const other = 3 * table[slot];
      if (bits[other] === x && bits[other + 1] === y && bits[other + 2] === z) break;
    }
    if (table[slot] < 0) table[slot] = v;
    first[v] = table[slot];
  }
  return first;
}

function rootOf(parent, v) {
  while (parent[v] !== v) v = parent[v] = parent[parent[v]];
  return v;
}

const known = new WeakMap();

/**
 * {ofFace, pieces}: the number of the piece of each face, and of each piece {centre, area, radius, faces}: the centre of its
 * surface in the coordinates of the stream, square metres, metres to the furthest corner, and how many faces it has. Found
 * once for a mesh.
 */
export function piecesOf(mesh) {
  let found = known.get(mesh);
  if (!found) known.set(mesh, (found = findPieces(mesh)));
  return found;
}

function findPieces(mesh) {
  const { faces } = mesh;
  const points = pointsOf(mesh);
  const parent = firstAlike(points);
  for (let i = 0; i < faces.length; i += 3)
    for (let k = 1; k < 3; k++) {
      const a = rootOf(parent, faces[i]);
      const b = rootOf(parent, faces[i + k]);
      parent[Math.max(a, b)] = Math.min(a, b);
    }
  const numbers = new Int32Array(parent.length).fill(-1);
  const ofFace = new Uint32Array(faces.length / 3);
  const sums = [];
  for (let f = 0; f < ofFace.length; f++) {
    const root = rootOf(parent, faces[3 * f]);
    if (numbers[root] < 0) numbers[root] = sums.push({ x: 0, y: 0, z: 0, area: 0, faces: 0, square: 0 }) - 1;
    ofFace[f] = numbers[root];
    add(sums[ofFace[f]], points, 3 * faces[3 * f], 3 * faces[3 * f + 1], 3 * faces[3 * f + 2]);
  }
  for (const sum of sums) for (const k of ["x", "y", "z"]) sum[k] = sum.area > 0 ? sum[k] / sum.area : 0;
  for (let i = 0; i < faces.length; i++) {
    const sum = sums[ofFace[Math.floor(i / 3)]];
    const v = 3 * faces[i];
    const square = (points[v] - sum.x) ** 2 + (points[v + 1] - sum.y) ** 2 + (points[v + 2] - sum.z) ** 2;
    if (square > sum.square) sum.square = square;
  }
  const origin = originOf(mesh);
  const pieces = sums.map(({ x, y, z, area, faces: count, square }) => ({
    centre: [origin[0] + x, origin[1] + y, origin[2] + z],
    area,
    radius: Math.sqrt(square),
    faces: count,
  }));
  return { ofFace, pieces };
}

/** Adds a triangle to the sums of a piece. */
function add(sum, points, a, b, c) {
  const bx = points[b] - points[a];
  const by = points[b + 1] - points[a + 1];
  const bz = points[b + 2] - points[a + 2];
  const cx = points[c] - points[a];
  const cy = points[c + 1] - points[a + 1];
  const cz = points[c + 2] - points[a + 2];
  const area = Math.hypot(by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx) / 2;
  sum.x += area * (points[a] + (bx + cx) / 3);
  sum.y += area * (points[a + 1] + (by + cy) / 3);
  sum.z += area * (points[a + 2] + (bz + cz) / 3);
  sum.area += area;
  sum.faces++;
}
