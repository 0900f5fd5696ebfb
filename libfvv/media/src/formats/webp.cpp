// WebP by libwebp. A file has no least size: one colour takes a few bytes whatever its sides are, which
// check_dimensions alone bounds.
#include "media/src/codecs.h"

#include <webp/decode.h>

#include <cstring>

namespace fvv::media {
namespace {

WebPBitstreamFeatures features_of(const uint8_t *bytes, size_t size, const std::string &name) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes, size, &features) != VP8_STATUS_OK)
    throw Error(name, "the WebP file is cut or damaged in its header");
  if (features.has_animation) throw Error(name, "is an animated WebP file, expected one picture");
  check_dimensions(uint32_t(features.width), uint32_t(features.height), name);
  return features;
}

[[noreturn]] void fail(size_t size, const std::string &name) {
  throw Error(name, "the WebP file is cut or damaged: its " + std::to_string(size) +
                        " bytes do not decode to a whole picture");
}

} // namespace

bool is_webp(const uint8_t *bytes, size_t size) {
  return size >= 12 && !memcmp(bytes, "RIFF", 4) && !memcmp(bytes + 8, "WEBP", 4);
}

ImageInfo probe_webp(const uint8_t *bytes, size_t size, const std::string &name) {
  const WebPBitstreamFeatures features = features_of(bytes, size, name);
  return {uint32_t(features.width), uint32_t(features.height), 3, ImageFormat::webp};
}

Image decode_webp(const uint8_t *bytes, size_t size, const std::string &name) {
  const ImageInfo info = probe_webp(bytes, size, name);
  Image image = make_image(info.width, info.height, 3, 0);
  if (!WebPDecodeRGBInto(bytes, size, image.pixels.data(), image.pixels.size(), int(3 * info.width)))
    fail(size, name);
  return image;
}

RgbaImage decode_webp_rgba(const uint8_t *bytes, size_t size, const std::string &name) {
  const WebPBitstreamFeatures features = features_of(bytes, size, name);
  RgbaImage out = {
      uint32_t(features.width), uint32_t(features.height), static_cast<bool>(features.has_alpha), {}};
  std::vector<uint8_t> pixels(size_t(4) * out.width * out.height);
  if (!WebPDecodeRGBAInto(bytes, size, pixels.data(), pixels.size(), int(4 * out.width))) fail(size, name);
  out.pixels.reserve(pixels.size());
  for (const uint8_t value : pixels) out.pixels.push_back(deep_sample(value));
  return out;
}

} // namespace fvv::media
