// The front page: the player, a choice of clips, and the facts of the current clip.

import { COMMANDS, MOVES } from "@fvv/player/keys";

import { copyOnClick } from "./copy.js";
import { bytes, comparedWith, element, factsOf, factsOfFile, partsOf } from "./facts.js";
import { openFiles } from "./open_file.js";
import "./player.js";
import "./theme.js";

const $ = (id) => document.getElementById(id);
const player = $("player");

const showValues = (facts) =>
  $("facts").replaceChildren(
    ...facts.map(([value, unit, words]) =>
      element("div", {}, element("dt", {}, element("b", {}, value), ` ${unit}`), element("dd", {}, words)),
    ),
  );
/** Facts that only clips of the site have. */
const showKnown = (known) => {
  for (const section of document.querySelectorAll("[data-known]")) section.hidden = !known;
};

/** address: of the clip, as a page elsewhere on this host would name it. */
function showSource(address, note) {
  const script = new URL("fvv-player.min.js", document.baseURI);
  $("source").textContent =
    `<script type="module" src="${script}"></script>\n` +
    `<fvv-player src="${address.replaceAll("&", "&amp;").replaceAll('"', "&quot;")}" controls autoplay loop></fvv-player>`;
  $("source-note").textContent = note;
}
copyOnClick($("copy"), () => $("source").textContent);

function showFacts(clip) {
  showKnown(true);
  showSource(new URL(clip.file, document.baseURI).href, "On other hosts, take both files there.");
  $("about").replaceChildren(element("strong", {}, `${clip.kind}. `), clip.about);
  showValues(factsOf(clip));
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
  $("compared").replaceChildren(...comparedWith(clip));
}

/** Prepared marks, and the tools, one click away. marks: address of a document; null: none. */
function offerMarks(marks) {
  $("analyse").hidden = !marks;
  $("analyse").dataset.marks = marks ?? "";
  showMarks(false);
}
function showMarks(shown) {
  $("analyse").setAttribute("aria-pressed", String(shown));
  for (const name of ["tools", "marks"]) player.removeAttribute(name);
  if (!shown) return;
  player.marks = $("analyse").dataset.marks;
  player.tools = "measure mark follow";
}
$("analyse").addEventListener("click", () => showMarks($("analyse").ariaPressed !== "true"));

function play(clip) {
  showFacts(clip);
  offerMarks(clip.marks);
  // A single frame would be drawn again and again, at low resolution on slow machines.
  player.autoplay = clip.frames > 1;
  if (!player.autoplay) player.pause();
  player.srcObject = null;
  player.src = clip.file;
}

/** A file that the page has no facts about: source as srcObject takes it, or a URL. size: bytes, or null. */
function playFile(source, name, size, about, address, note) {
  showKnown(false);
  offerMarks(null);
  showSource(address, note);
  for (const input of document.querySelectorAll("#chooser input")) input.checked = false;
  $("about").replaceChildren(element("strong", {}, name), `. ${about}`);
  showValues([]);
  player.autoplay = true;
  const begin = () => {
    showValues(factsOfFile(player, size));
    // A single frame would be drawn again and again, at low resolution on slow machines.
    if (player.frameCount === 1) player.pause();
  };
  player.addEventListener("loadeddata", begin, { once: true });
  if (typeof source === "string") player.src = source;
  else player.srcObject = source;
}

function playLocal(file) {
  const about = "A file of this computer. It is played here: nothing is uploaded.";
  playFile(file, file.name, file.size, about, file.name, "Put the clip beside your page.");
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
openFiles({ button: $("open"), input: $("file"), veil: $("drop"), play: playLocal });
const response = await fetch("clips.json");
const clips = await response.json();
const parameters = new URLSearchParams(location.search);
const chosen = clips.find(({ name }) => name === parameters.get("clip")) ?? clips[0];
offer(clips, chosen);
// fvvserve --open FILE serves this file and no other, at this address.
const opened = parameters.get("open");
if (opened === null) play(chosen);
else {
  const about = "The file that fvvserve --open serves to this computer.";
  playFile("open/clip.fvv", opened, null, about, opened, "Put the clip beside your page.");
}
