// fvvcompare/measure.h: how far two surfaces are apart. docs/fvvcompare.md has the formulas and their
// sources. Knows surfaces; knows nothing of sequences. Every function is pure and may run on any thread.
#pragma once

#include "fvv_geometry/surface.h"
#include "fvvcompare/spread.h"

namespace fvv::compare {

// Which points D1 and D2 are measured at: the vertices, or these and the samples of the surface.
enum class Points { vertices, samples };

// From one surface to the other, lengths as positions have them.
struct Direction {
  Spread distance;       // point to surface, of the samples
  double hausdorff = 0;  // the largest distance, of samples and vertices
  double d1 = 0, d2 = 0; // mean squared error, point to point and point to plane
  Spread angle;          // between smooth normals, degrees
  double turned = 0;     // share of samples where the other surface shows its other side
};

struct Measure {
  Direction forth, back; // A to B, B to A
};

// samples > 0: of each surface. Both have an area.
Measure measure(const Surface &a, const Surface &b, size_t samples, Points points);

} // namespace fvv::compare
