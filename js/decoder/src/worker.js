// The decoder's worker: serves an engine over its port.

import { Engine } from "./engine.js";
import { FvvError } from "./errors.js";
import { connect } from "./worker_rpc.js";

const READY = "ready";
const { call } = connect(self, {
  ready: async () => READY,
  open: (options) => engine.open(options),
  next: async () => {
    const item = await engine.next();
    return item.detail instanceof FvvError ? { ...item, detail: item.detail.toPlain() } : item;
  },
  soundsAhead: () => engine.soundsAhead(),
  seek: (place) => engine.seek(place),
  peek: () => engine.peek(),
  select: (wanted) => engine.select(wanted),
  setRung: (wanted) => engine.setRung(wanted),
  setShownScale: (shown) => engine.setShownScale(shown),
  lastingRung: async (wanted) => engine.lastingRung(wanted),
  status: () => engine.status(),
  bufferedTimes: () => engine.bufferedTimes(),
  close: () => engine.close(),
});

const engine = new Engine({
  pull: () => call("pull"),
  codec: (name) => call("codec", name),
  environment: () => call("environment"),
  fallback: () => call("fallback"),
  outage: (detail) => call("outage", detail).catch(() => {}),
  renew: (expired) => call("renew", expired),
});

self.postMessage({ id: 0, result: READY });
