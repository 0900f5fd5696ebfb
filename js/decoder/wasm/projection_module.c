/* The module of projection: points through a camera and back. It is small, and apart from the core because
 * the thread of the page needs it where the core is in a worker. */
#include <stdlib.h>

#include "fvv/calibration.h"
#include "module.h"

FVVJS_EXPORT void *fvvjs_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT void fvvjs_free(void *pointer) {
  free(pointer);
}

/* points: count x 3 metres. out: count x 3, pixel and depth; NaN where the camera does not see. */
FVVJS_EXPORT void fvvjs_project(const fvv_camera *camera, const double *points, uint32_t count, double *out) {
  for (size_t i = 0; i < count; i++)
    (void)fvv_camera_project(camera, points + 3 * i, out + 3 * i, out + 3 * i + 2);
}

/* pixels: count x 2. out: count x 3, rays in the camera's frame with z = 1; NaN beyond the lens. */
FVVJS_EXPORT void fvvjs_unproject(const fvv_camera *camera, const double *pixels, uint32_t count,
                                  double *out) {
  for (size_t i = 0; i < count; i++) (void)fvv_camera_unproject(camera, pixels + 2 * i, out + 3 * i);
}
