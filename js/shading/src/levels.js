// Levels of the texture of pictures: averages of squares of texels, for viewers so far away that a pixel covers many.

/** Level 0 is the pictures as they are. Texels of higher levels than these would mix tiles of different cameras. */
export const LEVELS = 4;

/** The number of texels per pixel, along a side, from which on a level above 0 is used. */
export const SHARP = Math.SQRT2;

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

/**
 * Whether shaders need a level above 0 anywhere on the surface. views: of viewsOf; atlas: its place, [x, y, width, height], if
 * there are no views; sphere: {centre, radius} around the mesh; eye: the viewer's position; pixelAngle: the width of a
 * pixel of the viewer's picture at a distance of 1.
 */
export function usesLevels({ views, atlas }, { centre, radius }, eye, pixelAngle) {
  const away = distance(eye, centre);
  // The texels of an atlas cover the surface from all sides.
  if (atlas) return Math.sqrt(atlas[2] * atlas[3]) * away * pixelAngle > 2 * radius * SHARP;
  const pixel = (away + radius) * pixelAngle;
  return views.some(({ camera, source, place, off }) => {
    const nearest = Math.max(0, distance(camera.centre, centre) - radius);
    return !off && pixel * place.width * camera.fx > SHARP * nearest * source.width;
  });
}
