// Coordinates that count from a place near the scene: 32 bits hold those of maps (UTM, earth-centred) to decimetres only.

/** Steps of the lattice. */
const UNIT = 2 ** 20;

/**
 * The lattice's origin in whole multiples of 2^20 steps, as libfvv's tools have it: floats hold indices beside them to a
 * fraction of a step, and scenes whose lattices begin near 0 stay where they are.
 */
export function localOriginOf({ origin, step }) {
  const unit = step * UNIT;
  return origin.map((x) => {
    const multiple = Math.sign(x) * Math.round(Math.abs(x) / unit) * unit;
    return Number.isFinite(multiple) ? multiple + 0 : 0; // never -0
  });
}

/**
 * positions, of a mesh whose indices on the lattice are given, relative to origin; the same array if origin is 0, where there
 * is no difference. Differences are formed in doubles and rounded once.
 */
export function localPositionsOf({ positions, lattice: indices }, lattice, origin) {
  if (!positions || origin.every((x) => x === 0)) return positions;
  const { step } = lattice;
  const [x, y, z] = lattice.origin.map((value, k) => value - origin[k]);
  const local = new Float32Array(indices.length);
  for (let i = 0; i < indices.length; i += 3) {
    local[i] = x + step * indices[i];
    local[i + 1] = y + step * indices[i + 1];
    local[i + 2] = z + step * indices[i + 2];
  }
  return local;
}
