// Shapes whose area, volume and distance from a source are known in closed form, and cameras to see them by.
#pragma once

#include "fvv_catch.h"

#include "fvv_geometry/decimate.h"
#include "fvv_geometry/pieces.h"

#include <cmath>
#include <map>

namespace shapes {

using namespace fvv;
using geometry::Mesh;

// A grid of cells x cells squares over 1 m x 1 m at height z(x, y); texture: (x, y).
template <class Height> Mesh sheet(uint32_t cells, bool texture, const Height &z) {
  Mesh mesh;
  for (uint32_t j = 0; j <= cells; j++)
    for (uint32_t i = 0; i <= cells; i++) {
      const double x = double(i) / cells, y = double(j) / cells;
      mesh.positions.insert(mesh.positions.end(), {x, y, z(x, y)});
      if (texture) mesh.texture.insert(mesh.texture.end(), {x, y});
    }
  for (uint32_t j = 0; j < cells; j++)
    for (uint32_t i = 0; i < cells; i++) {
      const uint32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      mesh.faces.insert(mesh.faces.end(), {a, b, d, a, d, c});
    }
  return mesh;
}

// An octahedron, each face split in four again and again, on a sphere around a centre.
inline Mesh sphere(double radius, int splits, double x = 0, double y = 0, double z = 0) {
  Mesh mesh;
  mesh.positions = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
  mesh.faces = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  for (int split = 0; split < splits; split++) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [known, fresh] = middles.try_emplace(std::minmax(a, b), uint32_t(mesh.vertex_count()));
      if (fresh) {
        double p[3], size = 0;
        for (int k = 0; k < 3; k++) {
          p[k] = mesh.positions[3 * a + size_t(k)] + mesh.positions[3 * b + size_t(k)];
          size += p[k] * p[k];
        }
        for (const double q : p) mesh.positions.push_back(q / std::sqrt(size));
      }
      return known->second;
    };
    std::vector<uint32_t> faces;
    for (size_t f = 0; f < mesh.faces.size(); f += 3) {
      const uint32_t a = mesh.faces[f], b = mesh.faces[f + 1], c = mesh.faces[f + 2];
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      faces.insert(faces.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
    }
    mesh.faces = faces;
  }
  const double centre[3] = {x, y, z};
  for (size_t i = 0; i < mesh.positions.size(); i++)
    mesh.positions[i] = centre[i % 3] + radius * mesh.positions[i];
  return mesh;
}

inline Mesh together(const Mesh &a, const Mesh &b) {
  Mesh out = a;
  out.positions.insert(out.positions.end(), b.positions.begin(), b.positions.end());
  for (const uint32_t v : b.faces) out.faces.push_back(v + uint32_t(a.vertex_count()));
  return out;
}

// At the origin, looking along +z: a pixel covers distance / focal metres straight ahead.
inline fvv_camera camera(double focal, uint32_t size = 2000) {
  fvv_camera c = {};
  c.id = 7;
  c.width = c.height = size;
  c.fx = c.fy = focal;
  c.cx = c.cy = size / 2.0;
  c.rotation[0] = c.rotation[4] = c.rotation[8] = 1;
  c.r_max = INFINITY;
  return c;
}

// So far away that a pixel covers a millimetre all over the shapes, within a thousandth.
inline decimate::Footprint millimetre_pixels() {
  fvv_camera c = camera(2e6, 60000);
  c.translation[2] = 2000;
  c.cx = c.cy = 30000;
  decimate::Footprint cameras;
  cameras.add(c, 1, 1);
  return cameras;
}

inline decimate::Budget budget(double pixels, double step = 1e-5) {
  decimate::Budget wanted;
  wanted.pixels = pixels;
  wanted.lattice = {{0, 0, 0}, step};
  return wanted;
}

} // namespace shapes
