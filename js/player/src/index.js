// @fvv/player: the element <fvv-player>, and its parts for other players.

import { FvvPlayer } from "./element.js";

export { FvvPlayer };
export { Renderer, cameraColour } from "./renderer/index.js";
export { viewFromCamera, viewFromPose } from "./view.js";

if (globalThis.customElements && !customElements.get("fvv-player")) customElements.define("fvv-player", FvvPlayer);
