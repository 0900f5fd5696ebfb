#include "fvv_geometry/mesh.h"

#include <cmath>
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

} // namespace

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
