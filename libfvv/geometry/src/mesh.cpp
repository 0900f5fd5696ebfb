#include "fvv_geometry/mesh.h"
#include "fvv_cxx/error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace fvv::geometry {

namespace {

// Whether most normals point to the side from which the corners of their faces run clockwise.
bool oppose_faces(const Mesh &mesh) {
  int64_t balance = 0;
  for (size_t f = 0; f < mesh.faces.size(); f += 3) {
    const double *p[3];
    for (size_t c = 0; c < 3; c++) p[c] = &mesh.positions[3 * size_t(mesh.faces[f + c])];
    double across[3];
    for (size_t k = 0; k < 3; k++) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      across[k] = (p[1][i] - p[0][i]) * (p[2][j] - p[0][j]) - (p[1][j] - p[0][j]) * (p[2][i] - p[0][i]);
    }
    for (size_t c = 0; c < 3; c++) {
      const double *n = &mesh.normals[3 * size_t(mesh.faces[f + c])];
      const double dot = across[0] * n[0] + across[1] * n[1] + across[2] * n[2];
      balance += (dot > 0) - (dot < 0);
    }
  }
  return balance < 0;
}

// per_vertex: values that each vertex has; "a coordinate of vertex 3".
void check_values(const std::vector<double> &values, size_t per_vertex, size_t vertices, const char *noun,
                  const std::string &name) {
  if (values.size() != per_vertex * vertices)
    throw Error(name + ": expected " + std::to_string(per_vertex) + " " + noun + "s for each of " +
                std::to_string(vertices) + " vertices, found " + std::to_string(values.size()));
  for (size_t i = 0; i < values.size(); i++)
    if (!std::isfinite(values[i]))
      throw Error(name + ": a " + noun + " of vertex " + std::to_string(i / per_vertex) + " is not finite");
}

} // namespace

void check(const Mesh &mesh, const std::string &name) {
  if (mesh.faces.empty()) throw Error(name + ": expected a mesh with faces");
  if (mesh.positions.size() % 3 || mesh.faces.size() % 3 || mesh.vertex_count() > INT32_MAX)
    throw Error(name + ": expected multiples of 3 and at most 2147483647 vertices, found " +
                std::to_string(mesh.positions.size()) + " coordinates and " +
                std::to_string(mesh.faces.size()) + " corners");
  const size_t vertices = mesh.vertex_count();
  check_values(mesh.positions, 3, vertices, "coordinate", name);
  if (!mesh.texture.empty()) check_values(mesh.texture, 2, vertices, "texture coordinate", name);
  if (!mesh.normals.empty()) check_values(mesh.normals, 3, vertices, "normal coordinate", name);
  for (size_t i = 0; i < mesh.faces.size(); i++)
    if (mesh.faces[i] >= vertices)
      throw Error(name + ": face " + std::to_string(i / 3) + " has index " + std::to_string(mesh.faces[i]) +
                  " of " + std::to_string(vertices) + " vertices");
}

double TypicalBox::diagonal() const {
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

TypicalBox typical_box(const Mesh &mesh) {
  constexpr double outermost = 0.005, stray = 0.05, far_off = 4;
  std::vector<bool> used(mesh.vertex_count());
  for (const uint32_t v : mesh.faces) used[v] = true;
  TypicalBox box, core;
  std::vector<double> values;
  for (size_t axis = 0; axis < 3; axis++) {
    values.clear();
    for (size_t v = 0; v < used.size(); v++)
      if (used[v] && std::isfinite(mesh.positions[3 * v + axis]))
        values.push_back(mesh.positions[3 * v + axis]);
    if (values.empty()) continue;
    const auto without = [&](double fraction, TypicalBox &out) {
      const auto skipped = std::ptrdiff_t(fraction * double(values.size()));
      const auto low = values.begin() + skipped, high = values.end() - 1 - skipped;
      std::nth_element(values.begin(), low, values.end());
      out.low[axis] = *low;
      std::nth_element(values.begin(), high, values.end());
      out.high[axis] = *high;
    };
    without(outermost, box);
    without(stray, core);
  }
  const double size = core.diagonal();
  return size > 0 && box.diagonal() > far_off * size ? core : box;
}

void flip_faces(Mesh &mesh) {
  for (size_t f = 0; f < mesh.faces.size(); f += 3) std::swap(mesh.faces[f + 1], mesh.faces[f + 2]);
  if (mesh.normals.empty() || !oppose_faces(mesh)) return;
  for (double &coordinate : mesh.normals) coordinate = -coordinate;
}

double round_down_125(double value) {
  // 10^|k| is exact up to 22, so the quotient is the double nearest to the decimal.
  const auto candidate = [](int mantissa, int k) {
    return k < 0 ? mantissa / std::pow(10.0, -k) : mantissa * std::pow(10.0, k);
  };
  const int guess = int(std::floor(std::log10(value)));
  double best = 0;
  for (int k = guess - 1; k <= guess + 1; k++)
    for (const int mantissa : {1, 2, 5})
      if (candidate(mantissa, k) <= value) best = candidate(mantissa, k);
  return best;
}

} // namespace fvv::geometry
