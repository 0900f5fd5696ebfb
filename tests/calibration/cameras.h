// The cameras that the calibration tests share.
#ifndef FVV_TESTS_CAMERAS_H
#define FVV_TESTS_CAMERAS_H

#include "fvv/calibration.h"

#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

inline fvv_camera camera_with(int lens, std::initializer_list<double> coefficients) {
  fvv_camera c = {};
  c.id = 7;
  c.lens = (uint8_t)lens;
  c.width = 1920;
  c.height = 1080;
  c.fx = 1500;
  c.fy = 1497.5;
  c.cx = 962.25;
  c.cy = 537.75;
  int i = 0;
  for (const double k : coefficients) c.distortion[i++] = k;
  // A turn of 30 degrees about z after one of 40 degrees about x.
  const double a = 0.6981317007977318, b = 0.5235987755982988;
  const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b);
  const double r[9] = {cb, -sb * ca, sb * sa, sb, cb * ca, -cb * sa, 0, sa, ca};
  for (i = 0; i < 9; i++) c.rotation[i] = r[i];
  c.translation[0] = 0.3;
  c.translation[1] = -1.2;
  c.translation[2] = 4.5;
  c.r_max = fvv_camera_r_max(&c);
  return c;
}

struct named_camera {
  std::string name;
  fvv_camera camera;
};

// Every lens model, mild to extreme; r_max as the library fills it.
inline std::vector<named_camera> lenses() {
  std::vector<named_camera> all;
  const auto add = [&](const char *name, fvv_camera c, double focal, double skew) {
    c.fx *= focal;
    c.fy *= focal;
    c.skew = skew;
    c.r_max = fvv_camera_r_max(&c);
    all.push_back({name, c});
  };
  add("pinhole", camera_with(FVV_LENS_NONE, {}), 1, 0);
  add("pinhole with skew", camera_with(FVV_LENS_NONE, {}), 1, -1.468);
  add("mild barrel", camera_with(FVV_LENS_RADTAN, {-0.08, 0.01}), 1, 0);
  add("k1 = -0.4 on a wide picture", camera_with(FVV_LENS_RADTAN, {-0.4}), 0.6, -1.468);
  add("pincushion", camera_with(FVV_LENS_RADTAN, {0.3, 0.05}), 1, 0);
  add("five coefficients", camera_with(FVV_LENS_RADTAN, {-0.281, 0.0914, 0.0012, -0.0007, -0.013}), 1, 0.8);
  add("tangential near the fold", camera_with(FVV_LENS_RADTAN, {-0.4, 0, 0.02, -0.015}), 0.5, 0);
  add("strong rational", camera_with(FVV_LENS_RADTAN, {1.9, 0.8, 1e-4, -2e-4, 0.04, 2.3, 1.4, 0.2}), 0.5, 0);
  add("fisheye", camera_with(FVV_LENS_FISHEYE, {-0.012, 0.006, -0.004, 0.0007}), 0.5, 0);
  // 85 degrees to the side at the left and right edge.
  add("fisheye of 170 degrees", camera_with(FVV_LENS_FISHEYE, {0.02, -0.004}), 960 / 1.5 / 1500, 0);
  return all;
}

// R x + t = camera_point solved for x.
inline void to_world(const fvv_camera &c, const double camera_point[3], double world[3]) {
  double d[3];
  for (int i = 0; i < 3; i++) d[i] = camera_point[i] - c.translation[i];
  for (int i = 0; i < 3; i++)
    world[i] = c.rotation[i] * d[0] + c.rotation[3 + i] * d[1] + c.rotation[6 + i] * d[2];
}

// Clause 9.1 implemented again, in long double: camera frame -> pixel.
inline void reference_pixel(const fvv_camera &c, const double p[3], long double pixel[2]) {
  const long double x = (long double)p[0] / p[2], y = (long double)p[1] / p[2], r2 = x * x + y * y;
  const double *k = c.distortion;
  long double u = x, v = y;
  if (c.lens == FVV_LENS_RADTAN) {
    const long double k1 = k[0], k2 = k[1], p1 = k[2], p2 = k[3], k3 = k[4], k4 = k[5], k5 = k[6], k6 = k[7];
    const long double d =
        (1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2) / (1 + k4 * r2 + k5 * r2 * r2 + k6 * r2 * r2 * r2);
    u = x * d + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    v = y * d + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  } else if (c.lens == FVV_LENS_FISHEYE && r2 > 0) {
    const long double r = std::sqrt(r2), a = std::atan(r), a2 = a * a;
    const long double b = a * (1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
    u = x * b / r;
    v = y * b / r;
  }
  pixel[0] = c.fx * u + c.skew * v + c.cx;
  pixel[1] = c.fy * v + c.cy;
}

#endif
