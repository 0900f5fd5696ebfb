// Vectors and matrices of three doubles.
#pragma once

#include <cmath>

namespace fvv::render {

struct Vec3 {
  double x = 0, y = 0, z = 0;
};

inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator-(Vec3 a) {
  return {-a.x, -a.y, -a.z};
}
inline Vec3 operator*(Vec3 a, double s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vec3 operator*(double s, Vec3 a) {
  return a * s;
}
inline Vec3 &operator+=(Vec3 &a, Vec3 b) {
  return a = a + b;
}
inline double dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vec3 a) {
  return std::sqrt(dot(a, a));
}
// Component by component: filtering light by a colour.
inline Vec3 product(Vec3 a, Vec3 b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline Vec3 mix(Vec3 a, Vec3 b, double t) {
  return a + (b - a) * t;
}
// axis: 0, 1 or 2.
inline double axis_of(Vec3 v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
// The zero vector stays zero.
inline Vec3 normalised(Vec3 a) {
  const double size = length(a);
  return size > 0 ? a * (1 / size) : a;
}

// Three columns: where the matrix takes the axes x, y and z.
struct Mat3 {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
};

inline Vec3 operator*(const Mat3 &m, Vec3 v) {
  return m.x * v.x + m.y * v.y + m.z * v.z;
}
inline Mat3 operator*(const Mat3 &a, const Mat3 &b) {
  return {a * b.x, a * b.y, a * b.z};
}
inline Mat3 transposed(const Mat3 &m) {
  return {{m.x.x, m.y.x, m.z.x}, {m.x.y, m.y.y, m.z.y}, {m.x.z, m.y.z, m.z.z}};
}

} // namespace fvv::render
