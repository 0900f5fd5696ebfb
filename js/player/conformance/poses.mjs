// Places to look from: around the mesh, and where the stream's cameras stand.

const ups = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], "-x": [-1, 0, 0], "-y": [0, -1, 0], "-z": [0, 0, -1] };
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function orbit(count, { bounds, upAxis }, [, height]) {
  const up = ups[upAxis] ?? ups.y;
  const centre = bounds.least.map((value, k) => (value + bounds.most[k]) / 2);
  const radius = Math.hypot(...bounds.least.map((value, k) => bounds.most[k] - value)) / 2;
  const across = cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1]);
  const along = cross(across, up);
  return Array.from({ length: count }, (_, i) => {
    // A golden angle apart, from slightly below the middle to well above it.
    const angle = 2.39996 * i;
    const rise = -0.1 + (0.7 * i) / Math.max(1, count - 1);
    const level = Math.sqrt(1 - rise * rise);
    const distance = 2.4 * radius;
    const eye = centre.map(
      (x, k) => x + distance * (level * (Math.cos(angle) * across[k] + Math.sin(angle) * along[k]) + rise * up[k]),
    );
    return { name: `orbit ${i}`, eye, target: centre, up, focal: 1.05 * height };
  });
}

/** Without the lens, and looking through the middle of the picture. */
function fromCamera({ id, centre, rotation: r, fx, width }, [columns]) {
  const target = centre.map((x, k) => x + r[6 + k]);
  return { name: `camera ${id}`, eye: centre, target, up: [-r[3], -r[4], -r[5]], focal: (fx * columns) / width };
}

/** facts: of the page; at most 8 in 20 are the cameras'. */
export function posesOf(count, facts, size) {
  const calibrated = facts.cameras.filter((camera) => camera.calibrated);
  const own = Math.min(calibrated.length, Math.floor(0.4 * count));
  const chosen = Array.from({ length: own }, (_, i) => calibrated[Math.floor((i * calibrated.length) / own)]);
  return [...orbit(count - own, facts, size), ...chosen.map((camera) => fromCamera(camera, size))];
}

/** What viewFromPose takes. */
export function poseOf({ eye, target, up, focal }, [width, height]) {
  return { eye, target, up, fov: 2 * Math.atan(height / (2 * focal)), width, height };
}

/** What fvvrender takes. */
export function optionsOf({ eye, target, up, focal }, [width, height]) {
  return ["--pose", [...eye, ...target, ...up].join(), "--focal", `${focal}`, "--size", `${width}x${height}`];
}
