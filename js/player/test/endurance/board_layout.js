// The positions of the squares of the numbered board, in metres on the plane z = 0, and how its number is read from a
// picture.

export const BITS = 12;
/** Frames a second. */
export const RATE = 25;
const PITCH = 0.115;
const HALF = 0.045;

/** The square of a bit: above for 1, below for 0. */
export function cellOf(bit, value) {
  return { x: (bit - (BITS - 1) / 2) * PITCH, y: value ? 0.4 : 0.15, half: HALF };
}

/** A square at another position in each group of frames, so that crops and layouts differ. */
export function groupMarkOf(group) {
  return { x: 0.5 * Math.sin(2.4 * group), y: -0.35 - 0.1 * Math.cos(1.7 * group), half: 0.04 };
}

/** The background colour in display values, which does not occur on the board. */
export const BACKGROUND = [0, 0, 255];
const isBackground = ([red, , blue]) => blue > 150 && red < 90;

/** The view: on the axis of the board, y upwards. */
export const POSE = { distance: 2, fov: 2 * Math.atan(0.3), width: 192, height: 144 };

function colourAt({ width, height, data }, { x, y }) {
  const focal = height / 2 / Math.tan(POSE.fov / 2) / POSE.distance;
  const column = Math.floor(width / 2 + focal * x);
  const row = Math.floor(height / 2 - focal * y);
  return data.slice(4 * (row * width + column), 4 * (row * width + column) + 3);
}

/** {mesh, picture}: the numbers of both; null if one cannot be read. */
export function readBoard(pixels) {
  let [mesh, picture] = [0, 0];
  for (let bit = 0; bit < BITS; bit++) {
    const colours = [0, 1].map((value) => colourAt(pixels, cellOf(bit, value)));
    const standing = colours.map((colour) => !isBackground(colour));
    if (standing[0] === standing[1]) mesh = null;
    if (mesh === null) return { mesh, picture: null };
    const value = standing[1] ? 1 : 0;
    mesh |= value << bit;
    const [level] = colours[value];
    if (level > 90 && level < 165) picture = null;
    if (picture !== null && level >= 165) picture |= 1 << bit;
  }
  return { mesh, picture };
}
