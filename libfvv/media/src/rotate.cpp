/* Turning by quarters. See fvv_media/image.h. */
#include "fvv_media/image.h"

#include "codecs.h"

#include <algorithm>

namespace fvv::media {

template <class Sample> BasicImage<Sample> rotate(BasicImage<Sample> image, int degrees) {
  check_image(image);
  if (degrees != 0 && degrees != 90 && degrees != 180 && degrees != 270)
    throw Error("a picture cannot be turned by " + std::to_string(degrees) +
                " degrees, expected 0, 90, 180 or 270");
  if (degrees == 0) return image;
  const bool on_its_side = degrees != 180;
  BasicImage<Sample> out = make_image<Sample>(on_its_side ? image.height : image.width,
                                              on_its_side ? image.width : image.height, image.channels, 0);
  const size_t channels = size_t(image.channels);
  for (size_t y = 0; y < out.height; y++)
    for (size_t x = 0; x < out.width; x++) {
      const size_t from_x = degrees == 90 ? y : degrees == 180 ? image.width - 1 - x : image.width - 1 - y;
      const size_t from_y = degrees == 90 ? image.height - 1 - x : degrees == 180 ? image.height - 1 - y : x;
      const Sample *from = &image.pixels[(from_y * image.width + from_x) * channels];
      std::copy_n(from, channels, &out.pixels[(y * out.width + x) * channels]);
    }
  return out;
}

template Image rotate(Image image, int degrees);
template DeepImage rotate(DeepImage image, int degrees);
template LinearImage rotate(LinearImage image, int degrees);

} // namespace fvv::media
