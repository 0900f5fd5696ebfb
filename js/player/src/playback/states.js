// Numbers that HTML gives to states and errors of media elements.

export const NETWORK = { EMPTY: 0, IDLE: 1, LOADING: 2, NO_SOURCE: 3 };
export const READY = { NOTHING: 0, METADATA: 1, CURRENT_DATA: 2, FUTURE_DATA: 3, ENOUGH_DATA: 4 };
const ERROR = { NETWORK: 2, DECODE: 3, SOURCE_NOT_SUPPORTED: 4 };
const NETWORK_CODES = ["io", "changed", "reconnect", "truncated"];

/** What a media element is before it has a source. */
export const NOTHING_YET = {
  readyState: READY.NOTHING,
  networkState: NETWORK.EMPTY,
  error: null,
  duration: NaN,
  frame: null,
  seeking: false,
  atEnd: false,
};

/** As MediaError. cause: FvvError, or what else was thrown. playable: something of the source was. */
export function mediaError(cause, playable) {
  const code = !playable
    ? ERROR.SOURCE_NOT_SUPPORTED
    : NETWORK_CODES.includes(cause.code)
      ? ERROR.NETWORK
      : ERROR.DECODE;
  return Object.freeze({ code, message: cause.message, cause });
}
