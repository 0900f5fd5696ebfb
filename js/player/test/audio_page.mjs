// What a page's player sends to the audio device, and when it shows frames: for clips of fvvsynth --sound, in which a clap is a
// flash in the picture and a click in the sound.

import { writeFileSync } from "node:fs";
import { join } from "node:path";

/** Reports where clicks begin, in samples of the context, and the loudest sample of each tenth of a second. */
const WORKLET = `
registerProcessor("recorder", class extends AudioWorkletProcessor {
  quiet = 0;
  loudest = 0;
  process([[samples]]) {
    for (let i = 0; samples && i < samples.length; i++) {
      const x = Math.abs(samples[i]);
      this.loudest = Math.max(this.loudest, x);
      // A click begins with its peak.
      if (x > 0.3 && this.quiet > sampleRate / 10) this.port.postMessage({ click: (currentFrame + i) / sampleRate });
      this.quiet = x > 0.3 ? 0 : this.quiet + 1;
    }
    if (currentFrame % 4800 < 128) {
      this.port.postMessage({ loudest: this.loudest });
      this.loudest = 0;
    }
    return true;
  }
});`;

function record() {
  const { player } = window;
  const heard = (window.heard = { clicks: [], loudest: 0 });
  const shown = (window.shown = []);
  const positionAt = (time) => player.currentTime + ((time - performance.now()) / 1000) * player.playbackRate;
  // The next animation frame draws it, and the one after that begins when it is on the screen.
  player.addEventListener("framechange", () => {
    const { currentFrame } = player;
    requestAnimationFrame(() => requestAnimationFrame((now) => shown.push([currentFrame, now, positionAt(now)])));
  });
  const { connect } = AudioNode.prototype;
  const begun = new Set();
  const listen = async (node, { context }) => {
    await context.audioWorklet.addModule("recorder.js");
    const recorder = new AudioWorkletNode(context, "recorder");
    // A single measurement may be a buffer of the device off.
    const clocks = [];
    recorder.port.onmessage = ({ data: { click, loudest } }) => {
      const { contextTime, performanceTime } = context.getOutputTimestamp();
      clocks.push(performanceTime - contextTime * 1000);
      if (clocks.length > 30) clocks.shift();
      const time = [...clocks].sort((a, b) => a - b)[clocks.length >> 1] + click * 1000;
      if (click) heard.clicks.push([time, positionAt(time)]);
      if (loudest) heard.loudest = Math.max(heard.loudest, loudest);
    };
    connect.call(node, recorder);
    connect.call(recorder, context.destination);
  };
  AudioNode.prototype.connect = function (target, ...more) {
    if (target instanceof AudioDestinationNode && !begun.has(this.context)) {
      begun.add(this.context);
      listen(this, target);
    }
    return connect.call(this, target, ...more);
  };
}

/**
 * Begins to record, before anything is played: window.heard is {clicks, loudest}, window.shown [[frame, milliseconds,
 * position]], clicks [[milliseconds, position]], with the position that playback had then, in seconds.
 */
export async function beginRecording({ page, served }) {
  writeFileSync(join(served.folder, "recorder.js"), WORKLET);
  await page.evaluate(record);
}

/** Milliseconds by which each click's flash was later; null where that frame was not shown. */
export function offsetsOf(clicks, shown, frames) {
  const flashes = shown.filter(([frame]) => frames.includes(frame)).map(([, now]) => now);
  return clicks.map(([time]) => {
    const near = flashes.reduce((a, b) => (Math.abs(b - time) < Math.abs(a - time) ? b : a), Infinity);
    return Math.abs(near - time) < 300 ? near - time : null;
  });
}
