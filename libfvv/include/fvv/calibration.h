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
  uint32_t width, height;      /* pixels of the picture to which the intrinsics belong */
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
 * Returns FVV_ERROR_INVALID with the rule's number, and the offset that the field has in CAMR. Encode makes
 * the same checks and returns FVV_ERROR_INPUT, decode FVV_ERROR_INVALID. Cost is bounded: no coefficients
 * take long to check. */
FVV_API FVV_MUST_USE fvv_status fvv_camera_validate(const fvv_camera *camera, fvv_diagnostic *diagnostic);

/* The largest radius up to which the lens can be inverted, capped by what the farthest picture corner needs
 * times 1.25; for the fisheye an angle below pi/2. Use it to fill r_max: it reads all of camera but r_max,
 * name and pose.
 *
 * The radial function stops rising at the first zero of its derivative or the first pole; both are found by
 * bounding polynomials (Lane and Riesenfeld 1981), not by sampling. Tangential terms make the map fold a
 * little earlier, at least where f'(r) or f(r)/r falls to 6 r |(p1, p2)|; that is the radius returned for
 * them. A lens whose picture never reaches the corner is followed up to some 10^4 times the corner's
 * distance. 0: no radius will do, because the intrinsics are not finite or the coefficients overflow. */
FVV_API double fvv_camera_r_max(const fvv_camera *camera);

/* World metres -> pixels. Returns 1 when the point is in front (z_c > 0) and within r_max, else 0 and pixel
 * is NaN. depth (may be NULL) receives z_c in either case. The pixel may lie outside the picture. A point so
 * close to the plane z_c = 0 that its pixel is not finite returns 0, as do NaN and infinities. For a valid
 * camera. */
FVV_API int fvv_camera_project(const fvv_camera *camera, const double world[3], double pixel[2],
                               double *depth);
/* Pixels -> ray through it in the camera frame, z = 1 (fisheye beyond 90 degrees is not supported: 0).
 * Returns 1 when projecting the ray gives the pixel again within 1e-9 px (for pixels up to 10^5 from the
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

/* ---- cameras that move ------------------------------------------------------------------------------ */

/* Steps of the values of a camera (clause 9.4): 2^-rotation (8 to 25) of each component of a unit quaternion,
 * 2^-position metres of the centre, 2^-pixel pixels of the intrinsics, 2^-lens of coefficients and r_max (0
 * to 40 each). */
typedef struct fvv_calibration_bits {
  uint8_t rotation, position, pixel, lens;
} fvv_calibration_bits;

/* The coarsest steps with which rotation, intrinsics and lens together move no point of the pictures of these
 * cameras by more than max_pixels, and each coordinate of a centre is off by position_step / 2 metres at
 * most. Finer ones than the format has are not returned: that is where focal lengths of 10^5 pixels and more
 * end. A rational lens whose denominator comes below 1/2 within the picture may be off by more. For valid
 * cameras: all of a stream, in all of its frames, or some whose steps are then used for others too. */
FVV_API void fvv_calibration_choose(const fvv_camera *cameras, size_t count, double position_step,
                                    double max_pixels, fvv_calibration_bits *bits);

/* Where the cameras of a configuration that move are, chunk by chunk of their track. */
typedef struct fvv_calibration fvv_calibration;

/* Copies the cameras with FVV_CAMERA_MOVES (their names are borrowed); ignores the others. Fails only if out
 * of memory. */
FVV_API FVV_MUST_USE fvv_status fvv_calibration_create(const fvv_camera *cameras, size_t count,
                                                       const fvv_allocator *allocator,
                                                       fvv_calibration **calibration);
FVV_API void fvv_calibration_destroy(fvv_calibration *calibration);
/* As after create: a new group begins, or something was lost. */
FVV_API void fvv_calibration_reset(fvv_calibration *calibration);
/* One CALB payload, of any origin; key: the flag of its chunk. A chunk that is no key follows the one that
 * was decoded last. After an error no camera is calibrated until the next key. Offsets of diagnostics are
 * those in the payload. */
FVV_API FVV_MUST_USE fvv_status fvv_calibration_decode(fvv_calibration *calibration, const uint8_t *payload,
                                                       size_t size, int key, fvv_diagnostic *diagnostic);
/* The camera as the chunk decoded or encoded last has it. FVV_END: it is not calibrated there;
 * FVV_ERROR_ARGUMENT: the camera does not move. */
FVV_API FVV_MUST_USE fvv_status fvv_calibration_camera(const fvv_calibration *calibration, uint16_t id,
                                                       fvv_camera *camera);
/* The next payload. cameras: those that are calibrated, by rising identifier, each with the lens model and
 * the picture size that it was created with. Rotations become the nearest
 * exact ones. payload is zero-initialised or from a call before; the caller frees it. FVV_ERROR_INPUT: a
 * camera is not valid or does not fit into the steps. Without key: after a key, with its bits, 65535 times
 * at most. The state changes only on FVV_OK. */
FVV_API FVV_MUST_USE fvv_status fvv_calibration_encode(fvv_calibration *calibration,
                                                       const fvv_calibration_bits *bits,
                                                       const fvv_camera *cameras, size_t count, int key,
                                                       fvv_bytes *payload, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
