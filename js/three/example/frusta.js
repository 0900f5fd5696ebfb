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

/** From the camera's centre along a ray, to a depth: metres. */
function along({ rotation: r }, ray, depth) {
  return [0, 1, 2].map((i) => depth * (r[i] * ray[0] + r[3 + i] * ray[1] + r[6 + i] * ray[2]));
}

export class CameraFrusta extends LineSegments {
  #shown = "";

  constructor(colour) {
    super(new BufferGeometry(), new LineBasicMaterial({ color: colour, toneMapped: false }));
    this.visible = false;
  }

  /** length: of a frustum, in metres. origin: what vertices count from. Lines are made again only if cameras move. */
  show(cameras, length, origin) {
    this.position.fromArray(origin);
    const calibrated = cameras.filter((camera) => camera.calibrated);
    const state = calibrated.map(({ translation, rotation, fx }) => [...translation, ...rotation, fx].join()).join();
    if (state === this.#shown) return;
    this.#shown = state;
    const lines = [];
    for (const camera of calibrated) {
      const rim = border(camera).map(([u, v]) => camera.unproject(u, v));
      const centre = camera.centre.map((x, k) => x - origin[k]);
      const points = rim.map((ray) => ray && along(camera, ray, length).map((x, k) => centre[k] + x));
      points.forEach((point, i) => {
        const next = points[(i + 1) % points.length];
        if (point && next) lines.push(...point, ...next);
        if (point && i % STEPS === 0) lines.push(...centre, ...point);
      });
    }
    this.geometry.dispose();
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute("position", new Float32BufferAttribute(lines, 3));
  }
}
