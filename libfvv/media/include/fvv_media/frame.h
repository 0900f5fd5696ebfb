// The picture of a video track made of the cameras' pictures, and the way back. fvv_tiles_arrange decides
// where tiles go.
#pragma once

#include "fvv/video.h"
#include "fvv_media/image.h"

#include <vector>

namespace fvv::media {

// The value of flattened and unused pixels, as a code of 8 bits (times 257 for 16 bits, the light of that
// code for linear samples): mid-grey costs a codec next to nothing.
constexpr uint8_t flat_grey = 128;
template <class SampleType>
inline constexpr SampleType flat_grey_of = SampleType(flat_grey *(sizeof(SampleType) == 1 ? 1 : 257));
template <> inline constexpr float flat_grey_of<float> = 0.21586050f;

// Pixels around every tile that repeat its edge, where no other tile is nearer or has its own: filters of a
// codec and the interpolation of colours reach no farther.
constexpr uint32_t guard_band = 4;

// The video frame: of each picture the tile's source rectangle, scaled to its destination. images[i] belongs
// to tiles[i]; all have the same channels. A tile's edge is repeated over its guard band, and from its right
// and bottom edge to the next multiple of FVV_TILE_ALIGNMENT, so that blocks that straddle it cost little and
// nothing bleeds; everything else is flat_grey. Error when a source lies outside its picture or a destination
// outside the frame; overlap is fvv_tiles_validate's business.
template <class SampleType = uint8_t>
BasicImage<SampleType> compose(const std::vector<fvv_tile> &tiles,
                               const std::vector<BasicImage<SampleType>> &images, uint32_t width,
                               uint32_t height);

// The mask of compose's frame, in grey: each mask (of the size of its camera's picture) brought to its tile,
// 0 everywhere else. An empty Image means "the whole tile".
Image compose_masks(const std::vector<fvv_tile> &tiles, const std::vector<Image> &masks, uint32_t width,
                    uint32_t height);

// One camera's part of a frame, at the tile's destination size.
template <class SampleType>
BasicImage<SampleType> extract(const BasicImage<SampleType> &frame, const fvv_tile &tile);

// The mask with every pixel set (255, else 0) that is at most margin pixels, in both axes alike, away from
// one that is > 127.
Image widened(const Image &mask, uint32_t margin);

// Gives every pixel whose mask is <= 127 a value between those of the pixels around that are > 127, the
// smoother the farther away: averages of known pixels in pictures of half, a quarter ... of the size,
// interpolated on the way back (Gortler, Grzeszczuk, Szeliski, Cohen, "The Lumigraph", 1996, section 3.5.1,
// with weights of 0 and 1). The same on every machine. Without a pixel > 127 everything becomes
// flat_grey. keep is grey and of the picture's size.
template <class SampleType> void fill_smoothly(BasicImage<SampleType> &image, const Image &keep);

// Continues what the mask shows over its edge: pixels up to margin away from it (Chebyshev distance) get
// colours as by fill_smoothly. Other pixels do not change, but without a pixel > 127 everything becomes
// flat_grey. mask is grey and of the picture's size.
template <class SampleType> void extend(BasicImage<SampleType> &image, const Image &mask, uint32_t margin);

// Sets to flat_grey every pixel that is more than margin pixels (in both axes alike: Chebyshev distance) away
// from the nearest pixel whose mask is > 127. mask is grey and of the picture's size.
template <class SampleType> void flatten(BasicImage<SampleType> &image, const Image &mask, uint32_t margin);

} // namespace fvv::media
