#include "fvvmux/label.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stb/stb_easy_font.h>

namespace fvv::mux {

namespace {

// As stb_easy_font writes them.
struct Vertex {
  float x, y, z;
  unsigned char colour[4];
};
constexpr size_t quads_per_character = 32; // more than any glyph has

std::string printable(const std::string &text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xc0) == 0x80) continue; // the rest of a character of several bytes
    out += byte >= 32 && byte < 127 ? c : '?';
  }
  return out;
}

} // namespace

uint32_t text_width(const std::string &text, uint32_t scale) {
  std::string copy = printable(text);
  return static_cast<uint32_t>(std::max(0, stb_easy_font_width(copy.data()))) * scale;
}

std::string shortened(const std::string &text, uint32_t scale, uint32_t width) {
  std::string kept = printable(text);
  if (text_width(kept, scale) <= width) return kept;
  while (!kept.empty() && text_width(kept + "...", scale) > width) kept.pop_back();
  return kept + "...";
}

void draw_text(media::Image &image, uint32_t x, uint32_t y, const std::string &text, uint32_t scale,
               Colour colour) {
  std::string copy = printable(text);
  std::vector<Vertex> corners(4 * quads_per_character * (copy.size() + 1));
  const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Vertex)));
  const auto at = [&](uint32_t from, float offset) {
    return from + static_cast<uint32_t>(std::lround(std::max(0.0f, offset))) * scale;
  };
  for (int i = 0; i < quads; i++) {
    const Vertex &low = corners[4 * static_cast<size_t>(i)], &high = corners[4 * static_cast<size_t>(i) + 2];
    fill(image, {at(x, low.x), at(y, low.y), at(x, high.x), at(y, high.y)}, colour, 1);
  }
}

} // namespace fvv::mux
