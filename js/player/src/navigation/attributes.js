// Cameras as attributes say them, in the manner of <model-viewer>: camera-orbit="30deg 75deg 4m",
// camera-target="0m 1m 0m", field-of-view="45deg"; auto stands for what the stream's own view has.

const ANGLES = { deg: Math.PI / 180, rad: 1 };
const LENGTHS = { m: 1, cm: 0.01, mm: 0.001, "": 1 };
const TERM = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)([a-z%]*)$/i;

function parse(text, units, auto) {
  if (text === "auto") return auto;
  const [, number, unit] = TERM.exec(text) ?? [];
  if (number === undefined) return NaN;
  if (unit === "%") return (Number(number) / 100) * auto;
  return unit in units ? Number(number) * units[unit] : NaN;
}

function parseAll(text, kinds, autos) {
  const terms = text.trim().split(/\s+/);
  if (terms.length !== kinds.length) return null;
  const numbers = terms.map((term, i) => parse(term, kinds[i], autos[i]));
  return numbers.every(Number.isFinite) ? numbers : null;
}

/** auto: {theta, phi, radius}. null: what is written is none. */
export function parseOrbit(text, auto) {
  const numbers = parseAll(text, [ANGLES, ANGLES, LENGTHS], [auto.theta, auto.phi, auto.radius]);
  return numbers && numbers[2] > 0 ? { theta: numbers[0], phi: numbers[1], radius: numbers[2] } : null;
}
export function parseTarget(text, auto) {
  return parseAll(text, [LENGTHS, LENGTHS, LENGTHS], auto);
}
export function parseFieldOfView(text, auto) {
  const numbers = parseAll(text, [ANGLES], [auto]);
  return numbers && numbers[0] > 0 && numbers[0] < Math.PI ? numbers[0] : null;
}

const degrees = (radians) => `${Number(((radians * 180) / Math.PI).toFixed(2))}deg`;
const metres = (x) => `${Number(x.toFixed(4))}m`;
export const formatOrbit = ({ theta, phi, radius }) => `${degrees(theta)} ${degrees(phi)} ${metres(radius)}`;
export const formatTarget = (target) => target.map(metres).join(" ");
export const formatFieldOfView = degrees;
