/* JPEG by libjpeg-turbo's TurboJPEG. The accurate DCT is asked for both ways: the fast one differs between
 * machines with and without SIMD. */
#include "codecs.h"
#include "exif.h"

#include <turbojpeg.h>

#include <memory>

namespace fvv::media {
namespace {

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
