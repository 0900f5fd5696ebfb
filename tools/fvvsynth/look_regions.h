// The regions of a player's solid texture and the lines between them, over the rest figure (see field.cpp for
// the shapes that they colour).
#pragma once

#include "fvvsynth/look.h"

namespace fvv::synth {

constexpr double jersey_end = 0.927; // height of its lower edge
double armhole(double y);            // |x| beyond which an arm is bare
double neckline(Vec3 p);             // height above which the jersey ends at the neck

render::Reflectance head_reflectance(const Look &look, Vec3 p);
render::Reflectance jersey_reflectance(const Look &look, Vec3 p);
render::Reflectance arm_reflectance(const Look &look, Vec3 p);
render::Reflectance leg_reflectance(const Look &look, Vec3 p); // shorts, leg, sock and shoe

} // namespace fvv::synth
