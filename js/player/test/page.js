// One player, and a record of its events.

import "@fvv/player";

const types =
  "loadstart durationchange loadedmetadata loadeddata canplay canplaythrough play playing pause seeking seeked waiting " +
  "ended ratechange error emptied abort camera-change";
const player = document.querySelector("fvv-player");
window.player = player;
window.events = [];
for (const type of types.split(" ")) player.addEventListener(type, () => window.events.push(type));
window.warnings = [];
player.addEventListener("warning", ({ detail }) => window.warnings.push(detail.message));
