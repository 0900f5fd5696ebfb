// @fvv/three: free-viewpoint video as an object of a three.js scene, for WebGLRenderer. index.d.ts documents the types.

import { GlDrawing } from "./gl/drawing.js";
import { ClipObject } from "./clip.js";
import { FrameObject } from "./object.js";

export { pick, rayThrough } from "@fvv/analysis";
export { lookThrough } from "./look_through.js";

export class FvvObject3D extends FrameObject {
  constructor(options) {
    super(options, GlDrawing);
  }
}

export class FvvClip extends ClipObject {
  constructor(options) {
    super(options, GlDrawing);
  }
}
