// Documents of marks (spec/marks.schema.json): read, checked, and packed into links.

/** Numbers of places: of each kind that has any, the least and the most. */
const POINTS = { arrow: [2, 2], line: [2, 2], ellipse: [3, 3], freehand: [2, 1000], text: [1, 1], trail: [0, 0] };
const MOST_MARKS = 1000;
const MOST_TEXT = 200;
/** Bytes of the JSON of a link. */
const MOST_BYTES = 1 << 20;

const isVector = (value) => Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);
const isId = (value) => Number.isSafeInteger(value) && value >= 0;

function fail(where, expected, found) {
  const text = typeof found === "string" ? JSON.stringify(found.slice(0, 40)) : String(found);
  throw new TypeError(`marks: ${where}: expected ${expected}, found ${text}`);
}
function check(where, value, isRight, expected) {
  if (!isRight(value)) fail(where, expected, value);
}

function readMark(mark, where) {
  check(where, mark, (value) => value !== null && typeof value === "object" && !Array.isArray(value), "an object");
  const { kind, points, from, to, object, colour, width, text, seconds } = mark;
  check(`${where}.kind`, kind, (value) => Object.hasOwn(POINTS, value), `one of ${Object.keys(POINTS).join(", ")}`);
  const [least, most] = POINTS[kind];
  if (most > 0) {
    const isCount = (value) => Array.isArray(value) && value.length >= least && value.length <= most;
    check(`${where}.points`, points, isCount, least === most ? `${least} places` : `${least} to ${most} places`);
    points.forEach((point, i) => check(`${where}.points[${i}]`, point, isVector, "three numbers"));
  } else check(`${where}.points`, points, (value) => value === undefined, "nothing");
  for (const [name, value] of Object.entries({ from, to }))
    if (value !== undefined) check(`${where}.${name}`, value, Number.isSafeInteger, "an integer, in ticks");
  const isName = (value) => isId(value) || (typeof value === "string" && value !== "");
  if (object !== undefined || kind === "trail") check(`${where}.object`, object, isName, "a name or an identifier");
  if (colour !== undefined) check(`${where}.colour`, colour, (value) => /^#[0-9a-f]{6}$/.test(value), "#rrggbb");
  if (width !== undefined) check(`${where}.width`, width, (value) => value >= 1 && value <= 20, "1 to 20 pixels");
  const isText = (value) => typeof value === "string" && value !== "" && value.length <= MOST_TEXT;
  if (text !== undefined || kind === "text") check(`${where}.text`, text, isText, `1 to ${MOST_TEXT} characters`);
  if (seconds !== undefined) check(`${where}.seconds`, seconds, (value) => value > 0 && value <= 3600, "0 to 3600");
  const known = { kind, points, from, to, object, colour, width, text, seconds };
  return Object.freeze(Object.fromEntries(Object.entries(known).filter(([, value]) => value !== undefined)));
}

/** The marks of a document, checked: unknown members are left out. TypeError: it is not one. */
export function readMarks(value) {
  check("the document", value, (one) => one !== null && typeof one === "object", "an object");
  check("fvv_marks", value.fvv_marks, (one) => one === 1, "1");
  const isList = (one) => Array.isArray(one) && one.length <= MOST_MARKS;
  check("marks", value.marks, isList, `an array of at most ${MOST_MARKS}`);
  return value.marks.map((mark, i) => readMark(mark, `marks[${i}]`));
}
export const documentOf = (marks) => ({ fvv_marks: 1, marks });

async function through(bytes, stream, most = Infinity) {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const parts = [];
  let size = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    size += part.value.length;
    if (size > most) {
      await reader.cancel();
      throw new RangeError(`marks: the link has more than ${most} bytes`);
    }
    parts.push(part.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

/** Marks as text for the fragment of an address. */
export async function packMarks(marks) {
  const bytes = new TextEncoder().encode(JSON.stringify(documentOf(marks)));
  const packed = await through(bytes, new CompressionStream("deflate-raw"));
  const text = btoa(Array.from(packed, (byte) => String.fromCharCode(byte)).join(""));
  return text.replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}
export async function unpackMarks(text) {
  const packed = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (one) => one.charCodeAt(0));
  const bytes = await through(packed, new DecompressionStream("deflate-raw"), MOST_BYTES);
  return readMarks(JSON.parse(new TextDecoder().decode(bytes)));
}
