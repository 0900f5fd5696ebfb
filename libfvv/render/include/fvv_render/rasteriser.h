// Which face of a mesh each sample of a picture sees, and how far away. The reference for depth and
// visibility: exact coverage, no tolerance, the same result on every machine with IEEE doubles.
#pragma once

#include "fvv_render/projection.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fvv::render {

// Triangles as the rasteriser sees them. Borrowed; every index must be < vertex_count.
struct Mesh {
  const float *positions = nullptr; // x y z of each vertex, world metres
  size_t vertex_count = 0;
  const uint32_t *faces = nullptr; // three vertex indices of each face; either winding is drawn
  size_t face_count = 0;
};

constexpr uint32_t no_face = UINT32_MAX;

// What is seen at samples x samples points of every pixel (a visibility buffer). samples is odd, so that the
// middle sample is the centre of the pixel.
class SampleBuffer {
public:
  // Throws std::invalid_argument unless both sides are 1..16384 and samples is 1, 3, 5 or 7.
  SampleBuffer(uint32_t width, uint32_t height, uint32_t samples);
  // Takes time in proportion to what was drawn.
  void clear();
  // Clears and takes another size, within the same memory if that suffices. Throws as the constructor.
  void resize(uint32_t width, uint32_t height);

  uint32_t width, height;
  const uint32_t samples;
  size_t columns;             // width * samples: samples in a row
  std::vector<uint32_t> face; // columns x (height * samples), row by row; no_face: nothing
  std::vector<float> depth;   // z_c in metres; +inf: nothing

  // Everything drawn since the last clear() lies in columns left ... right - 1, rows top ... bottom - 1.
  struct Extent {
    size_t left = SIZE_MAX, top = SIZE_MAX, right = 0, bottom = 0;
  } drawn;
};

// Draws mesh into buffer, which keeps what was nearer; at equal depth the face drawn first stays. Rows of the
// buffer are those of camera's picture; throws std::invalid_argument when the sizes differ.
//
// Coverage: vertices are rounded to 1/256 of a sample spacing and edges evaluated in integers. A sample on an
// edge belongs to the triangle for which the edge is a top edge (horizontal, interior below) or a left edge,
// so a sample on a shared edge is drawn exactly once. Triangles are clipped at near_plane() and far outside
// the picture; new vertices depend on the two ends of the edge alone, so clipping opens no gap either.
// Triangles without area after rounding, or with a coordinate that is not finite, are skipped.
//
// Depth and barycentric coordinates come from the ray through the sample and the given triangle
// (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997), not from rounded or
// clipped vertices.
//
// Lenses: vertices are projected through the lens and edges drawn straight between them. The outline of a
// triangle is off by less than l^2 k / f pixels for edges of l pixels, |k1| <= k and a focal length of f
// pixels: 0.01 for l = 6, k = 0.2, f = 750. Depth and barycentric coordinates follow the bent rays. A
// triangle with a vertex that the lens does not show is skipped, so nothing is cut at near_plane().
void rasterise(const Projection &camera, const Mesh &mesh, SampleBuffer &buffer);

// The same without depth: buffer.face has one of the faces that cover a sample, buffer.depth stays as it is.
// For outlines; the projection needs no rays.
void rasterise_coverage(const Projection &camera, const Mesh &mesh, SampleBuffer &buffer);

// Where rays meet the plane of a face: barycentric coordinates in space (so perspective-correct), clamped to
// the triangle. They are proportional to the values at the ray of the three planes through the camera's
// centre and an edge.
class FaceInterpolator {
public:
  // Corners in the camera frame.
  FaceInterpolator(Vec3 a, Vec3 b, Vec3 c) : plane{cross(b, c), cross(c, a), cross(a, b)} {}
  FaceInterpolator(const Projection &camera, const Mesh &mesh, uint32_t face);

  // ray: as Projection::ray() returns it.
  std::array<double, 3> at(Vec3 ray) const {
    double w[3], sum = 0;
    for (int i = 0; i < 3; i++) sum += w[i] = dot(plane[i], ray);
    // Rounding of vertices lets a sample just outside the triangle be covered, and for a triangle seen
    // edge-on the plane is meaningless there: stay within the triangle.
    double kept = 0;
    for (double &value : w) kept += value = sum != 0 ? std::max(0.0, value / sum) : 1;
    return {w[0] / kept, w[1] / kept, w[2] / kept};
  }

private:
  Vec3 plane[3];
};

// The same for the ray through pixel position (u, v).
std::array<double, 3> barycentric(const Projection &camera, const Mesh &mesh, uint32_t face, double u,
                                  double v);

} // namespace fvv::render
