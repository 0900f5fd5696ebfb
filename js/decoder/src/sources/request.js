// Requests over connections that may have been closed meanwhile.

/**
 * fetch, once more if there is no response: a host may close a connection that was not used for some seconds at the moment
 * at which it is used again.
 */
export async function request(url, init) {
  try {
    return await fetch(url, init);
  } catch (error) {
    if (init.signal?.aborted) throw error;
    return fetch(url, init);
  }
}
