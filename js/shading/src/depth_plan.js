// Where the depth map of each camera is in the layers of one texture, and how large the layers have to be. Maps are drawn
// without lens distortion, wide enough for everything that the camera's tile shows.

/** Samples along a pixel of the tile, if there is room for them. */
const SAMPLES = 3;
/** Limit of x / z and y / z: a lens that shows more than 76 degrees off its axis gets no map. */
const WIDEST = 4;
const BORDER_STEPS = 32;
/** Default limit of all maps together; a texel has four bytes. */
const MAX_TEXELS = 2 ** 24;
const MAX_SIDE = 4096;

/** Bounds of x / z and y / z inside the border of a rectangle of the picture, through the lens. */
function fieldOf(camera, { x, y, width, height }) {
  const { rMax, lens } = camera;
  const rim = lens === "fisheye" ? Math.tan(Math.min(rMax, 1.5)) : rMax;
  const field = { left: Infinity, right: -Infinity, top: Infinity, bottom: -Infinity };
  const add = (u, v) => {
    field.left = Math.min(field.left, u);
    field.right = Math.max(field.right, u);
    field.top = Math.min(field.top, v);
    field.bottom = Math.max(field.bottom, v);
  };
  const addPixel = (u, v) => {
    const ray = camera.unproject(u, v);
    if (ray) return add(ray[0], ray[1]);
    add(-rim, -rim);
    add(rim, rim);
  };
  for (let i = 0; i <= BORDER_STEPS; i++) {
    const [u, v] = [x + (width * i) / BORDER_STEPS, y + (height * i) / BORDER_STEPS];
    addPixel(u, y);
    addPixel(u, y + height);
    addPixel(x, v);
    addPixel(x + width, v);
  }
  return field;
}

/** Layouts of groups differ slightly: sizes never shrink. former: null, or {width, height, layers}. */
export function depthSizes(wanted, former) {
  const larger = (name) => Math.max(wanted[name], former?.[name] ?? 0);
  return { width: larger("width"), height: larger("height"), layers: larger("layers") };
}

export class DepthPlan {
  #maxTexels;
  #fields = new WeakMap(); // camera -> {key, field}; a camera that does not move is the same object in every frame

  constructor(maxTexels = MAX_TEXELS) {
    this.#maxTexels = maxTexels;
  }

  #field(camera, source) {
    const key = `${source.x} ${source.y} ${source.width} ${source.height}`;
    const known = this.#fields.get(camera);
    if (known?.key === key) return known.field;
    const field = fieldOf(camera, source);
    this.#fields.set(camera, { key, field });
    return field;
  }

  /**
   * Sets view.depth, the place in the maps, of every view for which needs(view) is true. Layer i belongs to view i.
   * Returns the minimum size of the maps, {width, height, layers}, or null if no view needs one.
   */
  place(views, needs) {
    const wanted = [];
    for (const view of views) {
      view.depth = null;
      if (!needs(view)) continue;
      const field = this.#field(view.camera, view.source);
      if (!(Math.max(-field.left, field.right, -field.top, field.bottom) <= WIDEST)) continue;
      const fx = (view.camera.fx * view.place.width) / view.source.width;
      const fy = (view.camera.fy * view.place.height) / view.source.height;
      const columns = (field.right - field.left) * fx;
      const rows = (field.bottom - field.top) * fy;
      wanted.push({ view, field, fx, fy, columns, rows });
    }
    if (!wanted.length) return null;
    const columns = Math.max(...wanted.map((one) => one.columns)) + 2;
    const rows = Math.max(...wanted.map((one) => one.rows)) + 2;
    const samples = Math.min(
      SAMPLES,
      Math.sqrt(this.#maxTexels / (views.length * columns * rows)),
      MAX_SIDE / Math.max(columns, rows),
    );
    // With less than one sample per pixel the tolerance has to cover a whole sample.
    const breadth = Math.max(1, 1 / samples);
    for (const { view, field, fx, fy, ...own } of wanted)
      view.depth = {
        scale: [fx * samples, fy * samples],
        offset: [(1 - field.left * fx) * samples, (1 - field.top * fy) * samples],
        size: [Math.ceil((own.columns + 2) * samples), Math.ceil((own.rows + 2) * samples)],
        breadth: [breadth / fx, breadth / fy],
      };
    return { width: Math.ceil(columns * samples), height: Math.ceil(rows * samples), layers: views.length };
  }
}
