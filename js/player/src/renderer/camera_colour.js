// What the shader of the mode "weights" computes too.

/** The colour of a camera in the mode "weights", [r, g, b] of 0 to 1, for what is written beside the picture. */
export function cameraColour(id) {
  const hue = (id * 0.61803399) % 1;
  return [0, 2, 1].map((third) => {
    const wave = Math.abs(((hue + third / 3) % 1) * 6 - 3) - 1;
    return 0.15 + 0.8 * Math.min(1, Math.max(0, wave));
  });
}
