// The shadow of the players on the floor: a shadow map (Williams, "Casting curved shadows on curved
// surfaces", 1978) of the mesh in the light of a distant lamp, for the plane y = 0 alone. Knows one mesh;
// knows no colours.
#pragma once

#include "fvv_render/picture.h"

#include <vector>

namespace fvv::synth {

struct Lamp {
  render::Vec3 towards; // unit vector to the lamp
  double share;         // of the floor's light that comes from it
  double softness;      // half the width of the penumbra, metres
};

class Shadow {
public:
  Shadow(const render::Mesh &mesh, const Lamp &lamp);
  // Darkens what camera sees of the floor. What stands on it in front is expected to be drawn afterwards.
  void cast(const render::Projection &camera, render::LightField &picture) const;

private:
  double covered(render::Vec3 on_floor) const;

  Lamp light;
  render::Projection view;         // of the lamp
  std::vector<float> blocked;      // share of the light for each of its pixels
  double left, top, right, bottom; // where any is blocked
};

} // namespace fvv::synth
