// Requests over connections that may have been closed meanwhile, and what to do about those that fail.

import { FvvError } from "../errors.js";

/**
 * fetch, once more if there is no response: a host may close a connection that was not used for some seconds at the moment
 * at which it is used again. Throws FvvError "io" if there is none again.
 */
export async function request(url, init) {
  try {
    return await fetch(url, init);
  } catch (error) {
    if (init.signal?.aborted) throw error;
  }
  try {
    return await fetch(url, init);
  } catch (error) {
    if (init.signal?.aborted) throw error;
    throw new FvvError({
      code: "io",
      message: `${url}: no response (${reasonOf(error)}). ${adviceOn(url)}`,
      cause: error,
    });
  }
}

/** Node has the reason in the cause, browsers have none for scripts. */
const reasonOf = ({ message, cause }) => cause?.code ?? cause?.message ?? message;

function adviceOn(url) {
  const page = globalThis.location;
  const { origin, protocol } = new URL(url);
  if (!page || origin === page.origin) return "Is the server running, and reachable from here?";
  if (page.protocol === "https:" && protocol === "http:") return "A page of https: cannot fetch from http:.";
  return (
    `Is the host reachable, and does it allow pages of ${page.origin} (CORS: Access-Control-Allow-Origin, and the request ` +
    "header Range in Access-Control-Allow-Headers)? The browser's console has details."
  );
}

const ADVICE = {
  401: "the host asks for credentials: pass { url, headers } or { url, credentials }",
  403: "the host refuses access: pass { url, headers } or { url, credentials }",
  404: "there is no such file: check the address, also its upper and lower case",
};

/** For a response that is not ok. */
export function failed(url, { status }) {
  const advice = ADVICE[status] ? `, ${ADVICE[status]}` : "";
  return new FvvError({ code: "io", message: `${url}: HTTP status ${status}${advice}` });
}

/** "the stream has no signature" as what the host sent in place of one. type: its Content-Type, or null. */
export function notAStream(url, type, error) {
  const kind = type?.split(";")[0].trim();
  const advice =
    kind === "text/html"
      ? "a page in place of the file, as dev servers send for files that they do not have: check the address"
      : "check that the address is that of an .fvv file, a manifest.json or a live stream";
  const message = `${url}: expected an fvv stream, found ${kind ? `Content-Type ${kind}` : "something else"}: ${advice}`;
  const explained = FvvError.fromPlain({ ...error.toPlain(), message: `${message} [FVV-1001]` });
  explained.cause = error;
  return explained;
}
