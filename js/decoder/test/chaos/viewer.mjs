// A viewer of a film or of a live stream: shows frames at their time, compares each with that of the undamaged file, and measures
// how long it takes until playback goes on after a fault.

import { createDecoder } from "../../dist/index.js";
import { frameHashes } from "../native.mjs";
import { HANG_MS } from "../../../testing/chaos/figures.mjs";

const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

/** Throws "hang" when the promise has not settled HANG_MS after the last fault. */
async function orHang(promise, { clock, host }) {
  let isOver = false;
  const watch = (async () => {
    let free = clock.now;
    while (!isOver) {
      await clock.wait(1000);
      if (host.fault) free = clock.now;
      if (!isOver && clock.now - free > HANG_MS) throw new Error("hang");
    }
  })();
  watch.catch(() => {});
  try {
    return await Promise.race([promise, watch]);
  } finally {
    isOver = true;
  }
}

/** Plays one source for some milliseconds, with seeks. expected(frame): the hashes that it may have. world: {clock, host, random, figures}. */
export async function watchFilm(source, { duration, frameCount, expected, secondsPerFrame, world }) {
  const { clock, host, random, figures } = world;
  const ends = clock.now + duration;
  figures.sessions++;
  const renewAddress = async ({ url }) => host.renew(url);
  const opening = createDecoder({
    source: host.renew(source),
    renewAddress,
    limits: { cacheBytes: 0 },
    video: "encoded",
  });
  const decoder = await orHang(opening, world).catch((error) => error);
  if (decoder instanceof Error) {
    if (decoder.message === "hang") figures.hangs++;
    else if (host.fault || clock.now - (host.ended ?? -Infinity) < 10000) figures.refused++;
    else figures.errors.push(`opening ${source}: ${decoder.message}`);
    return;
  }
  let wasReplaced = false;
  decoder.addEventListener("warning", ({ detail }) => {
    if (detail.code === "changed") wasReplaced = true;
    else if (!["no-range", "io"].includes(detail.code))
      figures.errors.push(`${source}: ${detail.code}: ${detail.message}`);
  });
  let next = 0;
  let due = clock.now;
  try {
    while (clock.now < ends) {
      const asked = clock.now;
      const frame = await orHang(decoder.next(), world);
      const fault = host.last;
      if (frame) {
        const waited = clock.now - Math.max(asked, due);
        if (fault && !host.fault && host.ended > asked && waited > 100)
          figures.recovered(fault, clock.now - Math.max(host.ended, fault.allowed ?? 0));
        figures.frames++;
        // A file that was replaced goes on with the time of the last frame.
        if (frame.number !== next && !(wasReplaced && frame.number === next - 1)) figures.lost++;
        wasReplaced = false;
        const found = frameHashes(frame);
        if (!expected(frame).some((good) => same(good, found))) figures.wrong++;
        frame.close();
        next = frame.number + 1;
        due = Math.max(due, clock.now - 1000) + 1000 * secondsPerFrame;
        if (due > clock.now) await clock.wait(due - clock.now);
      }
      if (frame && random.random() > 0.03 && next < frameCount) continue;
      if (!decoder.seekable) break; // the end of a response that cannot be read again
      if (frame && next < frameCount) next = Math.floor(random.between(0, frameCount));
      else next = 0;
      await decoder.seek({ frame: next });
      due = clock.now;
    }
  } catch (error) {
    if (error.message === "hang") figures.hangs++;
    else figures.errors.push(`${source}: ${error.message}`);
  } finally {
    decoder.close();
  }
}

/** Plays a live stream for some milliseconds. */
export async function watchLive(source, { duration, expected, world }) {
  const { clock, host, figures } = world;
  const ends = clock.now + duration;
  figures.sessions++;
  const decoder = await orHang(createDecoder({ source, video: "encoded" }), world).catch((error) => error);
  if (decoder instanceof Error) {
    if (decoder.message === "hang") figures.hangs++;
    else figures.errors.push(`opening: ${decoder.message}`);
    return;
  }
  try {
    while (clock.now < ends) {
      const asked = clock.now;
      const frame = await orHang(decoder.next(), world);
      if (!frame) {
        figures.errors.push("a live stream that goes on has ended");
        break;
      }
      if (host.last && !host.fault && host.ended > asked && clock.now - asked > 500)
        figures.recovered(host.last, clock.now - host.ended);
      figures.frames++;
      const found = frameHashes(frame);
      if (!expected(frame).some((good) => same(good, found))) figures.wrong++;
      frame.close();
    }
  } catch (error) {
    if (error.message === "hang") figures.hangs++;
    else figures.errors.push(`live: ${error.message}`);
  } finally {
    decoder.close();
  }
}
