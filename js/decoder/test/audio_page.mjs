// In a page: the sound of clips as a decoder dispatches it.

import { createDecoder } from "/dist/index.js";

/** Decodes by another program: what this browser makes of a file of sound. */
export async function listenToFile(url, rate) {
  const context = new OfflineAudioContext(1, rate, rate);
  const sound = await context.decodeAudioData(await (await fetch(url)).arrayBuffer());
  return Array.from({ length: sound.numberOfChannels }, (_, i) => sound.getChannelData(i));
}

/**
 * Returns {frames, warnings, calls, tracks}: of each track the first sample, gaps between blocks, and all channels.
 * software: without AudioDecoder. calls: of soundFallback, which is left out if fallback is false.
 */
export async function listen({ clip = "/clip.fvv", seconds = 0, worker = true, software = false, fallback = true }) {
  const former = globalThis.AudioDecoder;
  if (software) globalThis.AudioDecoder = undefined;
  let calls = 0;
  const soundFallback = () => {
    calls++;
    return import("/opus.js");
  };
  const options = { sound: "decoded", worker: worker ? undefined : false, ...(fallback && { soundFallback }) };
  const decoder = await createDecoder({ source: clip, ...options });
  const warnings = [];
  const blocks = new Map();
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail.message));
  decoder.addEventListener("soundrestart", () => blocks.clear());
  decoder.addEventListener("sound", ({ detail }) => {
    if (!blocks.has(detail.track)) blocks.set(detail.track, []);
    blocks.get(detail.track).push(detail);
  });
  if (seconds) await decoder.seek({ seconds });
  let frames = 0;
  for await (const frame of decoder) {
    frames++;
    frame.close();
  }
  // Until no more sound arrives.
  for (let last = -1, count = 0; count !== last || !count;) {
    last = count;
    await new Promise((done) => setTimeout(done, 300));
    count = 1 + [...blocks.values()].reduce((sum, list) => sum + list.length, 0);
  }
  decoder.close();
  globalThis.AudioDecoder = former;
  const byTrack = [...blocks].sort(([a], [b]) => a - b);
  const tracks = byTrack.map(([track, list]) => {
    const { start, rate, position, channels: first } = list[0];
    const length = list.at(-1).start + list.at(-1).channels[0].length - start;
    const channels = first.map(() => new Float32Array(length));
    let [gaps, expected] = [0, start];
    for (const block of list) {
      if (block.start !== expected) gaps++;
      block.channels.forEach((samples, i) => channels[i].set(samples, block.start - start));
      expected = block.start + block.channels[0].length;
    }
    return { track, start, gaps, rate, position, channels };
  });
  return { frames, warnings, calls, tracks };
}

/** The same, with only the first channel, as values that can leave the page. */
export async function report(options) {
  const { tracks, ...rest } = await listen(options);
  return { ...rest, tracks: tracks.map(({ channels, ...about }) => ({ ...about, samples: Array.from(channels[0]) })) };
}

/** Level in dB of a over what b differs from it, where both are, but for the first samples. */
function likeness(a, b) {
  const from = Math.max(a.start, b.start) + 1000;
  const to = Math.min(a.start + a.channels[0].length, b.start + b.channels[0].length);
  return a.channels.map((samples, i) => {
    let [signal, noise] = [0, 1e-12];
    for (let k = from; k < to; k++) {
      const x = samples[k - a.start];
      signal += x ** 2;
      noise += (x - b.channels[i][k - b.start]) ** 2;
    }
    return 10 * Math.log10(signal / noise);
  });
}

/** Compares two ways to decode a clip: {calls, warnings, gaps, starts, ends, decibels} for both, and of each channel. */
export async function compare(one, other) {
  const found = [await listen(one), await listen(other)];
  const each = (of) => found.map(({ tracks }) => tracks.map(of));
  return {
    calls: found.map(({ calls }) => calls),
    warnings: found.flatMap(({ warnings }) => warnings),
    gaps: each(({ gaps }) => gaps),
    starts: each(({ start }) => start),
    ends: each(({ start, channels }) => start + channels[0].length),
    decibels: found[0].tracks.map((track, i) => likeness(track, found[1].tracks[i])),
  };
}
