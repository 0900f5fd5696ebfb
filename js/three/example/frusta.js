// The cameras of a stream as frusta: lines through the border of each picture, as the lens bends them.

import { BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments } from "three";

/** Points along a side of the picture. */
const STEPS = 6;

function border({ width, height }) {
  const points = [];
  for (let i = 0; i < STEPS; i++) points.push([(width * i) / STEPS, 0]);
  for (let i = 0; i < STEPS; i++) points.push([width, (height * i) / STEPS]);
  for (let i = 0; i < STEPS; i++) points.push([width - (width * i) / STEPS, height]);
  for (let i = 0; i < STEPS; i++) points.push([0, height - (height * i) / STEPS]);
  return points;
}

/** R^T (depth ray - t): world metres. */
function place({ rotation: r, translation: t }, ray, depth) {
  const at = ray.map((x, i) => depth * x - t[i]);
  return [0, 1, 2].map((i) => r[i] * at[0] + r[3 + i] * at[1] + r[6 + i] * at[2]);
}

export class CameraFrusta extends LineSegments {
  #shown = "";

  constructor(colour) {
    super(new BufferGeometry(), new LineBasicMaterial({ color: colour, toneMapped: false }));
    this.visible = false;
  }

  /** length: of a frustum, in metres. Lines are made again only if cameras move. */
  show(cameras, length) {
    const calibrated = cameras.filter((camera) => camera.calibrated);
    const state = calibrated.map(({ translation, rotation, fx }) => [...translation, ...rotation, fx].join()).join();
    if (state === this.#shown) return;
    this.#shown = state;
    const lines = [];
    for (const camera of calibrated) {
      const rim = border(camera).map(([u, v]) => camera.unproject(u, v));
      const points = rim.map((ray) => ray && place(camera, ray, length));
      points.forEach((point, i) => {
        const next = points[(i + 1) % points.length];
        if (point && next) lines.push(...point, ...next);
        if (point && i % STEPS === 0) lines.push(...camera.centre, ...point);
      });
    }
    this.geometry.dispose();
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute("position", new Float32BufferAttribute(lines, 3));
  }
}
