// JPEG by libjpeg-turbo's TurboJPEG, and the orientation in an Exif segment. The accurate DCT is used both
// ways: the fast one differs between machines with and without SIMD.
#include "media/src/codecs.h"

#include <turbojpeg.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

namespace fvv::media {

namespace {

// A TIFF structure, which states its own byte order.
struct Tiff {
  const uint8_t *bytes;
  size_t size;

  bool little() const { return bytes[0] == 'I'; }
  // 0 beyond the end.
  uint32_t number(size_t offset, size_t length) const {
    if (offset > size || size - offset < length) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < length; i++) value = value << 8 | bytes[offset + (little() ? length - 1 - i : i)];
    return value;
  }
};

uint8_t orientation_in(const Tiff &tiff) {
  if (tiff.size < 8 || (memcmp(tiff.bytes, "II*\0", 4) && memcmp(tiff.bytes, "MM\0*", 4))) return 1;
  const size_t directory = tiff.number(4, 4);
  const uint32_t entries = tiff.number(directory, 2);
  for (uint32_t i = 0; i < entries; i++) {
    const size_t entry = directory + 2 + size_t(12) * i;
    constexpr uint32_t orientation = 0x0112, short_type = 3;
    if (tiff.number(entry, 2) != orientation || tiff.number(entry + 2, 2) != short_type) continue;
    const uint32_t value = tiff.number(entry + 8, 2);
    return value >= 1 && value <= 8 ? uint8_t(value) : 1;
  }
  return 1;
}

// Tag 0x0112 of the first directory (CIPA DC-008 4.6.4 A), 1 to 8; 1, upright, when there is none or it
// cannot be read. bytes: the beginning of a JPEG file, untrusted; never read beyond size.
uint8_t exif_orientation(const uint8_t *bytes, size_t size) {
  constexpr uint8_t app1 = 0xe1, first_app = 0xe0, last_app = 0xef, comment = 0xfe;
  // Segments precede the picture: marker, length with its own two bytes.
  for (size_t at = 2; at + 4 <= size && bytes[at] == 0xff;) {
    const uint8_t marker = bytes[at + 1];
    const size_t length = size_t(bytes[at + 2]) << 8 | bytes[at + 3];
    const size_t body = at + 4, end = at + 2 + length;
    if (length < 2 || end > size) break;
    if (marker == app1 && end - body > 6 && !memcmp(bytes + body, "Exif\0", 6))
      return orientation_in({bytes + body + 6, end - body - 6});
    if ((marker < first_app || marker > last_app) && marker != comment && (marker < 0xc0 || marker > 0xdf))
      break;
    at = end;
  }
  return 1;
}

struct Destroy {
  void operator()(void *handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Destroy>;

struct Free {
  void operator()(unsigned char *bytes) const { tjFree(bytes); }
};

Handle checked(tjhandle handle) {
  if (!handle) throw std::bad_alloc();
  return Handle(handle);
}

[[noreturn]] void fail(tjhandle handle, const std::string &name) {
  throw Error(name, std::string("the JPEG file is cut or damaged: ") + tjGetErrorStr2(handle));
}

ImageInfo read_header(tjhandle handle, const uint8_t *bytes, size_t size, const std::string &name) {
  int width = 0, height = 0, subsampling = 0, colourspace = 0;
  if (tjDecompressHeader3(handle, bytes, size, &width, &height, &subsampling, &colourspace))
    fail(handle, name);
  check_dimensions(uint32_t(width), uint32_t(height), name);
  if (colourspace != TJCS_GRAY && colourspace != TJCS_YCbCr && colourspace != TJCS_RGB)
    throw Error(name, "the JPEG file is CMYK, expected grey, YCbCr or RGB");
  return {uint32_t(width), uint32_t(height), colourspace == TJCS_GRAY ? 1 : 3, ImageFormat::jpeg,
          exif_orientation(bytes, size)};
}

} // namespace

bool is_jpeg(const uint8_t *bytes, size_t size) {
  return size >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

ImageInfo probe_jpeg(const uint8_t *bytes, size_t size, const std::string &name) {
  return read_header(checked(tjInitDecompress()).get(), bytes, size, name);
}

Image decode_jpeg(const uint8_t *bytes, size_t size, const std::string &name) {
  const Handle handle = checked(tjInitDecompress());
  const ImageInfo info = read_header(handle.get(), bytes, size, name);
  // Every 8 x 8 block of the first component takes at least one bit.
  check_justified(uint64_t(info.width) * info.height, 8 * 64, size, name);
  Image image = make_image(info.width, info.height, info.channels, 0);
  if (tjDecompress2(handle.get(), bytes, size, image.pixels.data(), int(info.width), 0, int(info.height),
                    info.channels == 1 ? TJPF_GRAY : TJPF_RGB,
                    TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS))
    fail(handle.get(), name);
  return image;
}

std::vector<uint8_t> encode_jpeg(const Image &image, int quality, Subsampling subsampling) {
  check_image(image);
  if (quality < 1 || quality > 100)
    throw Error("JPEG quality is " + std::to_string(quality) + ", expected 1 to 100");
  const Handle handle = checked(tjInitCompress());
  const bool grey = image.channels == 1;
  unsigned char *bytes = nullptr;
  unsigned long size = 0;
  const int result = tjCompress2(handle.get(), image.pixels.data(), int(image.width), 0, int(image.height),
                                 grey ? TJPF_GRAY : TJPF_RGB, &bytes, &size,
                                 grey                                 ? TJSAMP_GRAY
                                 : subsampling == Subsampling::yuv420 ? TJSAMP_420
                                                                      : TJSAMP_444,
                                 quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, Free> owner(bytes);
  if (result)
    throw Error(std::string("a picture cannot be written as JPEG: ") + tjGetErrorStr2(handle.get()));
  return {bytes, bytes + size};
}

} // namespace fvv::media
