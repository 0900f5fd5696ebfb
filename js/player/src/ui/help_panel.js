// Which key does what, out of the table that the keys work by.

import { COMMANDS, MOVES } from "../navigation/keys.js";
import { element } from "./dom.js";

export function helpPanel() {
  const rows = [...MOVES, ...COMMANDS].flatMap(({ shown, says }) => [
    element("dt", {}, ...shown.map((key) => element("kbd", {}, key))),
    element("dd", {}, says),
  ]);
  const hints = element(
    "p",
    {},
    "Drag to turn, with the right button or two fingers to move, scroll or pinch to come nearer. A click plays and pauses.",
  );
  return element("div", {}, hints, element("dl", { class: "keys" }, ...rows));
}
