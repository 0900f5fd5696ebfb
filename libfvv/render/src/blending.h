// The weights with which the colours of cameras are mixed at a point of the surface (fvv.md, clause 17.5).
#pragma once

#include "fvv_render/view.h"

#include <array>

namespace fvv::render {

// A camera that may give colour at a point.
struct Candidate {
  uint32_t source = no_source;
  double weight = 0;
  double certainty = 0; // the weight without the direction, 0 to 1
  double at[2] = {};    // the point, in the source's pixels

  void operator*=(double factor) {
    weight *= factor;
    certainty *= factor;
  }
};

// Where a camera is, as seen from a point of the surface: cosines between the ray to the camera and the
// normal, and between the rays to the camera and to the viewer.
struct ViewAngles {
  double facing, direction;
};

// With the weight before the picture is looked at, an upper bound of the final weight. 0: the camera is not
// used.
Candidate directed(const ViewOptions &options, const ViewAngles &angles);

// A factor from 0 to 1 for a point whose interpolated visibility weight is seen, 0 to 255: 0 to one half: the
// camera does not show it.
double visibility_factor(Blend blend, double seen);

// A factor from 0 to 1 for a point at this many pixels from the border of the usable part of a picture.
double border_factor(Blend blend, double distance);

// The best cameras of a point, added in any order. At equal weight the first one added is preferred.
class BestCameras {
public:
  explicit BestCameras(const ViewOptions &options);
  // Whether a camera whose weight is at most bound can change the result.
  bool accepts(double bound) const { return count < kept || bound > all[kept - 1].weight; }
  void add(const Candidate &camera);
  // The cameras by falling weight, with final weights that add up to 1; none: nothing was added.
  const Candidate *begin() const { return all.data(); }
  const Candidate *end() const { return all.data() + count; }
  void normalise();
  // After normalise: the share of their colour where the surface has a colour of its own, 0 to 1.
  double certainty() const;

private:
  const Blend blend;
  const size_t best, kept;
  size_t count = 0;
  std::array<Candidate, max_best + 1> all;
};

} // namespace fvv::render
