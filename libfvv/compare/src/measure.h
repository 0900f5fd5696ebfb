// Distances between two surfaces, and between the motions of two sequences of constant topology.
// docs/tools/fvvcompare.md has the formulas and their sources. Every function is pure and may run on any
// thread.
#pragma once

#include "fvv_compare/compare.h"
#include "fvv_geometry/surface.h"

#include <cstdint>
#include <map>
#include <vector>

namespace fvv::compare {

// Counts in bins whose width is at most 2^-10 of their values (the first bits of a double), so that those of
// many frames can be added in any order and kept in little memory.
class Histogram {
public:
  void add(double value); // 0 or more, finite
  void add(const Histogram &other);
  uint64_t count() const { return total; }
  // The quantile of a fraction (nearest rank), or up to 2^-10 of it less: the lower bound of its bin. 0 when
  // there are none.
  double quantile(double share) const;

private:
  std::map<uint32_t, uint64_t> bins;
  uint64_t total = 0;
};

class Spread {
public:
  void add(double value);  // 0 or more, finite
  Figures figures() const; // all 0 without values
  const Histogram &histogram() const { return bins; }

private:
  double sum = 0, squares = 0, largest = 0;
  Histogram bins;
};

// From one surface to the other, lengths as positions have them.
struct DirectedErrors {
  Spread distance;       // point to surface, of the samples
  double hausdorff = 0;  // the largest distance, of samples and vertices
  double d1 = 0, d2 = 0; // mean squared error, point to point and point to plane
  Spread angle;          // between smooth normals, degrees
  double turned = 0;     // fraction of samples where the other surface shows its other side
};

struct Measure {
  DirectedErrors a_to_b, b_to_a;
};

// samples > 0: of each surface. Both have an area.
Measure measure(const Surface &a, const Surface &b, size_t samples, Points points);

// Which vertex of A each vertex of B is, for a run of frames over which neither changes its faces.
struct Correspondence {
  std::vector<uint32_t> of_a; // by vertices of B
  bool by_order = false;      // both have the same faces; otherwise the nearest vertex counts
  double furthest = 0;        // distance of any vertex of B from its vertex of A, in the frame that was used
};
Correspondence correspondence(const geometry::Mesh &a, const geometry::Mesh &b);

// The meshes of both frames have the faces that match was made for.
MotionError motion_error(const geometry::Mesh &a_before, const geometry::Mesh &a,
                         const geometry::Mesh &b_before, const geometry::Mesh &b,
                         const Correspondence &match);

} // namespace fvv::compare
