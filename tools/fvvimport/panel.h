// Marks on a picture that show on any background.
#pragma once

#include "fvv/calibration.h"
#include "fvv_geometry/outline.h"
#include "fvv_media/image.h"
#include "fvvimport/sheet.h"

#include <array>
#include <string>
#include <vector>

namespace fvv::fvvimport {

struct Colour {
  uint8_t red, green, blue;
};

// Distinguishable with any colour vision: of the palette of Okabe and Ito ("Color universal design",
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

// Pictures are RGB; alpha: opacity of the mark, 0..1. Parts outside of the picture are not drawn.
void blend(media::Image &image, uint32_t x, uint32_t y, Colour colour, double alpha);
void fill(media::Image &image, const Box &box, Colour colour, double alpha);
// The border of a box, inside of it.
void frame(media::Image &image, const Box &box, uint32_t thickness, Colour colour);
// shares: grey, of the picture's size: the covered part of every pixel, 255 for all.
void tint(media::Image &image, const media::Image &shares, Colour colour, double alpha);
// Straight lines that are drawn as one: with a dark rim of a pixel around all of them, and not stronger where
// they cross or meet. A point is a line from there to itself: a disc.
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

// All lengths in pixels; scale, 1 or more, is the size of the font's own pixel. Characters outside of
// printable ASCII are drawn as one question mark each.
constexpr uint32_t line_height(uint32_t scale) {
  return 12 * scale;
}
uint32_t text_width(const std::string &text, uint32_t scale);
// As much of text as fits into width, with "..." for the rest.
std::string shortened(const std::string &text, uint32_t scale, uint32_t width);
// x, y: the top left corner. Parts outside of the picture are not drawn.
void draw_text(media::Image &image, uint32_t x, uint32_t y, const std::string &text, uint32_t scale,
               Colour colour);

// Draws the outline of a surface into a picture of the camera, as a light line with dark rims.
void draw_outline(const geometry::ViewedSurface &surface, const fvv_camera &camera, media::Image &image);

constexpr double camera_dot = 4; // across, pixels

// Length of the axes and side of the grid's squares: 1, 2 or 5 times a power of ten, so that the axes are
// about a fifth of the distance from the farthest camera to the point that all look at; metres, or units of
// the capture.
double guide_step(const std::vector<fvv_camera> &cameras);

// image is a picture of cameras[which], of any size. All lines follow the lens.
//
// From the world's origin, with a letter at each end.
void draw_axes(const std::vector<fvv_camera> &cameras, size_t which, media::Image &image);
// Squares on the plane through the origin across up (FVV_UP_...), around the point that the cameras look at.
// Nothing when up is unknown.
void draw_ground(const std::vector<fvv_camera> &cameras, size_t which, uint8_t up, media::Image &image);
// A dot with its identifier for every other camera in the picture.
void draw_cameras(const std::vector<fvv_camera> &cameras, size_t which, media::Image &image);

// Sizes in pixels. All panels are equal; a picture is in the middle of its panel, below the label.
struct Layout {
  uint32_t picture = 0; // longest side of a picture
  uint32_t scale = 1;   // of text
  uint32_t label = 0;   // height of the words above a picture
  uint32_t panel_width = 0, panel_height = 0;
  uint32_t columns = 0, rows = 0;
  uint32_t width = 0, height = 0; // of all panels
};

// As square as possible, within largest_sheet; pictures are at most longest_side long.
Layout arrange_panels(const std::vector<fvv_camera> &cameras, uint32_t longest_side);
// Of a camera's picture in its panel: width and height.
std::array<uint32_t, 2> picture_size(const fvv_camera &camera, const Layout &layout);

// The picture with everything over it. picture and mask may be empty; cover: of the camera's size, empty
// without a mask.
media::Image draw_picture(const SheetInput &input, const Subject &subject, size_t camera,
                          const Layout &layout, const media::Image &picture, const media::Image &mask,
                          const std::vector<uint8_t> &cover);
// All of it. pictures[i] belongs to report.cameras[i].
media::Image draw_sheet(const SheetInput &input, const SheetReport &report, const Layout &layout,
                        const std::vector<media::Image> &pictures);

} // namespace fvv::fvvimport
