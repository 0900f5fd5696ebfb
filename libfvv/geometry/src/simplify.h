// The simplifier: edge collapses by quadric error metrics (Garland and Heckbert 1997), which are
// meshoptimizer's.
#pragma once

#include "fvv_geometry/mesh.h"

namespace fvv::decimate {

// How far to go: to an error in the mesh's unit as the simplifier estimates it, or to a number of faces
// whatever that costs.
struct Reach {
  double error = 0;
  size_t faces = 0; // 0: error holds
};

// A mesh whose faces can be thinned out again and again. Vertices are never moved: what is left are vertices
// of the mesh. Open borders stay as they are, and so do vertices of edges with more than two faces; vertices
// that share a place and differ in their texture coordinates are the seam of an atlas, which stays a seam.
//
// The simplifier computes in single precision, relative to the centre of the box here. The same build gives
// the same faces for the same input; that another processor's does too is not promised, which is why nothing
// but the measured error is relied upon.
class Simplifier {
public:
  // Every coordinate of mesh is finite, every index in range, there is a face. alike: for each vertex the one
  // to be named in its place (first_alike).
  Simplifier(const geometry::Mesh &mesh, const std::vector<uint32_t> &alike);

  // Faces, three vertices each. held: for each face of the mesh whether it has to stay; empty: none has to.
  // Faces that are held come last.
  std::vector<uint32_t> simplify(const Reach &reach, const std::vector<bool> &held) const;

private:
  std::vector<uint32_t> faces;
  std::vector<float> positions;
  float scale; // of errors relative to the extent
};

} // namespace fvv::decimate
