// fvv_render/rasteriser.h: which face of a mesh each sample of a picture sees, and how far away. Knows
// cameras (pinhole) and triangles; knows nothing of colour, files or streams. The reference for depth and
// visibility: exact coverage, no tolerance, the same result on every machine with IEEE doubles.
#pragma once

#include "fvv/calibration.h"
#include "fvv_render/vector.h"

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

// A camera without lens distortion as linear maps. Throws std::invalid_argument for any other lens: straight
// edges would be curves there, so such pictures have to be undistorted first.
class Pinhole {
public:
  explicit Pinhole(const fvv_camera &camera);
  uint32_t width() const { return columns; }
  uint32_t height() const { return rows; }
  // World -> camera frame, metres: x right, y down, z forward.
  Vec3 to_camera(Vec3 world) const { return rotation * world + translation; }
  Vec3 to_world_direction(Vec3 camera) const { return transposed(rotation) * camera; }
  Vec3 centre() const { return -(transposed(rotation) * translation); }
  // Homogeneous pixel: u = x / z, v = y / z, the centre of the top left pixel at (0.5, 0.5).
  Vec3 to_pixel(Vec3 camera) const {
    return {fx * camera.x + skew * camera.y + cx * camera.z, fy * camera.y + cy * camera.z, camera.z};
  }
  // Ray through a pixel position in the camera frame, z = 1.
  Vec3 ray(double u, double v) const {
    const double y = (v - cy) / fy;
    return {(u - cx - skew * y) / fx, y, 1};
  }

private:
  uint32_t columns, rows;
  double fx, fy, cx, cy, skew;
  Mat3 rotation;
  Vec3 translation;
};

// Nothing nearer than this to the plane through the camera's centre is drawn, metres of z_c.
constexpr double near_plane = 0.01;
constexpr uint32_t no_face = UINT32_MAX;

// What is seen at samples x samples points of every pixel (a visibility buffer). samples is odd, so that the
// middle sample is the centre of the pixel.
class SampleBuffer {
public:
  // Throws std::invalid_argument unless both sides are 1..16384 and samples is 1, 3, 5 or 7.
  SampleBuffer(uint32_t width, uint32_t height, uint32_t samples);
  void clear();

  const uint32_t width, height, samples;
  const size_t columns;       // width * samples: samples in a row
  std::vector<uint32_t> face; // columns x (height * samples), row by row; no_face: nothing
  std::vector<float> depth;   // z_c in metres; +inf: nothing
};

// Draws mesh into buffer, which keeps what was nearer; at equal depth the face drawn first stays. Rows of the
// buffer are those of camera's picture; throws std::invalid_argument when the sizes differ.
//
// Coverage: vertices are rounded to 1/256 of a sample spacing and edges evaluated in integers. A sample on an
// edge belongs to the triangle for which the edge is a top edge (horizontal, interior below) or a left edge,
// so a sample on a shared edge is drawn exactly once. Triangles are clipped at near_plane and far outside the
// picture; new vertices depend on the two ends of the edge alone, so clipping opens no gap either. Triangles
// without area after rounding, or with a coordinate that is not finite, are skipped.
//
// Depth and barycentric coordinates come from the ray through the sample and the triangle that was handed in
// (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997), not from rounded or
// clipped vertices.
void rasterise(const Pinhole &camera, const Mesh &mesh, SampleBuffer &buffer);

// Where the ray through pixel position (u, v) meets the plane of a face: barycentric coordinates in space (so
// perspective-correct), clamped to the triangle.
std::array<double, 3> barycentric(const Pinhole &camera, const Mesh &mesh, uint32_t face, double u, double v);

} // namespace fvv::render
