import { WebGPURenderer } from "three/webgpu";

import { FrameObject, Texturing } from "./object.js";

export { Pick, Texturing, lookThrough, pick, rayThrough } from "./object.js";

export interface Options extends Texturing {
  /** The renderer of the scene, with WebGPU or its WebGL 2 backend: pictures are uploaded and depth maps drawn when a frame is shown. */
  renderer: WebGPURenderer;
}

export class FvvObject3D extends FrameObject {
  constructor(options: Options);
}
