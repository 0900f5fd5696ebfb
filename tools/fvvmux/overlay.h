// fvvmux/overlay.h: marks on a picture that show on any background. Knows colours, lines and pixels; knows no
// camera and no mesh.
#pragma once

#include "fvv_media/image.h"

#include <array>

namespace fvv::mux {

struct Colour {
  uint8_t red, green, blue;
};

// Told apart by people of any colour vision: of the palette of Okabe and Ito ("Color universal design",
// 2008).
constexpr Colour orange = {230, 159, 0}, sky_blue = {86, 180, 233}, vermillion = {213, 94, 0},
                 bluish_green = {0, 158, 115}, blue = {0, 114, 178}, yellow = {240, 228, 66};
constexpr Colour light = {255, 255, 255}, dark = {0, 0, 0}, paper = {26, 26, 28}, grey = {110, 110, 112};

// Pixels, right and bottom excluded.
struct Box {
  uint32_t left, top, right, bottom;
};
// Pixels, the centre of the top left one at (0.5, 0.5).
using Pixel = std::array<double, 2>;

// Pictures are RGB; alpha is how much of the mark is seen, 0..1. What lies outside of the picture is left
// out.
void blend(media::Image &image, uint32_t x, uint32_t y, Colour colour, double alpha);
void fill(media::Image &image, const Box &box, Colour colour, double alpha);
// The border of a box, inside of it.
void frame(media::Image &image, const Box &box, uint32_t thickness, Colour colour);
// shares: grey, of the picture's size: how much of every pixel is meant, 255 is all.
void tint(media::Image &image, const media::Image &shares, Colour colour, double alpha);
// Straight lines that are drawn as one: with a dark rim of a pixel around all of them, and where they cross
// or meet no stronger than elsewhere. A point is a line from there to itself: a disc.
class Lines {
public:
  Lines(uint32_t width, uint32_t height); // of the picture
  // core: width without the rim. Lines with an end farther outside than the picture's own size are left out.
  void add(Pixel a, Pixel b, double core);
  void draw(media::Image &image, Colour colour, double alpha) const;

private:
  void cover(std::vector<float> &share, Pixel a, Pixel b, double radius) const;

  uint32_t width, height;
  std::vector<float> inner, outer; // how much of each pixel core and rim cover, 0..1
};
// Copies a picture to x, y of a larger one.
void paste(media::Image &image, const media::Image &part, uint32_t x, uint32_t y);

} // namespace fvv::mux
