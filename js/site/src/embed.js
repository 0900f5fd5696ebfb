// The page that shows how to embed the player. Its listing is the text of the page that it links.

import "./player.js";
import "./theme.js";

const copy = document.getElementById("copy");
const response = await fetch("five-lines.html");
const lines = (await response.text()).trimEnd();
document.getElementById("lines").textContent = lines;
copy.addEventListener("click", async () => {
  await navigator.clipboard.writeText(lines);
  copy.textContent = "Copied";
  setTimeout(() => (copy.textContent = "Copy"), 2000);
});
