// Aborting: what waits for something settles as soon as its owner gives up.

/** Engines of 2022 and before have no reasons. */
export const reasonOf = (signal) => signal.reason ?? new DOMException("it was aborted", "AbortError");

/** Calls act when the signal is aborted, at once if it is already. Returns a function that ends this. */
export function onAbort(signal, act) {
  if (!signal) return () => {};
  if (signal.aborted) {
    act();
    return () => {};
  }
  signal.addEventListener("abort", act, { once: true });
  return () => signal.removeEventListener("abort", act);
}

/** As the promise, but rejects with the signal's reason when that is aborted first. */
export async function unlessAborted(promise, signal) {
  let leave;
  const aborted = new Promise((_, reject) => {
    leave = onAbort(signal, () => reject(reasonOf(signal)));
  });
  try {
    return await Promise.race([promise, aborted]);
  } finally {
    leave();
  }
}

/** Resolves after some milliseconds, or when the signal is aborted. */
export async function delay(milliseconds, signal) {
  let leave;
  await new Promise((resolve) => {
    const timer = setTimeout(resolve, milliseconds);
    leave = onAbort(signal, () => {
      clearTimeout(timer);
      resolve();
    });
  });
  leave();
}
