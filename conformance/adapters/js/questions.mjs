// Answers to the questions of conformance/PROTOCOL.md on one frame by @fvv/decoder, in Node and in browsers.

function project(frame, { camera, points }) {
  const found = frame.camera(camera);
  const pixels = points.map((point) => found.project(...point)?.slice(0, 2) ?? null);
  return { pixels };
}

function unproject(frame, { camera, pixels }) {
  const found = frame.camera(camera);
  return { rays: pixels.map((pixel) => found.unproject(...pixel)) };
}

/** What the decoder has an answer to. */
export const ofDecoder = { project, unproject };

/** answers: functions of a frame and a request, by operation. createDecoder: of @fvv/decoder. options: for createDecoder. */
export async function answerTo(answers, createDecoder, source, request, options = {}) {
  const decoder = await createDecoder({ source, video: "encoded", sound: "encoded", rung: 0, ...options });
  try {
    for (let number = 0; ; number++) {
      const frame = await decoder.next();
      if (!frame) throw new RangeError(`frame ${request.frame}: the stream has ${number}`);
      if (number === request.frame) return answers[request.op](frame, request);
      frame.close();
    }
  } finally {
    decoder.close();
  }
}
