// fvvcompare/temporal.h: whether two sequences of constant topology move alike: the difference of their
// motions from one frame to the next, which shows swimming and flicker. Knows meshes; knows nothing of
// frames' numbers.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <vector>

namespace fvv::compare {

// Which vertex of A each vertex of B is, for a run of frames over which neither changes its faces.
struct Correspondence {
  std::vector<uint32_t> of_a; // by vertices of B
  bool by_order = false;      // both have the same faces; otherwise the nearest vertex counts
  double furthest = 0;        // distance of any vertex of B from its vertex of A, in the frame that was used
};
Correspondence correspondence(const geometry::Mesh &a, const geometry::Mesh &b);

// Of one frame against the one in front of it, over all vertices of B that faces use.
struct MotionError {
  double rms = 0, max = 0; // |motion of B - motion of A|
  double motion = 0;       // rms motion of A, to compare with
};
// The meshes of both frames have the faces that match was made for.
MotionError motion_error(const geometry::Mesh &a_before, const geometry::Mesh &a,
                         const geometry::Mesh &b_before, const geometry::Mesh &b,
                         const Correspondence &match);

} // namespace fvv::compare
