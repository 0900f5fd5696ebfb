export { DepthPlan, depthSizes } from "./depth_plan.js";
export { blending, sharesVertex } from "./glsl/blending.js";
export { copyFragment, planesFragment, replicatedFragment, replicationFragment } from "./glsl/pictures.js";
export { depthFragment, depthVertex, projection } from "./glsl/projection.js";
export { conversionOf, layoutOf, loadPicture, loadPictures } from "./pictures.js";
export { Replication, replicationOf } from "./pictures.js";
export { MOST_SHARE_TEXELS, SHARE_COLUMNS, packShares, shareTexels } from "./visibility_weights.js";
export { MOST_BEST, checkTexturing, texturingOf } from "./views.js";
export { MOST_VIEWS, VIEW_TEXELS, viewsOf, writeViews } from "./views.js";
