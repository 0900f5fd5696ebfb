// Coordinates that count from a place near the scene: float holds those of maps (UTM, earth-centred) to
// decimetres only.
#pragma once

#include "fvv/calibration.h"
#include "fvv_render/vector.h"

#include <cmath>
#include <vector>

namespace fvv::render {

// The lattice's origin in whole multiples of 2^20 steps: float holds indices beside them to a fraction of a
// step, and ordinary scenes, whose lattices begin near 0, stay where they are.
inline Vec3 local_origin(const double lattice_origin[3], double lattice_step) {
  const double unit = lattice_step * (1 << 20);
  const auto nearest = [&](double x) {
    const double multiple = std::round(x / unit) * unit;
    return std::isfinite(multiple) ? multiple : 0;
  };
  return {nearest(lattice_origin[0]), nearest(lattice_origin[1]), nearest(lattice_origin[2])};
}

// Three of each vertex.
inline std::vector<float> positions_from(Vec3 origin, const std::vector<double> &positions) {
  std::vector<float> out;
  out.reserve(positions.size());
  for (size_t i = 0; i < positions.size(); i++)
    out.push_back(float(positions[i] - axis_of(origin, int(i % 3))));
  return out;
}

// The same camera in coordinates that count from origin.
inline fvv_camera camera_from(Vec3 origin, fvv_camera camera) {
  for (size_t row = 0; row < 3; row++) {
    const double *axis = &camera.rotation[3 * row];
    camera.translation[row] += axis[0] * origin.x + axis[1] * origin.y + axis[2] * origin.z;
  }
  return camera;
}

} // namespace fvv::render
