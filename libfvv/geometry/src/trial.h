// A quick check of a decimated surface before it is fitted and measured: finds places beyond a limit without
// computing all distances.
#pragma once

#include "fvv_geometry/decimate.h"

namespace fvv::decimate {

// The attempts for one frame. Faces that stay from one to the next are not checked again.
class Trial {
public:
  // of: borrowed. limit: pixels.
  Trial(const Reference &of, double limit_pixels) : reference(of), limit(limit_pixels) {}

  // All vertices of the source that have an area, and the middles of all sides of the decimated faces (a face
  // that bridges a hollow is furthest off there). mesh: with vertices of the source at their places;
  // vertices: their indices in it; surface: of mesh.
  Outliers look(const geometry::Mesh &mesh, const std::vector<uint32_t> &vertices,
                const compare::Faces &surface);

private:
  // Three vertices of the source, the lowest first, and their face.
  using Key = std::array<uint32_t, 4>;

  const Reference &reference;
  const double limit;
  std::vector<Key> keys;      // of the last mesh, sorted
  std::vector<uint32_t> near; // for each vertex of the source a face of that within the limit; or UINT32_MAX
  std::vector<bool> fine;     // for each of its faces whether its sides are within the limit
};

} // namespace fvv::decimate
