// Style sheets of the player: constructed, as content policies allow that forbid inline styles; made once for all players.

import { controls } from "./controls_style.js";
import { layout } from "./layout_style.js";
import { narrow } from "./narrow_style.js";
import { theme } from "./theme.js";

let sheets = null;

export function styleSheets() {
  sheets ??= [theme, layout, controls, narrow].map((text) => {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(text);
    return sheet;
  });
  return sheets;
}
