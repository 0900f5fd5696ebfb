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

/* Checks every range above, and that the radial function rises strictly up to r_max (to 1e-9 of r_max).
 * Answers FVV_ERROR_INVALID with the rule's number, and the offset that the field has in CAMR. Encode makes
 * the same checks and answers FVV_ERROR_INPUT, decode FVV_ERROR_INVALID. Cost is bounded: no coefficients
 * take long to check. */
FVV_API FVV_MUST_USE fvv_status fvv_camera_validate(const fvv_camera *camera, fvv_diagnostic *diagnostic);

/* The largest radius up to which the lens can be inverted, capped by what the farthest picture corner needs
 * times 1.25; for the fisheye an angle below pi/2. Use it to fill r_max: it reads all of camera but r_max,
 * name and pose.
 *
 * The radial function stops rising at the first zero of its derivative or the first pole; both are found by
 * bounding polynomials (Lane and Riesenfeld 1981), not by sampling. Tangential terms make the map fold a
 * little earlier, at least where f'(r) or f(r)/r falls to 6 r |(p1, p2)|; that is the radius answered for
 * them. A lens whose picture never reaches the corner is followed up to some 10^4 times the corner's
 * distance. 0: no radius will do, because the intrinsics are not finite or the coefficients overflow. */
FVV_API double fvv_camera_r_max(const fvv_camera *camera);

/* World metres -> pixels. Answers 1 when the point is in front (z_c > 0) and within r_max, else 0 and pixel
 * is NaN. depth (may be NULL) receives z_c in either case. The pixel may lie outside the picture. A point so
 * close to the plane z_c = 0 that its pixel is not finite answers 0, as do NaN and infinities. For a valid
 * camera. */
FVV_API int fvv_camera_project(const fvv_camera *camera, const double world[3], double pixel[2],
                               double *depth);
/* Pixels -> ray through it in the camera frame, z = 1 (fisheye beyond 90 degrees is not supported: 0).
 * Answers 1 when projecting the ray gives the pixel again within 1e-9 px (for pixels up to 10^5 from the
 * picture), or 0 and NaN when the pixel lies beyond r_max, or so near a pole of the lens that doubles cannot
 * say where. Newton's method in a bracket on the radius, then on both coordinates where the lens has
 * tangential terms, with a bounded number of steps. For a valid camera. */
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
