// What players and ball look like: solid textures (Perlin, "An image synthesizer", 1985) over the rest shape,
// so that no unwrapping is needed and no seam shows.
#pragma once

#include "fvv_render/picture.h"
#include "fvvsynth/body.h"
#include "fvvsynth/random.h"

#include <array>

namespace fvv::synth {

using render::Rgb;

struct Look {
  Rgb skin, hair, cloth, trim, shoe; // linear
  int number;                        // 0..99, on chest and back
  Hair style;
  bool headband;
  uint32_t key; // of the noise
};

// Two players of different teams.
std::array<Look, 2> make_looks(Random &random);

// Reflectance of a player at a point of the rest figure (metres, see skeleton.h).
render::Reflectance player_reflectance(const Look &look, Vec3 rest);
// Of the ball at a point of the unit sphere.
render::Reflectance ball_reflectance(Vec3 unit, uint32_t key);

// Distance from the outline strokes of a one- or two-digit number, centred at 0; digits are 1 high.
double number_distance(int number, double x, double y);

} // namespace fvv::synth
