// fvvmux/label.h: words on a picture. Knows a font and pixels; knows nothing of what the words say.
//
// The font is that of stb_easy_font: its glyphs are a few rectangles each, compiled in, the same on every
// machine. FreeType would write more beautifully, but with whatever font file the machine has, so that
// neither the result nor that there is one could be relied on.
#pragma once

#include "fvvmux/overlay.h"

#include <string>

namespace fvv::mux {

// All lengths in pixels; scale, 1 or more, is the size of the font's own pixel. Characters outside of
// printable ASCII are drawn as one question mark each.
constexpr uint32_t line_height(uint32_t scale) {
  return 12 * scale;
}
uint32_t text_width(const std::string &text, uint32_t scale);
// As much of text as fits into width, with "..." for the rest.
std::string shortened(const std::string &text, uint32_t scale, uint32_t width);
// x, y: the top left corner. What lies outside of the picture is left out.
void draw_text(media::Image &image, uint32_t x, uint32_t y, const std::string &text, uint32_t scale,
               Colour colour);

} // namespace fvv::mux
