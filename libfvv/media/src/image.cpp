// Files, formats and channels: what all still pictures have in common. See fvv_media/image.h.
#include "fvv_media/image.h"

#include "codecs.h"
#include "fvv_cxx/input_file.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <string_view>
#include <type_traits>

namespace fvv::media {

namespace {

// No picture within max_dimension needs more.
constexpr size_t max_file_size = size_t(1) << 30;
// Enough for the header of nearly every file; those with long profiles or thumbnails take another round.
constexpr size_t probe_size = 65536;

struct CloseFile {
  void operator()(FILE *file) const { fclose(file); }
};
using File = std::unique_ptr<FILE, CloseFile>;

File open_file(const std::string &path) {
  return File(fdopen(open_to_read(path), "rb"));
}

// Appends until bytes has wanted bytes or the file ends; returns whether the file has ended.
bool read_until(FILE *file, const std::string &path, size_t wanted, std::vector<uint8_t> &bytes) {
  while (bytes.size() < wanted) {
    const size_t before = bytes.size();
    const size_t piece = std::min(wanted - before, std::max(probe_size, before));
    bytes.resize(before + piece);
    const size_t got = fread(bytes.data() + before, 1, piece, file);
    bytes.resize(before + got);
    if (got < piece) {
      if (ferror(file)) throw Error(path, std::string("cannot be read: ") + strerror(errno));
      return true;
    }
  }
  return false;
}

ImageInfo probe_bytes(const uint8_t *bytes, size_t size, const std::string &name) {
  if (is_png(bytes, size)) return probe_png(bytes, size, name);
  if (is_jpeg(bytes, size)) return probe_jpeg(bytes, size, name);
  if (is_exr(bytes, size)) return probe_exr(bytes, size, name);
  if (is_webp(bytes, size)) return probe_webp(bytes, size, name);
  throw Error(name, why_no_picture(bytes, size));
}

struct OtherFormat {
  size_t at; // of the magic number
  std::string_view magic;
  const char *name;
};

using namespace std::string_view_literals;
// What textures are often in, besides; the more specific first.
constexpr OtherFormat other_formats[] = {
    {0, "\xabKTX 20"sv, "a KTX2 file ('ktx extract' makes a PNG file of it)"},
    {0, "\xabKTX 11"sv, "a KTX file"},
    {0, "DDS "sv, "a DDS file"},
    {0, "sB"sv, "a Basis file"},
    {4, "ftypavif"sv, "an AVIF file"},
    {4, "ftypavis"sv, "an AVIF file"},
    {4, "ftyphei"sv, "a HEIC file"},
    {4, "ftypmif1"sv, "a HEIF file"},
    {0, "\xff\x0a"sv, "a JPEG XL file"},
    {4, "JXL \r\n"sv, "a JPEG XL file"},
    {4, "jP  \r\n"sv, "a JPEG 2000 file"},
    {0, "GIF8"sv, "a GIF file"},
    {0, "II*\0"sv, "a TIFF file"},
    {0, "MM\0*"sv, "a TIFF file"},
    {0, "8BPS"sv, "a Photoshop file"},
    {0, "#?RADIANCE"sv, "a Radiance file"},
    {0, "BM"sv, "a BMP file"},
    {0, "version https://git-lfs"sv, "a pointer of Git LFS, in place of a picture"},
};

// BT.709, 16 fractional bits; the three add up to 65536, so that grey stays grey.
constexpr uint32_t luma_r = 13933, luma_g = 46871, luma_b = 4732;
static_assert(luma_r + luma_g + luma_b == 65536, "white must map to white");

// At most 65536 * 65535: 16 bits leave room for rounding in 32.
template <class Sample> uint32_t luma16(const Sample *rgb) {
  return luma_r * rgb[0] + luma_g * rgb[1] + luma_b * rgb[2];
}

template <class Sample> Sample grey_of(const Sample *rgb) {
  return Sample((luma16(rgb) + 32768) >> 16);
}
template <> float grey_of(const float *rgb) {
  return float((luma_r * double(rgb[0]) + luma_g * double(rgb[1]) + luma_b * double(rgb[2])) / 65536);
}

// White of this sample type over white of 8 bits.
template <class Sample> constexpr uint32_t step = std::numeric_limits<Sample>::max() / 255;

} // namespace

template <class Sample> BasicImage<Sample> with_samples(Image image) {
  if constexpr (sizeof(Sample) == 1) {
    return image;
  } else {
    BasicImage<Sample> out = make_image<Sample>(image.width, image.height, image.channels, 0);
    std::transform(image.pixels.begin(), image.pixels.end(), out.pixels.begin(), deep_sample);
    return out;
  }
}

template <class Sample> BasicImage<Sample> with_channels(BasicImage<Sample> image, int channels) {
  if (image.channels == channels) return image;
  BasicImage<Sample> out = make_image<Sample>(image.width, image.height, channels, 0);
  const size_t count = size_t(image.width) * image.height;
  if (channels == 1) {
    for (size_t i = 0; i < count; i++) out.pixels[i] = grey_of(&image.pixels[3 * i]);
  } else {
    for (size_t i = 0; i < count; i++) std::fill_n(&out.pixels[3 * i], 3, image.pixels[i]);
  }
  return out;
}

template Image with_samples(Image image);
template DeepImage with_samples(Image image);
template Image with_channels(Image image, int channels);
template DeepImage with_channels(DeepImage image, int channels);
template LinearImage with_channels(LinearImage image, int channels);

namespace {

// Luma in 1/256 of a code of 8 bits, rounded.
template <int channels, class Sample> int32_t luma_of(const Sample *pixel) {
  constexpr uint32_t unit = (channels == 1 ? 1 : 256) * step<Sample>;
  return int32_t(((channels == 1 ? 256u * *pixel : luma16(pixel)) + unit / 2) / unit);
}
template <int channels> int32_t luma_of(const float *pixel) {
  float display[channels];
  for (int c = 0; c < channels; c++) display[c] = srgb_of_half(pixel[c]);
  const double luma = channels == 1 ? double(display[0]) : double(grey_of(display));
  return int32_t(std::lround(std::clamp(luma, -16.0, 16.0) * 255 * 256));
}

template <int channels, class Sample>
LumaError sum_squares(const BasicImage<Sample> &a, const BasicImage<Sample> &b, const Image *mask) {
  LumaError error;
  const size_t count = size_t(a.width) * a.height;
  for (size_t i = 0; i < count; i++) {
    if (mask && mask->pixels[i] <= 127) continue;
    const int64_t difference =
        luma_of<channels>(&a.pixels[channels * i]) - luma_of<channels>(&b.pixels[channels * i]);
    error.squares += uint64_t(difference * difference);
    error.pixels++;
  }
  return error;
}

} // namespace

void check_dimensions(uint32_t width, uint32_t height, const std::string &name) {
  if (width == 0 || height == 0 || width > max_dimension || height > max_dimension)
    throw Error(name, "is " + std::to_string(width) + " x " + std::to_string(height) +
                          " pixels, expected 1 to " + std::to_string(max_dimension) + " each way");
}

template <class Sample> void check_image(const BasicImage<Sample> &image) {
  check_dimensions(image.width, image.height, "a picture");
  if (image.channels != 1 && image.channels != 3)
    throw Error("a picture has " + std::to_string(image.channels) + " channels, expected 1 or 3");
  const uint64_t size = uint64_t(image.width) * image.height * uint64_t(image.channels);
  if (image.pixels.size() != size)
    throw Error("a picture of " + std::to_string(image.width) + " x " + std::to_string(image.height) + " x " +
                std::to_string(image.channels) + " holds " + std::to_string(image.pixels.size()) +
                " samples, expected " + std::to_string(size));
}

void check_justified(uint64_t samples, uint64_t samples_per_byte, size_t size, const std::string &name) {
  if (samples / samples_per_byte > size)
    throw Error(name, "is cut or damaged: " + std::to_string(size) + " bytes cannot hold the " +
                          std::to_string(samples) + " samples that its header announces");
}

template <class Sample>
BasicImage<Sample> make_image(uint32_t width, uint32_t height, int channels,
                              typename BasicImage<Sample>::Value value) {
  check_dimensions(width, height, "a picture");
  if (channels != 1 && channels != 3)
    throw Error("a picture of " + std::to_string(channels) + " channels was requested, expected 1 or 3");
  BasicImage<Sample> image;
  image.width = width;
  image.height = height;
  image.channels = channels;
  const uint64_t size = uint64_t(width) * height * uint64_t(channels);
  if (size > std::numeric_limits<size_t>::max() / sizeof(Sample))
    throw Error("a picture is larger than memory can hold");
  image.pixels.assign(size_t(size), value);
  return image;
}

std::string why_no_picture(const uint8_t *bytes, size_t size) {
  if (!size) return "is empty";
  if (is_png(bytes, size) || is_jpeg(bytes, size) || is_exr(bytes, size) || is_webp(bytes, size)) return "";
  const std::string_view start(reinterpret_cast<const char *>(bytes), std::min(size, size_t(64)));
  for (const OtherFormat &format : other_formats)
    if (start.size() > format.at && start.substr(format.at, format.magic.size()) == format.magic)
      return std::string("is ") + format.name + ", expected PNG, JPEG, WebP or OpenEXR";
  return "is neither a PNG nor a JPEG nor a WebP nor an OpenEXR file";
}

ImageInfo probe_image(const std::string &path) {
  const File file = open_file(path);
  std::vector<uint8_t> bytes;
  for (size_t wanted = probe_size;; wanted *= 8) {
    const bool ended = read_until(file.get(), path, std::min(wanted, max_file_size), bytes);
    try {
      return probe_bytes(bytes.data(), bytes.size(), path);
    } catch (const Error &) {
      if (ended || wanted >= max_file_size || !why_no_picture(bytes.data(), bytes.size()).empty()) throw;
    }
  }
}

namespace {

void check_memory_of(const ImageInfo &info, const std::string &name, const MemoryLimit &limit) {
  const uint64_t pixel =
      info.format == ImageFormat::exr ? (4 + 3) * sizeof(float) : uint64_t(2 * 3 * sizeof(uint16_t));
  check_memory(name + ": decoding a picture of " + std::to_string(info.width) + " x " +
                   std::to_string(info.height) + " pixels",
               uint64_t(info.width) * info.height * pixel, limit);
}

} // namespace

ImageInfo probe_image(const uint8_t *bytes, size_t size, const std::string &name) {
  return probe_bytes(bytes, size, name);
}

void check_image_memory(const std::string &path, const MemoryLimit &limit) {
  if (limit.bytes != UINT64_MAX) check_memory_of(probe_image(path), path, limit);
}

void check_image_memory(const uint8_t *bytes, size_t size, const std::string &name,
                        const MemoryLimit &limit) {
  if (limit.bytes != UINT64_MAX) check_memory_of(probe_bytes(bytes, size, name), name, limit);
}

std::vector<uint8_t> read_file(const std::string &path) {
  const File file = open_file(path);
  std::vector<uint8_t> bytes;
  if (!read_until(file.get(), path, max_file_size, bytes))
    throw Error(path, "is larger than " + std::to_string(max_file_size >> 20) + " MiB");
  return bytes;
}

template <class Sample> BasicImage<Sample> read_image(const std::string &path, int channels) {
  const std::vector<uint8_t> bytes = read_file(path);
  return decode_image<Sample>(bytes.data(), bytes.size(), channels, path);
}

namespace {

template <class Sample>
BasicImage<Sample> decode_format(ImageFormat format, const uint8_t *bytes, size_t size,
                                 const std::string &name) {
  if constexpr (!std::is_same_v<Sample, float>) {
    if (format == ImageFormat::png) return decode_png<Sample>(bytes, size, name);
    if (format == ImageFormat::jpeg) return with_samples<Sample>(decode_jpeg(bytes, size, name));
    if (format == ImageFormat::webp) return with_samples<Sample>(decode_webp(bytes, size, name));
  }
  return decode_exr_picture<Sample>(bytes, size, name);
}

} // namespace

template <class Sample>
BasicImage<Sample> decode_image(const uint8_t *bytes, size_t size, int channels, const std::string &name) {
  if (channels != 1 && channels != 3)
    throw Error(name, std::to_string(channels) + " channels were requested, expected 1 or 3");
  const ImageInfo info = probe_bytes(bytes, size, name);
  // Codes are converted to grey before they become light, as for all other samples.
  if constexpr (std::is_same_v<Sample, float>)
    if (info.format != ImageFormat::exr)
      return linear_of(decode_image<uint16_t>(bytes, size, channels, name));
  return with_channels(decode_format<Sample>(info.format, bytes, size, name), channels);
}

template <class Sample>
LumaError luma_error(const BasicImage<Sample> &a, const BasicImage<Sample> &b, const Image *mask) {
  check_image(a);
  check_image(b);
  if (a.width != b.width || a.height != b.height || a.channels != b.channels)
    throw Error("pictures of different sizes or channels cannot be compared");
  if (mask) {
    check_image(*mask);
    if (mask->width != a.width || mask->height != a.height || mask->channels != 1)
      throw Error("a mask must be grey and of the size of the pictures");
  }
  return a.channels == 1 ? sum_squares<1>(a, b, mask) : sum_squares<3>(a, b, mask);
}

double LumaError::psnr() const {
  if (pixels == 0) throw Error("the mask leaves no pixel to compare");
  if (squares == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(255.0 * 255.0 * 65536.0 * double(pixels) / double(squares));
}

template void check_image(const Image &);
template void check_image(const DeepImage &);
template void check_image(const LinearImage &);
template Image make_image<uint8_t>(uint32_t, uint32_t, int, uint8_t);
template DeepImage make_image<uint16_t>(uint32_t, uint32_t, int, uint16_t);
template LinearImage make_image<float>(uint32_t, uint32_t, int, float);
template Image read_image<uint8_t>(const std::string &, int);
template DeepImage read_image<uint16_t>(const std::string &, int);
template LinearImage read_image<float>(const std::string &, int);
template Image decode_image<uint8_t>(const uint8_t *, size_t, int, const std::string &);
template DeepImage decode_image<uint16_t>(const uint8_t *, size_t, int, const std::string &);
template LinearImage decode_image<float>(const uint8_t *, size_t, int, const std::string &);
template LumaError luma_error(const Image &, const Image &, const Image *);
template LumaError luma_error(const DeepImage &, const DeepImage &, const Image *);
template LumaError luma_error(const LinearImage &, const LinearImage &, const Image *);

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
