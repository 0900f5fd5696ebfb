#include "fvvmux/packing.h"

#include "packing/rect_pack.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

constexpr uint32_t longest = 4; // times the other side

uint64_t area_of(const std::vector<Cell> &cells) {
  uint64_t area = 0;
  for (const Cell &cell : cells) area += uint64_t(cell.width) * cell.height;
  return area;
}

// The height that a set takes in a width, 0 when it is more than most; places: where cells go.
uint32_t height_in(const std::vector<Cell> &cells, uint32_t width, uint32_t most, std::vector<Cell> &places) {
  uint32_t best = 0;
  for (const int heuristic : {STBRP_HEURISTIC_Skyline_BL_sortHeight, STBRP_HEURISTIC_Skyline_BF_sortHeight}) {
    std::vector<stbrp_node> nodes(width);
    std::vector<stbrp_rect> rectangles(cells.size());
    for (size_t i = 0; i < cells.size(); i++)
      rectangles[i] = {int(i), int(cells[i].width), int(cells[i].height), 0, 0, 0};
    stbrp_context context;
    stbrp_init_target(&context, int(width), int(most), nodes.data(), int(width));
    stbrp_setup_heuristic(&context, heuristic);
    if (!stbrp_pack_rects(&context, rectangles.data(), int(rectangles.size()))) continue;
    uint32_t height = 0;
    for (const stbrp_rect &r : rectangles) height = std::max(height, uint32_t(r.y + r.h));
    if (best && height >= best) continue;
    best = height;
    places = cells;
    for (size_t i = 0; i < places.size(); i++) {
      places[i].x = uint32_t(rectangles[i].x);
      places[i].y = uint32_t(rectangles[i].y);
    }
  }
  return best;
}

bool better(const FrameSize &a, const FrameSize &b) {
  const uint64_t area = uint64_t(a.width) * a.height, other = uint64_t(b.width) * b.height;
  if (!other || area != other) return !other || area < other;
  return std::max(a.width, a.height) < std::max(b.width, b.height);
}

} // namespace

FrameSize pack(std::vector<std::vector<Cell>> &sets, uint32_t least, const FrameBound &most) {
  uint64_t area = 0;
  uint32_t widest = least, tallest = least;
  // The largest set first: most widths end there.
  std::vector<size_t> order;
  for (size_t i = 0; i < sets.size(); i++) {
    order.push_back(i);
    area = std::max(area, area_of(sets[i]));
    for (const Cell &cell : sets[i]) {
      widest = std::max(widest, cell.width);
      tallest = std::max(tallest, cell.height);
    }
  }
  if (!area || area > most.area) return {0, 0};
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return area_of(sets[a]) > area_of(sets[b]); });
  FrameSize best = {0, 0};
  std::vector<std::vector<Cell>> placed, trial(sets.size());
  // No frame that is smaller than twice the cells needs more: the skyline wastes less than a half.
  const uint32_t last = std::max(
      widest, uint32_t(std::min<double>(most.width, std::ceil(std::sqrt(2.0 * longest * double(area))))));
  for (uint32_t width = widest; width <= std::min(last, most.width); width++) {
    uint64_t limit = std::min<uint64_t>(most.height, std::max(longest * width, tallest));
    limit = std::min(limit, most.area / width);
    if (best.height) limit = std::min<uint64_t>(limit, uint64_t(best.width) * best.height / width);
    uint32_t height = least;
    for (const size_t i : order) {
      const uint32_t own = limit ? height_in(sets[i], width, uint32_t(limit), trial[i]) : 0;
      height = own ? std::max(height, own) : 0;
      if (!height) break;
    }
    if (!height || !better({width, height}, best)) continue;
    best = {width, height};
    placed = trial;
  }
  if (best.height) sets = std::move(placed);
  return best;
}

} // namespace fvv::mux
