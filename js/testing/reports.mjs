// What a decoder reports of a stream, by kind.

/** "gap": frames are missing; "damage": something violates the format; "warning": anything else that playback survives. */
export const kindOf = ({ code, severity }) => (code === "gap" ? "gap" : severity === "error" ? "damage" : "warning");

/** Calls take(kind, detail) for events of a decoder. kinds: names of events, of which "warning" is told apart as kindOf does. */
export function onReports(decoder, kinds, take) {
  const reported = ["gap", "damage", "warning"];
  if (kinds.some((kind) => reported.includes(kind)))
    decoder.addEventListener("warning", ({ detail }) => {
      const kind = kindOf(detail);
      if (kinds.includes(kind)) take(kind, detail);
    });
  for (const type of kinds.filter((kind) => !reported.includes(kind)))
    decoder.addEventListener(type, ({ detail }) => take(type, detail));
}
