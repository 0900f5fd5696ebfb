// Camera and frame numbers in the top left corner of a picture. Knows pictures only.
#pragma once

#include "fvv_render/picture.h"

#include <string>

namespace fvv::synth {

// "03 0012": at least two digits for the camera and four for the frame.
std::string label_text(uint16_t camera, size_t frame);

// Where a label's text lies, in pixels: its characters are cells of cell_width x height, from left on.
struct LabelPlace {
  double left, top, cell_width, height;
};
LabelPlace label_place(const render::Picture &picture);

// Draws white digits on black, as far as the picture reaches.
void draw_label(render::Picture &picture, uint16_t camera, size_t frame);

} // namespace fvv::synth
