// Drawing for the scene's sake, before it is drawn: leaves the renderer as it was.

import { Color } from "three";

/** draw(): sets targets and renders; each is cleared to zeros before. */
export function offScreen(renderer, draw) {
  const target = renderer.getRenderTarget();
  const layer = renderer.getActiveCubeFace();
  const level = renderer.getActiveMipmapLevel();
  const colour = renderer.getClearColor(new Color());
  const alpha = renderer.getClearAlpha();
  const { autoClear } = renderer;
  const { enabled } = renderer.xr;
  renderer.xr.enabled = false;
  renderer.autoClear = true;
  renderer.setClearColor(0, 0);
  try {
    draw();
  } finally {
    renderer.setClearColor(colour, alpha);
    renderer.autoClear = autoClear;
    renderer.xr.enabled = enabled;
    renderer.setRenderTarget(target, layer, level);
  }
}
