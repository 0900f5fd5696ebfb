// What the codecs of pictures and video have in common: checks, still-picture formats, samples and
// configuration records of video, linear light. Internal to fvv_media.
#pragma once

#include "fvv_media/exr.h"
#include "fvv_media/image.h"
#include "fvv_media/video.h"

namespace fvv::media {

// Error unless both sides are 1 ... max_dimension.
void check_dimensions(uint32_t width, uint32_t height, const std::string &name);
// Error unless the picture is a valid Image (image.h).
template <class SampleType> void check_image(const BasicImage<SampleType> &image);
// Error if size bytes cannot hold that number of samples even at the best compression that the format allows:
// a few bytes must not cause an allocation of gigabytes.
void check_justified(uint64_t samples, uint64_t samples_per_byte, size_t size, const std::string &name);

// A whole file. Error when it cannot be read or is larger than any picture needs.
std::vector<uint8_t> read_file(const std::string &path);

// In 1 or 3 channels, as read_image.
template <class SampleType> BasicImage<SampleType> with_channels(BasicImage<SampleType> image, int channels);

// Throws Error: the code is not among video_codecs().
[[noreturn]] void refuse_codec(uint32_t code);

bool is_png(const uint8_t *bytes, size_t size);
bool is_jpeg(const uint8_t *bytes, size_t size);
bool is_exr(const uint8_t *bytes, size_t size);
bool is_webp(const uint8_t *bytes, size_t size);

// The header alone; bytes may end anywhere after it. Error when they end before.
ImageInfo probe_png(const uint8_t *bytes, size_t size, const std::string &name);
ImageInfo probe_jpeg(const uint8_t *bytes, size_t size, const std::string &name);
ImageInfo probe_exr(const uint8_t *bytes, size_t size, const std::string &name);
ImageInfo probe_webp(const uint8_t *bytes, size_t size, const std::string &name);

// In the channels of the file.
template <class SampleType>
BasicImage<SampleType> decode_png(const uint8_t *bytes, size_t size, const std::string &name);
// All that a PNG or WebP file holds: R, G, B and alpha of 16 bits. has_alpha: it has such a channel or
// colour.
struct RgbaImage {
  uint32_t width, height;
  bool has_alpha;
  std::vector<uint16_t> pixels;
};
RgbaImage decode_png_rgba(const uint8_t *bytes, size_t size, const std::string &name);
RgbaImage decode_webp_rgba(const uint8_t *bytes, size_t size, const std::string &name);
Image decode_webp(const uint8_t *bytes, size_t size, const std::string &name);
Image decode_jpeg(const uint8_t *bytes, size_t size, const std::string &name);
template <class SampleType>
BasicImage<SampleType> decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);

using Bytes = std::vector<uint8_t>;

// Converts the output of libavcodec's encoders to fvv's samples and records.
struct Bitstream {
  // A packet of the encoder as a sample.
  Bytes (*sample)(const uint8_t *packet, size_t size);
  // Of a group with these settings. header: the encoder's global header; first: the first sample. Error when
  // either does not match the settings.
  Bytes (*record)(const VideoSettings &settings, const Bytes &header, const Bytes &first);
};

// ISO/IEC 14496-15, clauses 5 and 8: slices after 4-byte lengths; parameter sets are in the record alone.
extern const Bitstream avc_bitstream, hevc_bitstream;
// VP Codec ISO Media File Format Binding: packets as they are.
extern const Bitstream vp9_bitstream;
// AV1 Codec ISO Media File Format Binding: temporal units without their delimiter.
extern const Bitstream av1_bitstream;

// By the inverse of the sRGB curve.
LinearImage linear_of(const DeepImage &image);
// Clipped to 0 ... 1 and by the sRGB curve, for uint8_t or uint16_t.
template <class SampleType> BasicImage<SampleType> display_of(const LinearImage &image);

// srgb_of_linear of a value rounded to a half float, quickly; infinite where halves are.
float srgb_of_half(float linear);

// The first value that is not finite: Error that names channel and pixel.
void check_finite(const LinearImage &image, const std::string &name);

} // namespace fvv::media
