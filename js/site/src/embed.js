// The page that shows how to embed the player. Its listing is the text of the page that it links.

import { copyOnClick } from "./copy.js";
import "./player.js";
import "./theme.js";

const response = await fetch("five-lines.html");
const lines = (await response.text()).trimEnd();
document.getElementById("lines").textContent = lines;
copyOnClick(document.getElementById("copy"), () => lines);
