// Conversion of colours: RGB to YCbCr 4:2:0 and back by ITU-T H.273 code points, sRGB to linear light and
// back. The same results on every machine. Primaries and transfer are checked, never converted.
#pragma once

#include "fvv/video.h"
#include "fvv_media/image.h"

#include <cstdint>
#include <vector>

namespace fvv::media {

// ITU-T H.273 tables 2, 3, 4 and VideoFullRangeFlag, as in fvv_video_config.
struct Colour {
  uint8_t primaries, transfer, matrix;
  bool full_range;
};

// JFIF (ITU-T T.871) has BT.601's coefficients at full range. H.273 lists them twice, as 5 and 6; 5 is the
// one that its table 4 gives to IEC 61966-2-1 sYCC, which is what sRGB pictures in JFIF are.
constexpr Colour colour_of_jpeg = {1, 13, 5, true};
// What encode_group writes into the bitstream of all codecs but JPEG and OpenEXR, as far as the codec has a
// place for it: VP9 has one for matrix and range alone.
constexpr Colour colour_of_video = {1, 13, 1, false};

// Linear light, RGB.
constexpr Colour colour_of_exr = {1, 8, 0, true};

// Error unless the samples, once out of the matrix, may be shown as sRGB: primaries 1, transfer 1, 6 or 13
// (BT.709 and BT.601 video is shown as sRGB everywhere on the web), matrix 1, 5 or 6.
void check_colour(const Colour &colour);

// Planar 4:2:0; bit_depth bits are at the low end of a sample. Chroma planes are (width + 1) / 2 by (height
// + 1) / 2, no padding. Chroma is in the middle of its 2 x 2 pixels (chroma_sample_loc_type 1), as in
// JFIF: averaging then stays inside a tile.
template <class SampleType> struct BasicFrame {
  static constexpr int bit_depth = sizeof(SampleType) == 1 ? 8 : 10;
  uint32_t width = 0, height = 0;
  std::vector<SampleType> y, u, v;
};
using Frame = BasicFrame<uint8_t>;
using DeepFrame = BasicFrame<uint16_t>;

// RGB only. Chroma is the mean over 2 x 2 pixels. Grey maps to chroma 128 (512 of 10 bits) exactly.
template <class SampleType>
BasicFrame<SampleType> to_yuv(const BasicImage<SampleType> &image, const Colour &colour);
// Chroma is interpolated linearly (3:1 to the nearer sample in each axis), as libjpeg and a GPU's linear
// filter do. Any depth to any: rounded once, to the samples that are wanted. Error when a plane has
// another size.
template <class Wanted = uint8_t, class SampleType>
BasicImage<Wanted> to_rgb(const BasicFrame<SampleType> &frame, const Colour &colour);

// The least float32 of linear light (1: white) that becomes code 1, 2, ... largest, ascending: a code is the
// number of thresholds at or below the value, which clips at both ends. largest: 255 for 8 bits, 65535 for
// 16. A code is the curve's value times largest, rounded to the nearest integer; no float lies half-way.
//
// The curve is inverted: its power 2.4 = 12 / 5 turns "curve(x) reaches v" into a comparison of x^5 with the
// 12th power of a rational number, so products of doubles decide and no machine's pow() does.
std::vector<float> srgb_thresholds(uint32_t largest);

// The linear light of codes 0 ... largest, rounded once: sums and products alone, the same on every machine.
std::vector<float> linear_of_codes(uint32_t largest);

// The curve and its inverse, 1 for white, continued above 1 by the formula and below 0 by odd symmetry: for
// pictures with light beyond white that are mixed with or measured like display values.
double srgb_of_linear(double linear);
double linear_of_srgb(double display);

} // namespace fvv::media
