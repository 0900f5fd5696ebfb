// Pictures are assigned to frames by their timestamps, even if a decoder of video returns them late, in another order, or
// not at all. Node has no VideoDecoder: the tests install a fake one.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";

import { createDecoder } from "../dist/index.js";
import { makeClips } from "./native.mjs";

const { clips, done } = makeClips("moving");
after(done);
const bytes = new Uint8Array(readFileSync(clips.moving));

let open = 0;
class Picture {
  constructor(timestamp) {
    this.timestamp = timestamp;
    open++;
  }
  close() {
    open--;
  }
}

/** decodeChunks(chunks, put): called whenever a chunk arrives, with all chunks that are pending. */
function installDecoder(decodeChunks) {
  globalThis.EncodedVideoChunk = class {
    constructor(fields) {
      Object.assign(this, fields);
    }
  };
  globalThis.VideoDecoder = class {
    static isConfigSupported = async () => ({ supported: true });
    constructor({ output, error }) {
      Object.assign(this, { output, error, state: "unconfigured", chunks: [] });
    }
    configure() {
      this.state = "configured";
    }
    put = (chunk) => queueMicrotask(() => this.output(new Picture(chunk.timestamp)));
    decode(chunk) {
      this.chunks.push(chunk);
      decodeChunks(this.chunks, this.put, this);
    }
    async flush() {
      decodeChunks(this.chunks, this.put, this, true);
      await new Promise((resolve) => setTimeout(resolve, 5));
    }
    close() {
      this.state = "closed";
    }
  };
}

async function play() {
  const decoder = await createDecoder({ source: bytes, video: "decoded" });
  const warnings = [];
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail));
  const frames = [];
  for await (const frame of decoder) {
    const picture = frame.picture();
    frames.push({ micros: Math.round(frame.seconds * 1e6), of: picture ? picture.timestamp : null });
    frame.close();
  }
  decoder.close();
  return { frames, warnings };
}

test("late and in another order", async () => {
  // Three at a time, the last one first.
  installDecoder((chunks, put, _, flushing) => {
    if (chunks.length >= 3 || flushing) chunks.splice(0).reverse().forEach(put);
  });
  const { frames, warnings } = await play();
  assert.equal(frames.length, 5);
  for (const { micros, of } of frames) assert.equal(of, micros);
  assert.deepEqual(warnings, []);
  assert.equal(open, 0);
});

test("a dropped picture is reported, and no other picture replaces it", async () => {
  let n = 0;
  installDecoder((chunks, put) => {
    // The second is never returned; the fourth is returned twice, with another one of no frame.
    for (const chunk of chunks.splice(0)) {
      n++;
      if (n === 2) continue;
      put(chunk);
      if (n === 4) put(chunk);
      if (n === 4) put({ timestamp: chunk.timestamp + 7 });
    }
  });
  const { frames, warnings } = await play();
  assert.equal(frames.length, 5);
  frames.forEach(({ micros, of }, i) => assert.equal(of, i === 1 ? null : micros, `frame ${i}`));
  assert.deepEqual(
    warnings.map(({ code }) => code),
    ["video"],
  );
  assert.match(warnings[0].message, /40000|dropped/);
  assert.equal(open, 0);
});

test("after an error decoding continues with the next key picture", async () => {
  let failed = false;
  installDecoder((chunks, put, decoder) => {
    const [chunk] = chunks.splice(0);
    if (failed || chunk.type === "key") return put(chunk);
    failed = true;
    queueMicrotask(() => {
      decoder.state = "closed";
      decoder.error(new Error("it broke"));
    });
  });
  const { frames, warnings } = await play();
  assert.deepEqual(
    frames.map(({ of, micros }) => (of === null ? null : of === micros)),
    [true, null, null, true, true],
  );
  assert.equal(warnings.length, 1);
  assert.equal(open, 0);
});

/** As WebCodecs does it: the decoder says yes, closes itself and reports an error for its first chunk. */
const failing = (chunks, put, decoder) => {
  chunks.length = 0;
  queueMicrotask(() => {
    if (decoder.state === "closed") return;
    decoder.state = "closed";
    decoder.error(new Error("Decoding error."));
  });
};

test("a decoder that fails at its first picture is reported as unsupported, once, also after a seek", async () => {
  installDecoder(failing);
  const decoder = await createDecoder({ source: bytes, video: "decoded" });
  const warnings = [];
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail));
  for (let round = 0; round < 2; round++) {
    let frames = 0;
    for await (const frame of decoder) {
      assert.equal(frame.picture(), null);
      frames++;
    }
    assert.equal(frames, 5);
    await decoder.seek({ frame: 0 });
  }
  decoder.close();
  assert.deepEqual(
    warnings.map(({ code }) => code),
    ["unsupported"],
  );
  assert.match(warnings[0].message, /fails at its first picture: Decoding error\./);
});

test("one that throws at its first picture, too", async () => {
  installDecoder(() => {
    throw new Error("it is closed");
  });
  const { frames, warnings } = await play();
  assert.deepEqual(
    frames.map(({ of }) => of),
    [null, null, null, null, null],
  );
  assert.deepEqual(
    warnings.map(({ code }) => code),
    ["unsupported"],
  );
});

test("a fallback that is given takes over", async () => {
  installDecoder(failing);
  let asked = 0;
  const videoFallback = async () => {
    asked++;
    throw new Error("not there");
  };
  const decoder = await createDecoder({ source: bytes, video: "decoded", videoFallback });
  const warnings = [];
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail));
  let frames = 0;
  for await (const frame of decoder) frames += frame.picture() === null;
  decoder.close();
  assert.equal(frames, 5);
  assert.ok(asked > 0);
  assert.deepEqual(
    warnings.map(({ code }) => code),
    ["video", "unsupported"],
  );
  assert.match(warnings[1].message, /not there/);
});

test("one that never returns a picture is given up after a time", async () => {
  installDecoder(() => {});
  const began = performance.now();
  const { frames, warnings } = await play();
  assert.equal(frames.length, 5);
  assert.ok(performance.now() - began < 9000, "each picture has a time of its own");
  assert.equal(warnings[0].code, "unsupported");
  assert.match(warnings[0].message, /no picture came for 5 s/);
});
