// The hoop of the scene "game": part of the mesh, because it is within the reach of the players and moves. A
// base, a pole, a board, a ring and a net of cords, each a closed surface.
#pragma once

#include "fvv_geometry/hull.h"
#include "fvv_render/picture.h"
#include "fvvsynth/game/game.h"

#include <vector>

namespace fvv::synth {

using hull::Surface;

struct Hoop {
  Surface rest;
  size_t net_vertices; // the first ones of the net, which goes on to the end
};
Hoop make_hoop();

// The hoop at a moment, appended to positions (x y z, metres): the net gives way to the ball and swings
// after it.
void carry(const Hoop &hoop, const Game &game, double seconds, std::vector<float> &positions);

// At a point of the hoop at rest.
render::Reflectance hoop_reflectance(Vec3 rest);

} // namespace fvv::synth
