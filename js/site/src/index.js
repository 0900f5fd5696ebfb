// The front page: the player, a choice of clips, and the facts of the current clip.

import { COMMANDS, MOVES } from "@fvv/player/keys";

import { bytes, comparedWith, element, factsOf, partsOf } from "./facts.js";
import "./player.js";
import "./theme.js";

const $ = (id) => document.getElementById(id);
const player = $("player");
let began = null;

function showFacts(clip) {
  $("about").replaceChildren(element("strong", {}, `${clip.kind}. `), clip.about);
  $("facts").replaceChildren(
    ...factsOf(clip).map(([value, unit, words]) =>
      element("div", {}, element("dt", {}, element("b", {}, value), ` ${unit}`), element("dd", {}, words)),
    ),
  );
  const parts = partsOf(clip);
  $("bar").setAttribute("aria-label", parts.map(({ name, text }) => `${name} ${text}`).join(", "));
  $("bar").replaceChildren(
    ...parts.map(({ kind, share }) => {
      const piece = element("span", { "data-kind": kind });
      piece.style.flexGrow = String(share);
      return piece;
    }),
  );
  $("bytes").replaceChildren(
    ...parts.map(({ kind, name, bytes: size, text, words }) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, element("span", { class: "key", "data-kind": kind }), name),
        element("td", { class: "number" }, bytes(size)),
        element("td", { class: "number" }, text),
        element("td", {}, words),
      ),
    ),
  );
  $("compared").replaceChildren(...comparedWith(clip, null));
}

function play(clip) {
  showFacts(clip);
  began = performance.now();
  player.addEventListener(
    "loadeddata",
    () => $("compared").replaceChildren(...comparedWith(clip, (performance.now() - began) / 1000)),
    { once: true },
  );
  // A single frame would be drawn again and again, at low resolution on slow machines.
  player.autoplay = clip.frames > 1;
  if (!player.autoplay) player.pause();
  player.src = clip.file;
}

function offer(clips, chosen) {
  $("chooser").hidden = clips.length < 2;
  $("chooser").replaceChildren(
    ...clips.map((clip) => {
      const input = element("input", { type: "radio", name: "clip", value: clip.name });
      input.checked = clip === chosen;
      input.addEventListener("change", () => {
        history.replaceState(null, "", `?clip=${clip.name}`);
        play(clip);
      });
      return element("label", {}, input, element("span", {}, clip.title));
    }),
  );
}

$("keys").replaceChildren(
  ...[...MOVES, ...COMMANDS].map(({ shown, description }) =>
    element(
      "div",
      {},
      element("dt", {}, ...shown.map((key) => element("kbd", {}, key))),
      element("dd", {}, description),
    ),
  ),
);
const response = await fetch("clips.json");
const clips = await response.json();
const wanted = new URLSearchParams(location.search).get("clip");
const chosen = clips.find(({ name }) => name === wanted) ?? clips[0];
offer(clips, chosen);
play(chosen);
