// A painted rectangle, averaged in advance to all scales (mip map; Williams, "Pyramidal parametrics", 1983),
// so that large surroundings are drawn fast and without aliasing. Knows colours; knows no scene.
#pragma once

#include "fvv_render/picture.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace fvv::synth {

using render::Rgb;

class Texture {
public:
  using Row = std::function<Rgb(double s)>;
  // width x height metres in squares of texel metres. paint(t) gives the painter of the row at t; the colour
  // at (s, t) is linear light. Rows are painted on several threads.
  Texture(double width, double height, double texel, const std::function<Row(double t)> &paint,
          uint32_t threads);
  // The mean over about footprint metres around (s, t), linear; the rim goes on beyond the rectangle.
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

} // namespace fvv::synth
