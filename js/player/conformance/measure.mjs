// How far two pictures of a mesh are from each other, and where that counts.

/** The steepest surface that is no edge: its depth changes by so many pixels' breadths from one pixel to the next. */
const STEEPEST = 8;
/** Pixels. An outline runs through a pixel; here and in its neighbours, pictures of two rasterisers differ by chance. */
const AWAY = 2;
const LARGE = 8;

/**
 * Which pixels show the mesh, and which of them are at least two pixels from its outline and from places where its depth
 * jumps. depth: of the reference, infinite where there is no mesh.
 */
export function areasOf(depth, width, height, focal) {
  const surface = new Uint8Array(depth.length);
  const edge = new Uint8Array(depth.length);
  for (let i = 0; i < depth.length; i++) surface[i] = Number.isFinite(depth[i]) ? 1 : 0;
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const i = y * width + x;
      if (!surface[i]) continue;
      const jumps = (k) => !surface[k] || Math.abs(depth[k] - depth[i]) > (STEEPEST * depth[i]) / focal;
      if (
        (x > 0 && jumps(i - 1)) ||
        (x < width - 1 && jumps(i + 1)) ||
        (y > 0 && jumps(i - width)) ||
        (y < height - 1 && jumps(i + width))
      )
        edge[i] = 1;
    }
  const inner = surface.slice();
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      if (!edge[y * width + x]) continue;
      for (let v = Math.max(0, y - AWAY + 1); v < Math.min(height, y + AWAY); v++)
        for (let u = Math.max(0, x - AWAY + 1); u < Math.min(width, x + AWAY); u++) inner[v * width + u] = 0;
    }
  return { surface, inner };
}

/** PSNR of display values in dB, share of pixels of which a component is off by more than 8 of 255, and their number. */
export function distance(drawn, wanted, area) {
  let [sum, pixels, large] = [0, 0, 0];
  for (let i = 0; i < area.length; i++) {
    if (!area[i]) continue;
    pixels++;
    let most = 0;
    for (let k = 0; k < 3; k++) {
      const off = drawn[4 * i + k] - wanted[4 * i + k];
      sum += off * off;
      most = Math.max(most, Math.abs(off));
    }
    if (most > LARGE) large++;
  }
  const psnr = pixels ? 10 * Math.log10((255 * 255 * 3 * pixels) / Math.max(sum, 1e-9)) : null;
  return { psnr, large: pixels ? large / pixels : null, pixels };
}

/** Of visibility: how many pixels of the area are alike. drawn: of the mode "visibility", no green where unseen. */
export function agreement(drawn, wanted, area) {
  let [alike, pixels] = [0, 0];
  for (let i = 0; i < area.length; i++) {
    if (!area[i]) continue;
    pixels++;
    alike += drawn[4 * i + 1] > 0 === wanted[i] > 0.5;
  }
  return { alike, pixels };
}
