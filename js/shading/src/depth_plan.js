// Where the depth map of each camera stands in the layers of one texture, and how large these have to be. Maps are drawn
// without the lens, wide enough for all that its tile shows.

/** Samples along a pixel of the tile, where there is room for them. */
const SAMPLES = 3;
/** x / z and y / z: a lens that shows more than 76 degrees off its axis has no such map. */
const WIDEST = 4;
const BORDER_STEPS = 32;
/** Of all maps together, four bytes each, unless somebody says otherwise. */
const MOST_TEXELS = 2 ** 24;
const LARGEST_SIDE = 4096;

/** Bounds of x / z and y / z that the border of a rectangle of the picture encloses, as the lens shows it. */
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
  const look = (u, v) => {
    const ray = camera.unproject(u, v);
    if (ray) return add(ray[0], ray[1]);
    add(-rim, -rim);
    add(rim, rim);
  };
  for (let i = 0; i <= BORDER_STEPS; i++) {
    const [u, v] = [x + (width * i) / BORDER_STEPS, y + (height * i) / BORDER_STEPS];
    look(u, y);
    look(u, y + height);
    look(x, v);
    look(x + width, v);
  }
  return field;
}

/** Layouts of groups differ a little: room that was made is kept. had: null, or {width, height, layers}. */
export function depthSizes(wanted, had) {
  const larger = (name) => Math.max(wanted[name], had?.[name] ?? 0);
  return { width: larger("width"), height: larger("height"), layers: larger("layers") };
}

export class DepthPlan {
  #mostTexels;
  #fields = new WeakMap(); // camera -> {key, field}; cameras that stand still are the same object in every frame

  constructor(mostTexels = MOST_TEXELS) {
    this.#mostTexels = mostTexels;
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
   * Gives every view that needs(view) one its place in the maps, view.depth. A layer belongs to the view of the same
   * number. Answers the least size of them, {width, height, layers}, or null when there are none.
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
      Math.sqrt(this.#mostTexels / (views.length * columns * rows)),
      LARGEST_SIDE / Math.max(columns, rows),
    );
    // A sample may be farther away than the tolerance allows for when there is less than one to a pixel.
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
