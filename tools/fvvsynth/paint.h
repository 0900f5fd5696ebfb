// What the surfaces of the studio look like: a floor of boards with painted lines, curtains and slats with
// lettered boards in front of them, bricks with banners above. Knows places on them; knows no cameras.
#pragma once

#include "fvv_render/picture.h"

namespace fvv::synth {

// Inner size of the studio, metres: x and z from minus half to plus half, y from 0.
constexpr double room_length = 18, room_width = 15, room_height = 7.5;

// Light that the floor sends out at (x, z); linear.
render::Rgb floor_colour(double x, double z, uint32_t key);
// Of a wall at s metres along it and y metres up. wall: 0, 1 at the ends of x, 2, 3 at those of z.
render::Rgb wall_colour(int wall, double s, double y, uint32_t key);

} // namespace fvv::synth
