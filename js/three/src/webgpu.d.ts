import { WebGLRenderer } from "three";
import { WebGPURenderer } from "three/webgpu";

import { ClipObject, ClipSettings } from "./clip.js";
import { FrameObject, Texturing } from "./object.js";

export { ClipSettings, FvvClipEventMap } from "./clip.js";
export { Pick, Texturing, lookThrough, pick, rayThrough } from "./object.js";

export interface Options extends Texturing {
  /**
   * The renderer of the scene: pictures are uploaded and depth maps drawn when a frame is shown. WebGPURenderer with WebGPU or its
   * WebGL 2 backend; or WebGLRenderer after renderer.setNodesHandler(new WebGLNodesHandler()) of three's addons.
   */
  renderer: WebGPURenderer | WebGLRenderer;
}

export class FvvObject3D extends FrameObject {
  constructor(options: Options);
}

export class FvvClip extends ClipObject {
  constructor(options: ClipSettings & Pick<Options, "renderer">);
}
