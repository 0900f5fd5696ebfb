// Sources in runs. A run is a file header, a configuration block and then any group with what follows it (clause 6.4).
// Between pieces of bytes such a source yields objects:
//   {header}          a run begins; these are the 24 bytes of its file header, the rest comes as bytes
//   {damage: error}   what is damaged, in front of what is lost by it
//   {lost: {error, from}}   something is missing up to the next group; from: ticks, or nothing
//   {restart: true}   another stream begins
// inRuns says so. With groups (as readGroup makes them) it can be sought in: stream(group) begins with that one.

import { FvvError } from "./errors.js";

export const FILE_HEADER_SIZE = 24;
const SIGNATURE = [0x89, 0x46, 0x56, 0x56];

/** Whether a file header begins here, and so a run. */
export function beginsRun(bytes) {
  return bytes.length >= FILE_HEADER_SIZE && SIGNATURE.every((byte, i) => bytes[i] === byte);
}

export function loss(message, code = "io") {
  return new FvvError({ code, message, severity: "warning", fatal: false });
}

export async function wait(milliseconds, signal) {
  await new Promise((resolve) => {
    const timer = setTimeout(resolve, milliseconds);
    signal?.addEventListener("abort", () => (clearTimeout(timer), resolve()), { once: true });
  });
}
