// The environment of a stream that has one.

import assert from "node:assert/strict";

import { createDecoder } from "../dist/index.js";

/** Plays to the end, from frame start on if that is one; the environment is told of once, whichever way it is reached. */
export async function onlyBackground(source, start) {
  const decoder = await createDecoder({ source });
  let told = 0;
  decoder.addEventListener("background", ({ detail }) => (told += detail.length));
  if (start) await decoder.seek({ frame: start });
  for await (const frame of decoder) frame.close();
  assert.equal(told, 1);
  decoder.close();
  return decoder.backgrounds[0];
}
