#include "fvv_render/scene_lengths.h"

namespace fvv::render {

namespace {

constexpr double most_near = 0.01, most_lift = 1e-4;                     // metres
constexpr double sides_of_near = 1.0 / 100, sides_of_lift = 1.0 / 10000; // of the longest side
constexpr double rounding = 1.0 / (1 << 22); // of the longest side: four times what float32 rounds at most

} // namespace

double longest_side(const Mesh &mesh) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < 3 * mesh.vertex_count; i++) {
    const double at = double(mesh.positions[i]);
    if (!std::isfinite(at)) continue;
    low[i % 3] = std::min(low[i % 3], at);
    high[i % 3] = std::max(high[i % 3], at);
  }
  return std::max({0.0, high[0] - low[0], high[1] - low[1], high[2] - low[2]});
}

double near_plane(const Mesh &mesh) {
  const double side = longest_side(mesh);
  return side > 0 ? std::min(most_near, side * sides_of_near) : most_near;
}

double vertex_lift(const Mesh &mesh) {
  const double side = longest_side(mesh);
  return side > 0 ? std::max(std::min(most_lift, side * sides_of_lift), side * rounding) : most_lift;
}

} // namespace fvv::render
