/** A module script for `new Worker(url, { type: "module" })`: it exports nothing. createDecoder's option `worker` takes the
 * worker, its URL, or a function that starts it. */
export {};
