// The decoder's worker as in a browser without WebCodecs.
import "./without_webcodecs.mjs";
import "/dist/worker.js";
