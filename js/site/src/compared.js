// Bars that hold a clip against what WHP 235 tells of its own.

import { element } from "./dom.js";
import { bytes, seconds } from "./words.js";

/** Of the paper's clip: two seconds, and the time to its first mesh. */
const THEN = { seconds: 2, bytes: 27.3e6, first: 1.41 };

function row(name, value, share, now) {
  const fill = element("div", { class: now ? "fill now" : "fill" });
  fill.style.width = `${Math.max(100 * share, 0.4)}%`;
  return element(
    "div",
    { class: "row" },
    element("span", { class: "who" }, name),
    element("div", { class: "track" }, fill),
    element("span", { class: "value" }, value),
  );
}

function group(title, then, now, text) {
  const most = Math.max(then, now ?? 0);
  return element(
    "div",
    { class: "pair" },
    element("h3", {}, title),
    row("WHP 235", text(then), then / most, false),
    row("This clip", now === null ? "…" : text(now), (now ?? 0) / most, true),
  );
}

/** first: seconds until something was on screen; null: not yet. */
export function comparedWith(clip, first) {
  const pairs = [];
  if (clip.frames > 1)
    pairs.push(group("Two seconds take", THEN.bytes, (clip.bytes / clip.seconds) * THEN.seconds, bytes));
  pairs.push(group("Until something is seen", THEN.first, first, seconds));
  return pairs;
}
