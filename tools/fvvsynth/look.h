// What things look like. Players and ball have solid textures (Perlin, "An image synthesizer", 1985) over the
// rest shape, so that no unwrapping is needed and no seam shows. The studio has painted rectangles: a floor
// of boards with lines, curtains and slats with lettered boards on them, bricks with banners above.
#pragma once

#include "fvv_render/picture.h"
#include "fvvsynth/body/body.h"
#include "fvvsynth/random.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace fvv::synth {

using render::Rgb;

struct Look {
  Rgb skin, hair, cloth, trim, shoe; // linear
  int number;                        // 0..99, on chest and back
  Hair style;
  bool headband;
  uint32_t key;      // of the noise
  bool fine = false; // for the figures of game/player.h
};

// Two players of different teams.
std::array<Look, 2> make_looks(Random &random);

// Reflectance of a player at a point of the rest figure (metres, see skeleton.h).
render::Reflectance player_reflectance(const Look &look, Vec3 rest);
// Of the ball at a point of the unit sphere.
render::Reflectance ball_reflectance(Vec3 unit, uint32_t key);

// Distance from the outline strokes of a one- or two-digit number, centred at 0; digits are 1 high.
double number_distance(int number, double x, double y);

// A painted rectangle, averaged in advance to all scales (mip map; Williams, "Pyramidal parametrics", 1983),
// so that large surroundings are drawn fast and without aliasing.
class Texture {
public:
  using Row = std::function<Rgb(double s)>;
  // width x height metres in squares of texel metres. paint(t) gives the painter of the row at t; the colour
  // at (s, t) is linear light. Rows are painted on several threads.
  Texture(double width, double height, double texel, const std::function<Row(double t)> &paint,
          uint32_t threads);
  // The mean over about footprint metres around (s, t), linear; the rim continues beyond the rectangle.
  Rgb at(double s, double t, double footprint) const;

private:
  struct Level {
    size_t columns, rows;
    std::vector<uint8_t> rgb; // display values: as fine in the dark as in the light
  };
  Rgb bilinear(const Level &level, double column, double row) const;

  double spacing; // of texels of the finest level, metres
  std::vector<Level> levels;
};

// Inner size of the studio, metres: x and z from minus half to plus half, y from 0.
constexpr double room_length = 18, room_width = 15, room_height = 7.5;

// Of the game's room, which has a ceiling.
constexpr double ceiling_height = 6.4;

// Light that the floor sends out at (x, z); linear.
render::Rgb floor_colour(double x, double z, uint32_t key);
// Of the ceiling of the game's room at (x, z), between its beams; linear.
render::Rgb ceiling_colour(double x, double z, uint32_t key);
// Of a wall at s metres along it and y metres up. wall: 0, 1 at the ends of x, 2, 3 at those of z.
render::Rgb wall_colour(int wall, double s, double y, uint32_t key);

} // namespace fvv::synth
