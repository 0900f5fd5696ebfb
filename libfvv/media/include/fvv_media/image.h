// Still pictures: reading PNG, JPEG, WebP and OpenEXR files, writing PNG and JPEG, scaling, comparing.
// Samples have 8 or 16 bits, or are linear light. Samples are taken as sRGB: gAMA chunks and ICC profiles are
// ignored, and so is Exif orientation, because calibration refers to rows and columns as they are stored.
#pragma once

#include "fvv_cxx/error.h"
#include "fvv_cxx/values.h"
#include "fvv_media/memory_limit.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fvv::media {

// Largest width or height that is read or written, as the default of fvv_limits.max_dimension.
constexpr uint32_t max_dimension = 16384;

// Templates over SampleType of BasicImage (fvv_cxx/values.h) exist for uint8_t, uint16_t and, but for PNG,
// float; uint8_t is the default where no argument determines it.

// A picture of one value. Error when a side is 0 or above max_dimension or channels is not 1 or 3.
template <class SampleType = uint8_t>
BasicImage<SampleType> make_image(uint32_t width, uint32_t height, int channels,
                                  typename BasicImage<SampleType>::Value value);

// A sample of 8 bits in 16.
constexpr uint16_t deep_sample(uint8_t value) {
  return uint16_t(257 * value);
}
// A picture of 8 bits in 8, or in 16.
template <class SampleType> BasicImage<SampleType> with_samples(Image image);

enum class ImageFormat { png, jpeg, exr, webp };

struct ImageInfo {
  uint32_t width, height;
  int channels; // 1 or 3: what the file holds, alpha not counted, a palette counted as RGB
  ImageFormat format;
  uint8_t orientation = 1; // what Exif in a JPEG file says, 1 (upright) to 8; read_image ignores it
};

// Empty for bytes that begin as a file of a format that is read here; else what they are, "is a BMP file,
// expected ...".
std::string why_no_picture(const uint8_t *bytes, size_t size);

// From the file's header alone; the format by content, never by the name's extension.
ImageInfo probe_image(const std::string &path);
// The same from memory; name begins error messages.
ImageInfo probe_image(const uint8_t *bytes, size_t size, const std::string &name);

// MemoryError when read_image or decode_image would take more than limit, by the file's header: RGB of 16
// bits and its copy in other samples, of OpenEXR four channels and three of float.
void check_image_memory(const std::string &path, const MemoryLimit &limit);
void check_image_memory(const uint8_t *bytes, size_t size, const std::string &name, const MemoryLimit &limit);

// channels: 1 or 3, converted to if the file holds the other. Grey from RGB is BT.709 luma of the samples.
// PNG: every colour type, depth and interlacing; 16 bits are rounded to 8 for an Image, and all others become
// 16, exactly, for a DeepImage; alpha is dropped, colour under it stays. JPEG: grey, YCbCr, RGB; everything
// that libjpeg only warns about (above all, truncated files) is an error. WebP: lossy and lossless, of 8
// bits; alpha is dropped, animations are an error. OpenEXR: R G B or Y as decode_exr reads them (exr.h),
// linear light with the primaries of Rec.709 and 1.0 for white, clipped to 0 ... 1 and brought to the sRGB
// curve (srgb.h); A is dropped. Other chromaticities, NaN and infinities are errors. A LinearImage has the
// values of an OpenEXR file as they are, and all others by the inverse of the curve, from their 16 bits.
template <class SampleType = uint8_t>
BasicImage<SampleType> read_image(const std::string &path, int channels);

// The same from memory; name begins error messages.
template <class SampleType = uint8_t>
BasicImage<SampleType> decode_image(const uint8_t *bytes, size_t size, int channels, const std::string &name);

// small: libpng's defaults. fast: Paeth's filter and run lengths with Huffman codes alone, about six times as
// fast; files of drawn pictures are up to a sixth larger, of noisy ones no larger.
enum class PngEffort { small, fast };

// A whole PNG file, grey or RGB, of 8 or 16 bits as the image has, not interlaced, marked sRGB.
template <class SampleType>
std::vector<uint8_t> encode_png(const BasicImage<SampleType> &image, PngEffort effort = PngEffort::small);

enum class Subsampling { yuv420, yuv444 };

// A whole JFIF file, baseline. quality: libjpeg's 1 ... 100. Grey pictures have no chroma to subsample.
std::vector<uint8_t> encode_jpeg(const Image &image, int quality, Subsampling subsampling);

// area: every output sample is the mean of the source rectangle that it covers, exact in integers and
// mean-preserving; enlarged pictures show blocks. lanczos: sinc windowed by its own main lobe, three lobes to
// each side (Turkowski, "Filters for Common Resampling Tasks", Graphics Gems, 1990), weights rounded to
// 1/16384; sharper and without aliasing, but values beside an edge overshoot by up to a tenth of it. Results
// are rounded once, clamped, and equal on every machine.
enum class Filter { area, lanczos };

template <class SampleType>
BasicImage<SampleType> scale(const BasicImage<SampleType> &image, uint32_t width, uint32_t height,
                             Filter filter = Filter::area);

// Turned clockwise by 0, 90, 180 or 270 degrees.
template <class SampleType> BasicImage<SampleType> rotate(BasicImage<SampleType> image, int degrees);

// The rectangle of image. Error unless it lies inside and is not empty.
template <class SampleType>
BasicImage<SampleType> crop(const BasicImage<SampleType> &image, uint32_t x, uint32_t y, uint32_t width,
                            uint32_t height);

// Sum of squared differences of BT.709 luma (of the samples as they are, to 1/256 of a code of 8 bits) over
// the pixels whose mask is > 127, and their number. Sums of several pictures may be added before asking for
// the PSNR. A code is 1/255 of white for every sample type: a DeepImage's luma is divided by 257, so that
// figures of 8 and of more bits can be compared, and an Image widened to 16 bits has the same error. Linear
// light is rounded to half floats and brought to srgb_of_linear (srgb.h), which continues beyond white; luma
// beyond 16 times white counts as that.
struct LumaError {
  uint64_t squares = 0; // unit: 1/65536 of a code squared
  uint64_t pixels = 0;
  double psnr() const; // dB, peak 255 (white); infinity when squares is 0. Error when no pixel counts.
};
template <class SampleType>
LumaError luma_error(const BasicImage<SampleType> &a, const BasicImage<SampleType> &b,
                     const Image *mask = nullptr);

// luma_error(...).psnr(). a and b have the same size and channels; mask is grey and of that size.
template <class SampleType>
double psnr_luma(const BasicImage<SampleType> &a, const BasicImage<SampleType> &b,
                 const Image *mask = nullptr) {
  return luma_error(a, b, mask).psnr();
}

} // namespace fvv::media
