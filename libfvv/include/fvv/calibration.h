/* fvv/calibration.h: camera models, projection, CAMR records. Spec: spec/fvv.md clause 9.
 *
 * Conventions: world -> camera, x_c = R x_w + t; camera x right, y down, z forward; metres; image in pixels,
 * x right, y down, the centre of the top left pixel at (0.5, 0.5). (OpenCV puts it at (0, 0): add 0.5 to its
 * principal point. COLMAP agrees with fvv.) */
#ifndef FVV_CALIBRATION_H
#define FVV_CALIBRATION_H

#include "fvv/format.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* u = fx x' + skew y' + cx, v = fy y' + cy, with (x', y') = lens(x_c / z_c, y_c / z_c).
 * FVV_LENS_NONE: identity.
 * FVV_LENS_RADTAN: Brown-Conrady as in OpenCV, distortion = k1 k2 p1 p2 k3 k4 k5 k6 (rational).
 * FVV_LENS_FISHEYE: Kannala-Brandt as in OpenCV's fisheye, distortion = k1 k2 k3 k4 0 0 0 0. */
typedef struct fvv_camera {
  uint16_t id; /* unique within a stream */
  uint8_t lens;
  uint8_t flags;               /* FVV_CAMERA_... */
  uint32_t width, height;      /* pixels of the picture that the intrinsics speak of */
  double fx, fy, cx, cy, skew; /* pixels; fx, fy > 0 */
  double distortion[8];
  double r_max; /* undistorted radius |(x, y)|, for fisheye the angle in radians, up to which the lens is
                   invertible and used; > 0, may be +inf for FVV_LENS_NONE */
  double rotation[9]; /* R, row-major; |R R^T - I| <= 1e-4 per element and det > 0 */
  double translation[3];
  const char *name; /* UTF-8, not terminated; borrowed */
  size_t name_size;
} fvv_camera;

/* Checks every range above and that r_max is within the invertible part. Encode and decode call it. */
FVV_API FVV_MUST_USE fvv_status fvv_camera_validate(const fvv_camera *camera, fvv_diagnostic *diagnostic);

/* The largest radius of invertibility of the lens (first zero of the derivative of the radial function),
 * capped by what a picture corner needs times 1.25. Use it to fill r_max. */
FVV_API double fvv_camera_r_max(const fvv_camera *camera);

/* World metres -> pixels. Answers 1 when the point is in front (z_c > 0) and within r_max, else 0 and pixel
 * is NaN. depth (may be NULL) receives z_c. The pixel may lie outside the picture. */
FVV_API int fvv_camera_project(const fvv_camera *camera, const double world[3], double pixel[2],
                               double *depth);
/* Pixels -> ray through it in the camera frame, z = 1 (fisheye beyond 90 degrees is not supported: 0).
 * Answers 1, or 0 when the pixel lies beyond r_max. Inverts by bracketed Newton: error < 1e-9 px. */
FVV_API int fvv_camera_unproject(const fvv_camera *camera, const double pixel[2], double ray[3]);
/* Camera centre -R^T t in the world, metres. */
FVV_API void fvv_camera_centre(const fvv_camera *camera, double centre[3]);

/* CAMR payload (clause 9.2). Sizes as fvv_scene_encode. decode borrows name from payload. */
FVV_API FVV_MUST_USE fvv_status fvv_camera_encode(const fvv_camera *camera, uint8_t *out, size_t capacity,
                                                  size_t *written, fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_camera_decode(fvv_camera *camera, const uint8_t *payload, size_t size,
                                                  const fvv_limits *limits, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
