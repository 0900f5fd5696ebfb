// The simplifier: edge collapses by quadric error metrics (Garland and Heckbert 1997), which are
// meshoptimizer's.
#pragma once

#include "fvv_geometry/mesh.h"

namespace fvv::decimate {

// How far to go: to an error in the mesh's unit as the simplifier estimates it, or to a number of faces at
// any error.
struct SimplifyTarget {
  double error = 0;
  size_t faces = 0; // 0: error holds
};

// A mesh that can be simplified repeatedly. The result uses vertices of the mesh; none is moved. Open borders
// do not change, nor do vertices of edges with more than two faces; vertices at one place with different
// texture coordinates are the seam of an atlas, which remains a seam. No face covers another one, corner on
// corner, that does not in the source.
//
// The simplifier computes in single precision, relative to the centre of the box here. The same build gives
// the same faces for the same input; another processor may give others, which is why only the measured error
// is relied upon.
class Simplifier {
public:
  // Every coordinate of mesh is finite, every index in range, there is a face. alike: for each vertex the one
  // that replaces it (first_alike).
  Simplifier(const geometry::Mesh &mesh, const std::vector<uint32_t> &alike);

  // Faces, three vertices each. locked: for each face of the mesh whether it has to stay; empty: none. Locked
  // faces come last.
  std::vector<uint32_t> simplify(const SimplifyTarget &target, const std::vector<bool> &locked) const;

private:
  std::vector<uint32_t> without_folds(std::vector<uint32_t> simplified) const;

  std::vector<uint32_t> faces;
  std::vector<float> positions;
  float scale; // of errors relative to the extent
};

} // namespace fvv::decimate
