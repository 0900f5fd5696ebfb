// Which cameras colour a place of the surface, and by how much: the rule of clause 17.5 in JavaScript. The shaders have the same
// constants. @fvv/decoder has a copy of this file, which its build makes, to choose tracks for a viewpoint.

/** What weights cameras, with the threshold that suits it: the least cosine between the normal and the ray to the camera. */
export const THRESHOLDS = { viewer: 0.05, paper: 0.25 };
/** Weights fall with the square of this number less the cosine between the rays to the camera and to the viewer. */
export const APART = 1.01;
/** The part of the weight of the best camera that is not used which is subtracted from the others: they fade in and out. */
export const FADE = 1023 / 1024;
/** Pixels of a tile over which the weight of its camera rises from the border on. */
export const BORDER = 8;

/** How much of a camera's weight is left by an interpolated visibility weight, 0 to 255: none from one half down. */
export const visibilityFactor = (blend, seen) =>
  blend === "paper" ? Number(seen >= 127.5) : Math.max(0, seen / 127.5 - 1);

/** The same at this many pixels of the tile inside its usable border. */
export const borderFactor = (blend, inside) =>
  blend === "paper" ? Number(inside >= 0) : Math.min(1, Math.max(0, inside / BORDER));

/**
 * The parts of the colour of a point that cameras give, [{camera: index, part}], the largest first; together 1, or none.
 * centres: of the cameras that show the point; eye: the viewer; factorOf(index): how much of a camera's weight is left by its
 * visibility weight and the border of its tile.
 */
export function partsAt(point, normal, centres, eye, { blend, threshold, best }, factorOf = () => 1) {
  const towards = (place) => {
    const ray = [place[0] - point[0], place[1] - point[1], place[2] - point[2]];
    const length = Math.hypot(ray[0], ray[1], ray[2]);
    return [ray[0] / length, ray[1] / length, ray[2] / length];
  };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const towardsEye = towards(eye);
  const weights = [];
  centres.forEach((centre, camera) => {
    const ray = towards(centre);
    const facing = dot(normal, ray);
    if (!(facing > 0 && (blend === "paper" ? facing >= threshold : facing > threshold))) return;
    const apart = APART - dot(ray, towardsEye);
    const full = blend === "paper" ? facing : (facing - threshold) / (1 - threshold) / (apart * apart);
    const weight = full * factorOf(camera);
    if (weight > 0) weights.push({ camera, weight });
  });
  weights.sort((a, b) => b.weight - a.weight);
  const next = blend === "paper" ? 0 : FADE * (weights[best]?.weight ?? 0);
  const used = weights.slice(0, best).map(({ camera, weight }) => ({ camera, part: Math.max(0, weight - next) }));
  const sum = used.reduce((total, { part }) => total + part, 0);
  return sum > 0 ? used.map(({ camera, part }) => ({ camera, part: part / sum })).filter(({ part }) => part > 0) : [];
}
