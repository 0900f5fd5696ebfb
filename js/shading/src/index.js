export { DepthPlan, depthSizes } from "./depth_plan.js";
export { blending, visibilityWeightsVertex } from "./glsl/blending.js";
export { copyFragment, planesFragment, replicatedFragment, replicationFragment } from "./glsl/pictures.js";
export { depthFragment, depthVertex, projection } from "./glsl/projection.js";
export { conversionOf, layoutOf, loadPicture, loadPictures } from "./pictures.js";
export { Replication, replicationOf } from "./pictures.js";
export {
  MAX_WEIGHT_TEXELS,
  WEIGHT_COLUMNS,
  packVisibilityWeights,
  visibilityWeightTexels,
} from "./visibility_weights.js";
export { MAX_BEST, checkTexturing, texturingOf } from "./views.js";
export { MAX_VIEWS, VIEW_TEXELS, viewsOf, writeViews } from "./views.js";
