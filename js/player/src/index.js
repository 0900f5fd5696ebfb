// @fvv/player: <fvv-player>, and the parts that it is made of for who builds a player of their own.

import { FvvPlayer } from "./element.js";

export { FvvPlayer };
export { Renderer, cameraColour } from "./renderer/index.js";
export { viewFromCamera, viewFromPose } from "./view.js";

if (globalThis.customElements && !customElements.get("fvv-player")) customElements.define("fvv-player", FvvPlayer);
