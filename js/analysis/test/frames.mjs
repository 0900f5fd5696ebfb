// Frames as the decoder gives them, of the meshes and cameras of tests/analysis/cases.json.

/** A camera without a lens. */
function cameraOf({ id, K, R, t, size: [width, height] }) {
  const project = (...p) => {
    const [x, y, z] = R.map((row, k) => row.reduce((sum, r, i) => sum + r * p[i], t[k]));
    return z > 0 ? [(K[0][0] * x) / z + K[0][2], (K[1][1] * y) / z + K[1][2], z] : null;
  };
  const centre = [0, 1, 2].map((k) => -R.reduce((sum, row, i) => sum + row[k] * t[i], 0));
  return { id, width, height, fx: K[0][0], fy: K[1][1], centre, project, calibrated: true };
}

export const camerasOf = ({ cameras }) => cameras.map(cameraOf);

/** meshes: names, of the tracks 0, 1 and so on; metadata: texts of META. */
export function frameOf(cases, names, metadata = []) {
  const cameras = camerasOf(cases);
  const meshes = names.map((name, track) => {
    const { origin, points, faces } = cases.meshes[name];
    return {
      track,
      origin,
      localPositions: Float32Array.from(points.flat()),
      faces: Uint32Array.from(faces.flat()),
      faceCount: faces.length,
    };
  });
  const tile = ({ id, width, height }) => {
    const whole = { x: 0, y: 0, width, height };
    return { camera: id, source: whole, destination: whole };
  };
  return {
    time: 7n,
    number: 2,
    meshes,
    mesh: meshes[0],
    cameras,
    visibility: [],
    configuration: {
      timeBase: { numerator: 1, denominator: 4 },
      videos: [{ track: 9 }],
      texturing: cases.texturing,
      metadata,
      upAxis: "y",
    },
    tiles: () => cameras.map(tile),
  };
}
