#include "fvvsynth/label.h"

#include "fvvsynth/look.h"

#include <algorithm>
#include <cstdio>

namespace fvv::synth {

std::string label_text(uint16_t camera, size_t frame) {
  char text[40];
  std::snprintf(text, sizeof text, "%02u %04zu", unsigned(camera), frame);
  return text;
}

LabelPlace label_place(const render::Picture &picture) {
  const double height = std::max(10.0, picture.height / 22.0);
  return {0.7 * height, 0.7 * height, 0.74 * height, height};
}

void draw_label(render::Picture &picture, uint16_t camera, size_t frame) {
  const std::string text = label_text(camera, frame);
  const LabelPlace place = label_place(picture);
  constexpr double margin = 0.35, stroke = 0.075; // of the height
  const double right = place.left + place.cell_width * double(text.size()), edge = margin * place.height;
  const auto end = [](double at, uint32_t side) { return std::min(side, uint32_t(at) + 1); };
  for (uint32_t y = uint32_t(place.top - edge); y < end(place.top + place.height + edge, picture.height); y++)
    for (uint32_t x = uint32_t(place.left - edge); x < end(right + edge, picture.width); x++) {
      const double along = (x + 0.5 - place.left) / place.cell_width;
      const size_t cell = size_t(std::clamp(along, 0.0, double(text.size()) - 0.001));
      double distance = 1e9; // from the stroke, in pixels
      if (text[cell] != ' ')
        distance =
            (number_distance(text[cell] - '0', (along - double(cell) - 0.5) * place.cell_width / place.height,
                             0.5 - (y + 0.5 - place.top) / place.height) -
             stroke) *
            place.height;
      const double white = std::clamp(0.5 - distance, 0.0, 1.0);
      for (size_t i = 0; i < 3; i++)
        picture.rgb[3 * (size_t(y) * picture.width + x) + i] = uint8_t(235 * white + 16 * (1 - white) + 0.5);
    }
}

} // namespace fvv::synth
