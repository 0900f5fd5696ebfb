// @fvv/shading: what WebGL 2 players of fvv have in common. index.d.ts documents the types.

export { APART, BORDER, borderFactor, FADE, partsAt, visibilityFactor } from "./camera_rule.js";
export { DepthPlan, depthSizes } from "./depth_plan.js";
export { copyFragment, planesFragment, replicatedFragment, replicationFragment } from "./glsl/pictures.js";
export { blending, depthFragment, depthVertex, projection, visibilityWeightsVertex } from "./glsl/surface.js";
export {
  Replication,
  closePictures,
  conversionOf,
  keepPictures,
  layoutOf,
  loadKept,
  loadPicture,
  loadPictures,
  replicationOf,
} from "./pictures.js";
export { add, cross, dot, length, mix, normalise, scale, subtract, unit } from "./vectors.js";
export {
  LEVELS,
  MAX_BEST,
  MAX_VIEWS,
  SHARP,
  VIEW_TEXELS,
  checkTexturing,
  definesOf,
  nearPlaneOf,
  originOf,
  pointsOf,
  texturingOf,
  usesLevels,
  viewFrom,
  viewsOf,
  writeViews,
} from "./views.js";
export {
  MAX_WEIGHT_TEXELS,
  WEIGHT_COLUMNS,
  packVisibilityWeights,
  visibilityWeightTexels,
} from "./visibility_weights.js";
