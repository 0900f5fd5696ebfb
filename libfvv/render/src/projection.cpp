#include "fvv_render/projection.h"

#include "fvv/format.h"

#include <algorithm>

namespace fvv::render {

namespace {

// Cubic interpolation along one side of a picture, between corners of pixels some pixels apart (nodes).
struct Stencils {
  struct Stencil {
    size_t first;
    double weight[4]; // Lagrange's, of four nodes from the first on
  };
  std::vector<uint32_t> nodes;   // ascending, from 0 to the side
  std::vector<Stencil> stencils; // one for each corner 0 ... side

  explicit Stencils(uint32_t side) {
    const uint32_t spacing = std::clamp(side / 3, 1u, 8u);
    for (uint32_t at = 0; at < side; at += spacing) nodes.push_back(at);
    nodes.push_back(side);
    const size_t last = nodes.size() - std::min<size_t>(4, nodes.size());
    for (uint32_t at = 0; at <= side; at++) {
      Stencil stencil = {std::min<size_t>(std::max(at / spacing, 1u) - 1, last), {}};
      for (size_t i = 0; i < 4 && i < nodes.size(); i++) {
        double weight = 1;
        for (size_t k = 0; k < 4 && k < nodes.size(); k++)
          if (k != i)
            weight *= (double(at) - nodes[stencil.first + k]) /
                      (double(nodes[stencil.first + i]) - nodes[stencil.first + k]);
        stencil.weight[i] = weight;
      }
      stencils.push_back(stencil);
    }
  }

  // Of corner, from values of the nodes that are stride apart.
  Vec3 at(size_t corner, const Vec3 *values, size_t stride) const {
    const Stencil &stencil = stencils[corner];
    Vec3 sum;
    for (size_t i = 0; i < 4 && i < nodes.size(); i++)
      sum += values[(stencil.first + i) * stride] * stencil.weight[i];
    return sum;
  }
};

} // namespace

Projection::Projection(const fvv_camera &camera, Rays rays)
    : intrinsics(camera), rotation{{camera.rotation[0], camera.rotation[3], camera.rotation[6]},
                                   {camera.rotation[1], camera.rotation[4], camera.rotation[7]},
                                   {camera.rotation[2], camera.rotation[5], camera.rotation[8]}},
      translation{camera.translation[0], camera.translation[1], camera.translation[2]} {
  intrinsics.name = nullptr;
  intrinsics.name_size = 0;
  for (int i = 0; i < 9; i++) intrinsics.rotation[i] = i % 4 == 0;
  for (double &t : intrinsics.translation) t = 0;
  if (camera.lens != FVV_LENS_NONE && rays == Rays::traced) trace_corners();
}

Vec3 Projection::exact_ray(uint32_t x, uint32_t y) const {
  const double pixel[2] = {double(x), double(y)};
  double r[3];
  (void)fvv_camera_unproject(&intrinsics, pixel, r);
  return {r[0], r[1], r[2]};
}

void Projection::trace_corners() {
  const Stencils across(width()), down(height());
  const size_t columns = size_t(width()) + 1, rows = size_t(height()) + 1;
  corner_rays.resize(columns * rows);
  // Rays of every node, then of every corner in the rows of nodes, then of all.
  std::vector<Vec3> nodes(down.nodes.size() * columns), row(across.nodes.size());
  for (size_t j = 0; j < down.nodes.size(); j++) {
    for (size_t i = 0; i < row.size(); i++) row[i] = exact_ray(across.nodes[i], down.nodes[j]);
    for (size_t x = 0; x < columns; x++) nodes[j * columns + x] = across.at(x, row.data(), 1);
  }
  for (size_t y = 0; y < rows; y++)
    for (size_t x = 0; x < columns; x++) corner_rays[y * columns + x] = down.at(y, &nodes[x], columns);
  // The error is largest half way between nodes. A lens near the end of its range bends too fast, and its NaN
  // would spread: then every corner is computed.
  const double tolerance = 2.5e-4 / std::max(intrinsics.fx, intrinsics.fy);
  bool exact = true;
  for (size_t j = 1; j < down.nodes.size() && exact; j++)
    for (size_t i = 1; i < across.nodes.size() && exact; i++) {
      const uint32_t x = (across.nodes[i - 1] + across.nodes[i]) / 2,
                     y = (down.nodes[j - 1] + down.nodes[j]) / 2;
      exact = length(corner_rays[size_t(y) * columns + x] - exact_ray(x, y)) < tolerance;
    }
  if (exact) return;
  for (uint32_t y = 0; y < rows; y++)
    for (uint32_t x = 0; x < columns; x++) corner_rays[size_t(y) * columns + x] = exact_ray(x, y);
}

Vec3 Projection::through_lens(Vec3 camera) const {
  const double point[3] = {camera.x, camera.y, camera.z};
  double pixel[2];
  (void)fvv_camera_project(&intrinsics, point, pixel, nullptr); // NaN when it is not seen
  return {pixel[0] * camera.z, pixel[1] * camera.z, camera.z};
}

Vec3 Projection::interpolated_ray(double u, double v) const {
  // Not std::floor: without SSE4.1 it is a call of a function.
  const auto whole = [](double at, uint32_t side) { return at > 0 ? std::min(uint32_t(at), side - 1) : 0; };
  const uint32_t x = whole(u, width()), y = whole(v, height());
  const size_t stride = size_t(width()) + 1;
  const Vec3 *corner = &corner_rays[size_t(y) * stride + size_t(x)];
  return mix(mix(corner[0], corner[1], u - x), mix(corner[stride], corner[stride + 1], u - x), v - y);
}

Vec3 up_vector(uint8_t axis) {
  switch (axis) {
  case FVV_UP_X:
    return {1, 0, 0};
  case FVV_UP_Z:
    return {0, 0, 1};
  case FVV_UP_MINUS_X:
    return {-1, 0, 0};
  case FVV_UP_MINUS_Y:
    return {0, -1, 0};
  case FVV_UP_MINUS_Z:
    return {0, 0, -1};
  default:
    return {0, 1, 0};
  }
}

} // namespace fvv::render
