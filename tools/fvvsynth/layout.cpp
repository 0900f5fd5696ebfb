#include "fvvsynth/layout.h"

#include "fvv_geometry/rect_pack.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace fvv::synth {

namespace {

constexpr uint32_t most_size = 16384;

struct Bounds {
  Flat low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Flat high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

Bounds bounds(const Surface &surface, const Chart &chart) {
  Bounds result;
  for (const uint32_t face : chart.faces)
    for (size_t c = 0; c < 3; c++) {
      const Flat p = chart.flat(surface.vertices[surface.faces[3 * face + c]]);
      for (size_t axis = 0; axis < 2; axis++) {
        result.low[axis] = std::min(result.low[axis], p[axis]);
        result.high[axis] = std::max(result.high[axis], p[axis]);
      }
    }
  return result;
}

// The charts' places at a density; nothing when they do not fit.
std::vector<ChartBox> pack(const std::vector<Bounds> &charts, double density, uint32_t size) {
  std::vector<stbrp_rect> rects;
  for (const Bounds &one : charts) {
    double side[2];
    for (size_t axis = 0; axis < 2; axis++)
      side[axis] = std::ceil((one.high[axis] - one.low[axis]) * density) + 2 * chart_margin;
    if (side[0] > size || side[1] > size) return {};
    stbrp_rect rect = {};
    rect.id = int(rects.size());
    rect.w = stbrp_coord(side[0]);
    rect.h = stbrp_coord(side[1]);
    rects.push_back(rect);
  }
  std::vector<stbrp_node> nodes(size);
  stbrp_context context;
  stbrp_init_target(&context, int(size), int(size), nodes.data(), int(size));
  if (!stbrp_pack_rects(&context, rects.data(), int(rects.size()))) return {};
  std::vector<ChartBox> places;
  for (const stbrp_rect &rect : rects)
    places.push_back({uint32_t(rect.x), uint32_t(rect.y), uint32_t(rect.w), uint32_t(rect.h)});
  return places;
}

} // namespace

Layout lay_out(const Surface &surface, const std::vector<Chart> &charts, uint32_t size) {
  std::vector<Bounds> all;
  for (const Chart &chart : charts) all.push_back(bounds(surface, chart));
  Layout layout;
  layout.size = size;
  // In whole texels per metre: the bisection ends where no rounding decides.
  uint32_t fits = 0, fails = most_size;
  while (size <= most_size && fits + 1 < fails) {
    const uint32_t density = fits + (fails - fits) / 2;
    std::vector<ChartBox> places = pack(all, density, size);
    (places.empty() ? fails : fits) = density;
    if (!places.empty()) layout.places = std::move(places);
  }
  if (!fits)
    throw std::invalid_argument("an atlas of " + std::to_string(size) + " x " + std::to_string(size) +
                                " texels cannot hold " + std::to_string(charts.size()) + " charts");
  layout.density = fits;

  const size_t vertex_count = surface.vertices.size();
  layout.faces.resize(surface.faces.size());
  layout.texels.resize(vertex_count);
  for (size_t i = 0; i < vertex_count; i++) layout.source.push_back(uint32_t(i));
  // Which chart a vertex was last seen in, and as which copy: charts come one after the other.
  constexpr size_t none = SIZE_MAX;
  std::vector<size_t> chart_of(vertex_count, none);
  std::vector<uint32_t> copy_of(vertex_count);
  for (size_t i = 0; i < charts.size(); i++)
    for (const uint32_t face : charts[i].faces)
      for (size_t c = 0; c < 3; c++) {
        const uint32_t vertex = surface.faces[3 * face + c];
        if (chart_of[vertex] != i) {
          const Flat p = charts[i].flat(surface.vertices[vertex]);
          const Flat texel = {layout.places[i].x + chart_margin + (p[0] - all[i].low[0]) * layout.density,
                              layout.places[i].y + chart_margin + (all[i].high[1] - p[1]) * layout.density};
          if (chart_of[vertex] == none) {
            copy_of[vertex] = vertex;
            layout.texels[vertex] = texel;
          } else {
            copy_of[vertex] = uint32_t(layout.source.size());
            layout.source.push_back(vertex);
            layout.texels.push_back(texel);
          }
          chart_of[vertex] = i;
        }
        layout.faces[3 * face + c] = copy_of[vertex];
      }
  return layout;
}

} // namespace fvv::synth
