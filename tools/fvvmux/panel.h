// fvvmux/panel.h: one camera's part of a contact sheet, and how panels make a sheet. Knows what is drawn in
// which order, and where; measures nothing.
#pragma once

#include "fvvmux/contact_sheet.h"

namespace fvv::mux {

// Sizes in pixels. All panels have the same; a picture stands in the middle of its panel, below the label.
struct Layout {
  uint32_t picture = 0; // longest side of a picture
  uint32_t scale = 1;   // of text
  uint32_t label = 0;   // height of the words above a picture
  uint32_t panel_width = 0, panel_height = 0;
  uint32_t columns = 0, rows = 0;
  uint32_t width = 0, height = 0; // of all panels
};

// As square as it gets, within largest_sheet; pictures are longest_side long or less.
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

} // namespace fvv::mux
