// @fvv/analysis: what is where in a frame of @fvv/decoder. index.d.ts documents the types.

export { pick, rayThrough } from "./pick.js";
export { SurfaceTree } from "./surface_tree.js";
