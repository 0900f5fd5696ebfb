// @fvv/three: free-viewpoint video as an object of a three.js scene. index.d.ts documents the types.

export { pick, rayThrough } from "@fvv/analysis";
export { FvvObject3D } from "./object.js";
export { lookThrough } from "./look_through.js";
