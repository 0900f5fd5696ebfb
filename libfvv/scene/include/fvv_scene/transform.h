// Affine transforms and quaternions in double, with only the four operations and the square root, so that
// every machine computes the same bits.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace fvv::scene::gltf {

// Three rows of four: x' = m[0] x + m[1] y + m[2] z + m[3], and so on.
struct Transform {
  std::array<double, 12> m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  void apply(const double (&point)[3], double (&out)[3]) const {
    for (size_t row = 0; row < 3; row++)
      out[row] =
          m[row * 4] * point[0] + m[row * 4 + 1] * point[1] + m[row * 4 + 2] * point[2] + m[row * 4 + 3];
  }
  // The inverse transpose, which keeps normals upright (glTF 2.0 clause 3.7.2.1), times the determinant's
  // magnitude: cofactors, which a flat transform has as well.
  void apply_normal(const double (&normal)[3], double (&out)[3]) const {
    const double side = determinant() < 0 ? -1 : 1;
    for (size_t row = 0; row < 3; row++) {
      const size_t a = (row + 1) % 3 * 4, b = (row + 2) % 3 * 4;
      out[row] = side * ((m[a + 1] * m[b + 2] - m[a + 2] * m[b + 1]) * normal[0] +
                         (m[a + 2] * m[b] - m[a] * m[b + 2]) * normal[1] +
                         (m[a] * m[b + 1] - m[a + 1] * m[b]) * normal[2]);
    }
  }
  double determinant() const {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
  }
};

// First b, then a.
inline Transform operator*(const Transform &a, const Transform &b) {
  Transform out;
  for (size_t row = 0; row < 3; row++)
    for (size_t column = 0; column < 4; column++) {
      double sum = column == 3 ? a.m[row * 4 + 3] : 0;
      for (size_t k = 0; k < 3; k++) sum += a.m[row * 4 + k] * b.m[k * 4 + column];
      out.m[row * 4 + column] = sum;
    }
  return out;
}

// x, y, z, w scaled to length 1. False when there is no direction.
inline bool normalise(double *quaternion) {
  double sum = 0;
  for (size_t k = 0; k < 4; k++) sum += quaternion[k] * quaternion[k];
  const double length = std::sqrt(sum);
  if (!(length > 1e-12) || !std::isfinite(length)) return false;
  for (size_t k = 0; k < 4; k++) quaternion[k] /= length;
  return true;
}

// Scale, then rotation (a unit quaternion x, y, z, w), then translation.
inline Transform compose(const double *translation, const double *rotation, const double *scale) {
  const double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
  const double turn[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
  Transform out;
  for (size_t row = 0; row < 3; row++) {
    for (size_t column = 0; column < 3; column++)
      out.m[row * 4 + column] = turn[row * 3 + column] * scale[column];
    out.m[row * 4 + 3] = translation[row];
  }
  return out;
}

} // namespace fvv::scene::gltf
