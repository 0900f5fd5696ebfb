// Calls over a MessagePort or a Worker in both directions: each side serves functions and calls those of the other.

import { FvvError } from "./errors.js";
import { PlanarPicture } from "./media/planar_picture.js";

/** Everything that can be transferred instead of copied; pictures can only be transferred. */
function transferables(value, found = new Set()) {
  if (ArrayBuffer.isView(value)) found.add(value.buffer);
  else if (typeof VideoFrame === "function" && value instanceof VideoFrame) found.add(value);
  else if (typeof ImageBitmap === "function" && value instanceof ImageBitmap) found.add(value);
  else if (Array.isArray(value)) value.forEach((item) => transferables(item, found));
  else if (value instanceof PlanarPicture || (value && Object.getPrototypeOf(value) === Object.prototype))
    Object.values(value).forEach((item) => transferables(item, found));
  return found;
}

/**
 * serve: {name: async (argument) => result}. Returns {call(name, argument), fail(error)}: fail rejects all calls that are open, and
 * those that follow.
 */
export function connect(port, serve) {
  const calls = new Map();
  let last = 0;
  let failure = null;
  const respond = async ({ id, name, argument }) => {
    try {
      const result = await serve[name](argument);
      port.postMessage({ id, result }, Array.from(transferables(result)));
    } catch (error) {
      port.postMessage({ id, error: FvvError.from(error).toPlain() });
    }
  };
  port.addEventListener("message", ({ data }) => {
    if (data.name !== undefined) return respond(data);
    const call = calls.get(data.id);
    calls.delete(data.id);
    if (data.error) call?.reject(FvvError.fromPlain(data.error));
    else call?.resolve(data.result);
  });
  const call = (name, argument) =>
    new Promise((resolve, reject) => {
      if (failure) return reject(failure);
      const id = ++last;
      calls.set(id, { resolve, reject });
      port.postMessage({ id, name, argument });
    });
  const fail = (error) => {
    failure ??= error;
    for (const { reject } of calls.values()) reject(error);
    calls.clear();
  };
  // The call that it belongs to is not known.
  port.addEventListener("messageerror", () => {
    fail(new FvvError({ code: "worker", message: "a message between page and worker could not be read" }));
  });
  return { call, fail };
}
