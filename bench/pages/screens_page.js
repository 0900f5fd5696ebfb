// Runs in a browser for screens.mjs: a player that fills the page, with the attributes that the address has.

import { createDecoder } from "@fvv/decoder";
import "@fvv/player";

const { lang, dir, ...attributes } = Object.fromEntries(new URLSearchParams(location.search));
if (lang) document.documentElement.lang = lang;
if (dir) document.documentElement.dir = dir;
const player = document.createElement("fvv-player");
for (const [name, value] of Object.entries({ controls: "", ...attributes })) player.setAttribute(name, value);
document.body.append(player);
window.player = player;

/**
 * Metres: the top of the highest head of the first mesh, and the middle of the mesh, to which people look. What is higher than
 * people, and what is around that, is no head.
 */
window.findHead = async (source) => {
  const decoder = await createDecoder({ source, worker: new URL("worker.js", import.meta.url), video: "encoded" });
  try {
    for await (const frame of decoder) {
      const { positions } = frame.mesh;
      const [tallest, around] = [2.2, 2];
      const highest = (counts) => {
        let top = null;
        for (let i = 1; i < positions.length; i += 3)
          if ((top === null || positions[i] > positions[top]) && counts(i)) top = i;
        return top;
      };
      const over = highest(() => true);
      const isApart = (i) =>
        Math.hypot(positions[i - 1] - positions[over - 1], positions[i + 1] - positions[over + 1]) > around;
      const top = positions[over] > tallest ? highest(isApart) : over;
      const middle = [0, 0, 0];
      positions.forEach((x, i) => (middle[i % 3] += (3 * x) / positions.length));
      frame.close();
      return { head: Array.from(positions.slice(top - 1, top + 2)), middle };
    }
    return null;
  } finally {
    decoder.close();
  }
};
