/* The lattice of a stream: integers <-> metres, one stated rule for each way (clause 8.2), and texture
 * indices
 * -> texture coordinates (clause 8.6). Knows no meshes, so that encoders, decoders and tests share the same
 * arithmetic. */
#include "mesh/lattice.h"

#include <math.h>

#include "base/diagnostic.h"
#include "fvv/mesh.h"

/* The product has a name of its own so that it is rounded: FMA would give other last bits. */
static double metres_of(double origin, double step, int32_t index) {
  const double product = step * (double)index;
  return origin + product;
}

void fvv_lattice_to_metres(const double origin[3], double step, const int32_t index[3], double metres[3]) {
  for (int k = 0; k < 3; k++) metres[k] = metres_of(origin[k], step, index[k]);
}

void fvv_lattice_to_floats(const double origin[3], double step, const int32_t *indices, size_t count,
                           float *metres) {
  for (size_t i = 0; i < count; i++)
    for (size_t k = 0; k < 3; k++) metres[3 * i + k] = (float)metres_of(origin[k], step, indices[3 * i + k]);
}

/* Both factors and the product are exact in single precision: an index has at most 17 bits. */
void fvv_texture_to_floats(uint8_t bits, const uint32_t *indices, size_t count, float *uv) {
  const float step = 1.0f / (float)(UINT32_C(1) << bits);
  for (size_t i = 0; i < 2 * count; i++) uv[i] = (float)indices[i] * step;
}

int fvv_lattice_quantise(double x, double origin, double step, int32_t *index) {
  const double v = (x - origin) / step;
  /* Written so that NaN, from inf / inf, fails. The half step on either side rounds to even: inward. */
  if (!(v >= -FVV_LATTICE_MAX - 0.5 && v <= FVV_LATTICE_MAX + 0.5)) return 0;
  int32_t nearest = (int32_t)v;
  const double rest = v - nearest; /* exact: |v| < 2^29 */
  if (rest > 0.5 || (rest == 0.5 && nearest % 2)) nearest++;
  if (rest < -0.5 || (rest == -0.5 && nearest % 2)) nearest--;
  *index = nearest;
  return 1;
}

const char *fvv_lattice_not_finite(double x) {
  return isnan(x) ? "NaN" : x < 0 ? "-infinity" : "infinity";
}

fvv_status fvv_lattice_point(const double origin[3], double step, const double *metres, size_t vertex,
                             int32_t point[3], fvv_diagnostic *diagnostic) {
  for (size_t k = 0; k < 3; k++) {
    const double x = metres[3 * vertex + k];
    if (!isfinite(x))
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, 0, 0, "vertex %zu: %c is %s, not a finite number",
                      vertex, "xyz"[k], fvv_lattice_not_finite(x));
    if (!fvv_lattice_quantise(x, origin[k], step, &point[k]))
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_LATTICE, 0, 0,
                      "vertex %zu: %c = %g m lies more than 2^28 steps of %g m from the origin %g m", vertex,
                      "xyz"[k], x, step, origin[k]);
  }
  return FVV_OK;
}

fvv_status fvv_lattice_from_metres(const double origin[3], double step, const double *metres, size_t count,
                                   int32_t *indices, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_status status = FVV_OK;
  for (size_t v = 0; status == FVV_OK && v < count; v++)
    status = fvv_lattice_point(origin, step, metres, v, indices + 3 * v, diagnostic);
  return status;
}
