// Opens a source by its description: memory, files, streams and URLs.

import { joined } from "../joined.js";
import { askForRange, FRONT, HostSource, noRange } from "./host.js";
import { LiveSource } from "./live.js";
import { BlobSource, BufferSource, PulledSource } from "./local.js";
import { failed, Network } from "./network.js";
import { ResponseSource } from "./response.js";
import { SegmentSource } from "./segments.js";

/** Enough for the index of a hundred groups. The first picture has to wait for these bytes. */
const SUFFIX = 1 << 13;

const rangeOf = ({ headers }) => /^bytes (\d+)-(\d+)\/(\d+)$/.exec(headers.get("content-range") ?? "");

/** What is wrong with a reply that should have the last bytes; null: nothing. */
function problemOf({ headers }, range, suffix) {
  if (!range) return "the response has no readable Content-Range (cross-origin hosts have to expose it)";
  const encoding = headers.get("content-encoding");
  if (encoding && encoding !== "identity") return `the response has Content-Encoding ${encoding}`;
  const [first, last, size] = range.slice(1).map(Number);
  if (last + 1 === size && last - first + 1 === suffix.length) return null;
  return `Content-Range ${range[0]} does not match the ${suffix.length} bytes received`;
}

/** Statuses of hosts that do not know ranges of the last bytes; 416: or of an empty file. */
const NO_SUFFIX = [400, 405, 416, 501];

/** The last bytes by their numbers, as the reply to the first bytes has the size; else the refusal. */
async function suffixByNumbers(network, url, head, refusal) {
  const range = head.status === 206 ? rangeOf(head) : null;
  if (!range) return refusal;
  refusal.drop();
  const size = Number(range[3]);
  return askForRange(network, url, `bytes=${Math.max(0, size - SUFFIX)}-${size - 1}`);
}

/** The bytes after a reply to a request for the last ones that has fewer, as hosts may send: up to the end. */
async function restOfSuffix(network, url, [last, size], outage) {
  const pieces = [];
  for (let at = last + 1; at < size;) {
    try {
      const reply = await askForRange(network, url, `bytes=${at}-${size - 1}`, { outage });
      const range = reply.status === 206 ? rangeOf(reply) : null;
      if (!range || Number(range[1]) !== at || Number(range[3]) !== size) {
        reply.drop();
        break;
      }
      const bytes = await reply.bytes();
      if (!bytes.length) break; // the size is wrong, or the host does not keep to its word
      pieces.push(bytes);
      at += bytes.length;
      outage.progress();
    } catch (error) {
      await outage.wait(error);
    }
  }
  return joined(pieces);
}

/** seekable false: a single request, and nothing is kept. */
async function openUrl({ url, init, seekable = true }, { warn, cache, ...access }) {
  const network = new Network(init, access);
  const head = { abort: new AbortController() };
  const whole = async () => {
    head.abort.abort();
    const reply = await network.request(url);
    if (!reply.ok) throw failed(url, reply);
    network.opened();
    return new ResponseSource(url, reply, network, { cache, rewinds: seekable });
  };
  if (!seekable) return whole();
  const suffixAsked = askForRange(network, url, `bytes=-${SUFFIX}`);
  head.reply = askForRange(network, url, `bytes=0-${FRONT - 1}`, { signal: head.abort.signal });
  head.reply.catch(() => {}); // if nothing is read of it
  let reply = await suffixAsked;
  if (NO_SUFFIX.includes(reply.status)) reply = await suffixByNumbers(network, url, await head.reply, reply);
  if (reply.status === 416 || reply.status === 200) head.abort.abort();
  if (reply.status === 416) return whole();
  if (!reply.ok) throw failed(url, reply);
  const cannot = (why) => warn(noRange(url, why));
  if (reply.status !== 206) {
    network.opened();
    cannot(`the server responds ${reply.status} to a request for a range`);
    return new ResponseSource(url, reply, network, { cache, rewinds: true });
  }
  let range = rangeOf(reply);
  // Hosts such as Vite's dev server take the last bytes for the first ones, and now the size is known.
  const begin = range ? Number(range[3]) - SUFFIX : 0;
  if (range && begin > 0 && Number(range[1]) === 0) {
    reply.drop();
    reply = await askForRange(network, url, `bytes=${begin}-${range[3] - 1}`);
    if (!reply.ok) throw failed(url, reply);
    range = reply.status === 206 ? rangeOf(reply) : null;
  }
  const outage = network.outage(url);
  let suffix = null;
  while (!suffix)
    try {
      suffix = await reply.bytes();
    } catch (error) {
      await outage.wait(error);
      reply = await askForRange(network, url, range ? `bytes=${range[1]}-${range[2]}` : `bytes=-${SUFFIX}`, { outage });
      if (!reply.ok) throw failed(url, reply);
    }
  outage.progress();
  if (range && reply.status === 206 && suffix.length === Number(range[2]) - Number(range[1]) + 1) {
    const rest = await restOfSuffix(network, url, range.slice(2).map(Number), outage);
    suffix = joined([suffix, rest]);
    range[2] = String(Number(range[2]) + rest.length);
  }
  const why = problemOf(reply, range, suffix);
  if (why) {
    cannot(why);
    return whole();
  }
  network.opened();
  return new HostSource(url, { network, size: Number(range[3]), headers: reply.headers, suffix, head, warn, cache });
}

/**
 * description can be sent to a worker: {bytes}, {blob}, {url, init, seekable}, {segments: {url, init}},
 * {live: {url, ...}}, or {pull: true} with a function pull. warn(error). cache: for bytes of URLs, until the source is closed.
 * rung: as for the decoder. access: {signal, policy, report, renew} as of Network; signal closes the source, also while it is opened.
 */
export async function openSource(description, { pull, warn, cache, rung, ...access }) {
  const { signal } = access;
  if (description.bytes) return new BufferSource(description.bytes);
  if (description.blob) return new BlobSource(description.blob);
  if (description.live) return LiveSource.open(description.live, { warn, rung, ...access });
  if (description.segments) return SegmentSource.open(description.segments, { cache, ...access });
  if (description.url) return openUrl(description, { warn, cache, ...access });
  return new PulledSource(pull, signal);
}
