/* The module of projection: points through a camera and back. It is small, and apart from the core because
 * the thread of the page needs it where the core is in a worker. */
#include <stdlib.h>
#include <string.h>

#include "flat.h"
#include "fvv/calibration.h"
#include "module.h"

FVVJS_EXPORT void *fvvjs_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT void fvvjs_free(void *pointer) {
  free(pointer);
}

static void from_flat(const flat_camera *flat, fvv_camera *camera) {
  memset(camera, 0, sizeof *camera);
  camera->fx = flat->fx;
  camera->fy = flat->fy;
  camera->cx = flat->cx;
  camera->cy = flat->cy;
  camera->skew = flat->skew;
  memcpy(camera->distortion, flat->distortion, sizeof flat->distortion);
  camera->r_max = flat->r_max;
  memcpy(camera->rotation, flat->rotation, sizeof flat->rotation);
  memcpy(camera->translation, flat->translation, sizeof flat->translation);
  camera->lens = (uint8_t)flat->lens;
  camera->width = flat->width;
  camera->height = flat->height;
}

/* points: count x 3 metres. out: count x 3, pixel and depth; NaN where the camera does not see. */
FVVJS_EXPORT void fvvjs_project(const flat_camera *flat, const double *points, uint32_t count, double *out) {
  fvv_camera camera;
  from_flat(flat, &camera);
  for (size_t i = 0; i < count; i++)
    (void)fvv_camera_project(&camera, points + 3 * i, out + 3 * i, out + 3 * i + 2);
}

/* pixels: count x 2. out: count x 3, rays in the camera's frame with z = 1; NaN beyond the lens. */
FVVJS_EXPORT void fvvjs_unproject(const flat_camera *flat, const double *pixels, uint32_t count,
                                  double *out) {
  fvv_camera camera;
  from_flat(flat, &camera);
  for (size_t i = 0; i < count; i++) (void)fvv_camera_unproject(&camera, pixels + 2 * i, out + 3 * i);
}
