/* fvv_media/colour.h: RGB to YCbCr 4:2:0 and back, as ITU-T H.273 code points say.
 *
 * Integer arithmetic throughout, one rounding per sample, so that the conversion is the same on every
 * machine. It knows the matrices of BT.601 and BT.709; primaries and transfer are checked, never converted.
 */
#ifndef FVV_MEDIA_COLOUR_H
#define FVV_MEDIA_COLOUR_H

#include "fvv/video.h"
#include "fvv_media/image.h"

namespace fvv::media {

/* ITU-T H.273 tables 2, 3, 4 and VideoFullRangeFlag, as in fvv_video_config. */
struct Colour {
  uint8_t primaries, transfer, matrix;
  bool full_range;
};

/* JFIF (ITU-T T.871) has BT.601's coefficients at full range. H.273 lists them twice, as 5 and 6; 5 is the
 * one that its table 4 gives to IEC 61966-2-1 sYCC, which is what sRGB pictures in JFIF are. */
constexpr Colour colour_of_jpeg = {1, 13, 5, true};
/* What encode_group writes into the bitstream of all codecs but JPEG and OpenEXR, as far as the codec has a
 * place for it: VP9 has one for matrix and range alone. */
constexpr Colour colour_of_video = {1, 13, 1, false};

/* Linear light, RGB. */
constexpr Colour colour_of_exr = {1, 8, 0, true};

/* Error unless the samples, once out of the matrix, may be shown as sRGB: primaries 1, transfer 1, 6 or 13
 * (BT.709 and BT.601 video is shown as sRGB everywhere on the web), matrix 1, 5 or 6. */
void check_colour(const Colour &colour);

/* Planar 4:2:0; bit_depth bits stand at the low end of a sample. Chroma planes are (width + 1) / 2 by (height
 * + 1) / 2, no padding. Chroma stands in the middle of its 2 x 2 pixels (chroma_sample_loc_type 1), as in
 * JFIF: averaging then stays inside a tile.
 */
template <class SampleType> struct BasicFrame {
  static constexpr int bit_depth = sizeof(SampleType) == 1 ? 8 : 10;
  uint32_t width = 0, height = 0;
  std::vector<SampleType> y, u, v;
};
using Frame = BasicFrame<uint8_t>;
using DeepFrame = BasicFrame<uint16_t>;

/* RGB only. Chroma is the mean over 2 x 2 pixels. Grey maps to chroma 128 (512 of 10 bits) exactly. */
template <class SampleType>
BasicFrame<SampleType> to_yuv(const BasicImage<SampleType> &image, const Colour &colour);
/* Chroma is interpolated linearly (3:1 to the nearer sample in each axis), as libjpeg and a GPU's linear
 * filter do. Any depth to any: rounded once, to the samples that are wanted. Error when a plane has
 * another size. */
template <class Wanted = uint8_t, class SampleType>
BasicImage<Wanted> to_rgb(const BasicFrame<SampleType> &frame, const Colour &colour);

} // namespace fvv::media

#endif
