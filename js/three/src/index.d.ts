import { WebGLRenderer } from "three";

import { FrameObject, Texturing } from "./object.js";

export { Pick, Texturing, lookThrough, pick, rayThrough } from "./object.js";

export interface Options extends Texturing {
  /** The renderer of the scene, with WebGL 2: pictures are uploaded and depth maps drawn when a frame is shown. */
  renderer: WebGLRenderer;
}

export class FvvObject3D extends FrameObject {
  constructor(options: Options);
}
