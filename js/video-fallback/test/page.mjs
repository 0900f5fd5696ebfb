// Runs in a browser: decodes clips with the fallback and posts the hashes of their pictures. In a worker, in the window, and
// in a worker without WebCodecs.

import { createDecoder } from "/dist/index.js";

const videoFallback = () => import("/fallback/index.js");
const hex = (buffer) => Array.from(new Uint8Array(buffer), (byte) => byte.toString(16).padStart(2, "0")).join("");

/** The planes without padding between rows. */
async function bytesOf(image) {
  const { width, height } = image.visibleRect;
  const bytes = image.format === "I420P10" ? 2 : 1;
  const [columns, rows] = [Math.ceil(width / 2), Math.ceil(height / 2)];
  const planes = [
    { offset: 0, stride: width * bytes },
    { offset: width * height * bytes, stride: columns * bytes },
    { offset: (width * height + columns * rows) * bytes, stride: columns * bytes },
  ];
  const out = new Uint8Array(planes[2].offset + columns * rows * bytes);
  await image.copyTo(out, { layout: planes });
  return out;
}

async function decode(name, how, options) {
  const decoder = await createDecoder({ source: `/range/${name}`, videoFallback, ...options });
  const warnings = [];
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail.message));
  const pictures = [];
  for await (const frame of decoder) {
    for (const { track, picture } of frame.pictures) {
      const { format, timestamp } = picture;
      const late = timestamp - Math.round(frame.seconds * 1e6);
      const isFrame = typeof VideoFrame === "function" && picture instanceof VideoFrame;
      // A browser's own decoder may return RGB.
      const hash = /^I420/.test(format) ? hex(await crypto.subtle.digest("SHA-256", await bytesOf(picture))) : null;
      pictures.push({ track, hash, format, late, isFrame });
    }
    frame.close();
  }
  const { inWorker } = decoder;
  decoder.close();
  return { name, how, inWorker, pictures, warnings };
}

const violations = [];
addEventListener("securitypolicyviolation", (event) =>
  violations.push(`${event.violatedDirective} ${event.blockedURI}`),
);
const post = (found) => fetch("/result", { method: "POST", body: JSON.stringify({ ...found, violations }) });
try {
  const names = new URLSearchParams(location.search).get("clips").split(",");
  const native = Object.fromEntries(
    await Promise.all(
      ["hvc1.1.6.L30.90", "vp09.00.10.08"].map(async (codec) => {
        const known = typeof VideoDecoder === "function" ? await VideoDecoder.isConfigSupported({ codec }) : {};
        return [codec.slice(0, 4), Boolean(known.supported)];
      }),
    ),
  );
  const results = [];
  for (const name of names) {
    results.push(await decode(name, "worker", {}));
    results.push(await decode(name, "window", { worker: false }));
    results.push(await decode(name, "bare worker", { worker: new URL("bare_worker.mjs", import.meta.url) }));
  }
  await post({ results, native });
} catch (error) {
  await post({ error: `${error.message}\n${error.stack}` });
}
