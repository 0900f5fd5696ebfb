// Pictures in PNG, JPEG and OpenEXR. A picture has the pixels that its size says, or Error is thrown.
#include "../fuzz.h"

#include "fvv_cxx/error.h"
#include "fvv_media/exr.h"
#include "fvv_media/image.h"

namespace {

// Decoding takes time by the declared size, which a few bytes may exaggerate: large pictures are left out.
bool is_small(const uint8_t *data, size_t size) {
  const uint8_t png[] = {0x89, 'P', 'N', 'G'};
  if (size >= 24 && !std::memcmp(data, png, 4))
    return !data[16] && !data[17] && !data[20] && !data[21] && data[18] < 4 && data[22] < 4;
  for (size_t at = 2; at + 9 < size; at++)
    if (data[at] == 0xff && data[at + 1] >= 0xc0 && data[at + 1] <= 0xcf &&
        (data[at + 5] >= 4 || data[at + 7] >= 4))
      return false;
  return true;
}

template <class Sample> void decode(const fuzz::Bytes &bytes, int channels) {
  const fvv::media::BasicImage<Sample> image =
      fvv::media::decode_image<Sample>(bytes.data(), bytes.size(), channels, "input");
  fuzz::expect(image.channels == channels &&
                   image.pixels.size() == size_t(image.width) * image.height * size_t(channels),
               "a picture has its pixels");
}

void decode_any(const uint8_t *data, size_t size) {
  if (!is_small(data, size)) return;
  const fuzz::Bytes bytes(data, data + size);
  const uint32_t options = fuzz::digest(data, size);
  const int channels = options & 1 ? 1 : 3;
  try {
    if (options & 2)
      decode<uint16_t>(bytes, channels);
    else if (options & 4)
      decode<float>(bytes, channels);
    else
      decode<uint8_t>(bytes, channels);
  } catch (const fvv::Error &) {}
}

} // namespace

FVV_FUZZ_TARGET(png, fuzz::Form::png) {
  decode_any(data, size);
}

FVV_FUZZ_TARGET(jpeg, fuzz::Form::bytes) {
  decode_any(data, size);
}

FVV_FUZZ_TARGET(exr, fuzz::Form::bytes) {
  const fuzz::Bytes bytes(data, data + size);
  try {
    const fvv::media::FloatImage image = fvv::media::decode_exr(bytes.data(), bytes.size(), "input");
    fuzz::expect(image.samples.size() == size_t(image.width) * image.height * image.channels.size(),
                 "a picture has its samples");
  } catch (const fvv::Error &) {}
}
