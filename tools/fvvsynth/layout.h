// Charts packed into one square picture, and the surface with the texture coordinates that this gives. Knows
// texels; knows no colours.
#pragma once

#include "fvvsynth/charts.h"

namespace fvv::synth {

// Texels between a chart and the edge of its rectangle: enough for bilinear sampling, and for 4:2:0 chroma.
constexpr uint32_t chart_margin = 4;

struct ChartBox { // of a chart, in texels from the top left corner of the picture, margins included
  uint32_t x, y, width, height;
};

struct Layout {
  uint32_t size;                // texels of each side of the picture
  double density;               // texels per metre of the charts' planes, the same for all
  std::vector<ChartBox> places; // of the charts, which do not overlap
  // The surface, opened at the borders of charts: of each vertex the one that it is a copy of. First come all
  // vertices of the surface in their order, behind them further copies.
  std::vector<uint32_t> source;
  std::vector<uint32_t> faces; // as the surface's, of these vertices
  std::vector<Flat> texels;    // of each vertex: x to the right and y down from the top left corner
};

// As dense as it fits. Throws std::invalid_argument when size is too small for the margins alone, or above
// 16384.
Layout lay_out(const Surface &surface, const std::vector<Chart> &charts, uint32_t size);

} // namespace fvv::synth
