#include "fvvcompare/heatmap.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>

namespace fvv::compare {

namespace {

template <class Value> void put(std::string &out, Value value) {
  uint8_t bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(reinterpret_cast<const char *>(bytes), sizeof bytes);
}

// Five colours of viridis (Smith and van der Walt, 2015), and straight lines between them.
std::array<uint8_t, 3> colour_of(double share) {
  constexpr double stops[5][3] = {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  const double at = 4 * std::clamp(share, 0.0, 1.0);
  const size_t stop = std::min<size_t>(3, size_t(at));
  std::array<uint8_t, 3> out;
  for (size_t k = 0; k < 3; k++)
    out[k] = uint8_t(stops[stop][k] + (stops[stop + 1][k] - stops[stop][k]) * (at - double(stop)) + 0.5);
  return out;
}

} // namespace

std::string format_heatmap(const geometry::Mesh &mesh, const std::vector<double> &distances, double most) {
  char scale[32];
  std::snprintf(scale, sizeof scale, "%.6g", most);
  std::string out = "ply\nformat binary_little_endian 1.0\ncomment yellow: a distance of " +
                    std::string(scale) + " or more\nelement vertex " + std::to_string(mesh.vertex_count()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nproperty float distance\n"
                    "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face " +
                    std::to_string(mesh.face_count()) +
                    "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    for (size_t k = 0; k < 3; k++) put(out, mesh.positions[3 * v + k]);
    put(out, float(distances[v]));
    for (const uint8_t sample : colour_of(most > 0 ? distances[v] / most : 0)) put(out, sample);
  }
  for (size_t f = 0; f < mesh.faces.size(); f += 3) {
    put(out, uint8_t(3));
    for (size_t k = 0; k < 3; k++) put(out, mesh.faces[f + k]);
  }
  return out;
}

} // namespace fvv::compare
