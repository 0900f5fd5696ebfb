// The rest shape of a player as an implicit surface: rounded cones, each carried by a bone, joined smoothly
// within a layer (skin, shorts, jersey, shoes). Knows the skeleton's rest pose; knows no triangles.
#pragma once

#include "fvvsynth/skeleton.h"

#include <limits>
#include <vector>

namespace fvv::synth {

enum Layer : uint8_t { skin, hair, shorts, jersey, shoes, layer_count };

// The points whose distance from segment a-b is below a radius that goes from radius_a to radius_b.
struct Part {
  Joint bone;
  Layer layer;
  Vec3 a, b;
  double radius_a, radius_b;
  Vec3 squash_axis{0, 0, 1}; // unit vector, across which
  double squash = 1;         // the part is this much thinner
  // The part ends at the plane dot(cut_normal, p) = cut_offset; the default cuts nothing off.
  Vec3 cut_normal{};
  double cut_offset = std::numeric_limits<double>::infinity();
};

enum class Hair { short_cut, afro };

class Figure {
public:
  explicit Figure(Hair hair);
  // About the distance from the surface in metres, negative inside.
  double distance(Vec3 p) const;
  // Unit vector of its steepest rise: outwards.
  Vec3 outwards(Vec3 p) const;
  // The bone that carries the surface there: that of the nearest part.
  Joint bone(Vec3 p) const;

private:
  std::vector<Part> parts;
};

} // namespace fvv::synth
