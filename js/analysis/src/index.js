// @fvv/analysis: what is where in a frame of @fvv/decoder. index.d.ts documents the types.

export { weightsAt } from "./camera_weights.js";
export {
  angle,
  centreOf,
  csv,
  distance,
  floorOf,
  height,
  meshErrorOf,
  motion,
  pathOf,
  pointOf,
  pointUncertainty,
} from "./measure.js";
export { ObjectPaths, objectsOf, piecesOfFrame } from "./objects.js";
export { pick, rayThrough } from "./pick.js";
export { SurfacePoint } from "./surface_point.js";
export { SurfaceTree, treeOf } from "./surface_tree.js";
