// fvvmux/packing.h: many sets of rectangles, each packed into a frame of one size. Knows numbers only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fvv::mux {

// In units of FVV_TILE_ALIGNMENT pixels.
struct Cell {
  uint32_t width, height;
  uint32_t x = 0, y = 0; // of the left upper corner, once it is packed
};

struct FrameSize {
  uint32_t width, height;
};
struct FrameBound {
  uint32_t width, height;
  uint64_t area = UINT64_MAX;
};

// Places the cells of every set so that all sets fit one frame, the smallest by area that was found: of all
// widths that make it at most four times as long as it is short, each set by a skyline (stb_rect_pack.h) that
// prefers the lowest place, and by one that prefers the tightest; the nearest to a square of equal ones.
// least: of the sides; most: of the frame. Without a fit, or without cells: {0, 0}, and cells are as they
// were. The same on every machine.
FrameSize pack(std::vector<std::vector<Cell>> &sets, uint32_t least, const FrameBound &most);

} // namespace fvv::mux
