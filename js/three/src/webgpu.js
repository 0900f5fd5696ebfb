// @fvv/three/webgpu: the same for WebGPURenderer, with WebGPU or its WebGL 2 backend.

import { NodeDrawing } from "./nodes/drawing.js";
import { ClipObject } from "./clip.js";
import { FrameObject } from "./object.js";

export { pick, rayThrough } from "@fvv/analysis";
export { lookThrough } from "./look_through.js";

export class FvvObject3D extends FrameObject {
  constructor(options) {
    super(options, NodeDrawing);
  }
}

export class FvvClip extends ClipObject {
  constructor(options) {
    super(options, NodeDrawing);
  }
}
