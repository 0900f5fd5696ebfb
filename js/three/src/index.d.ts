import { WebGLRenderer } from "three";

import { ClipObject, ClipSettings } from "./clip.js";
import { FrameObject, Texturing } from "./object.js";

export { ClipSettings, FvvClipEventMap } from "./clip.js";
export { Pick, Texturing, lookThrough, pick, rayThrough } from "./object.js";

export interface Options extends Texturing {
  /** The renderer of the scene, with WebGL 2: pictures are uploaded and depth maps drawn when a frame is shown. */
  renderer: WebGLRenderer;
}

export class FvvObject3D extends FrameObject {
  constructor(options: Options);
}

export class FvvClip extends ClipObject {
  constructor(options: ClipSettings & { renderer: WebGLRenderer });
}
