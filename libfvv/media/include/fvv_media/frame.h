/* fvv_media/frame.h: the picture of a video track made of the cameras' pictures, and the way back.
 *
 * It knows fvv_tile and pixels. It knows nothing of codecs; where tiles go is decided by fvv_tiles_arrange.
 */
#ifndef FVV_MEDIA_FRAME_H
#define FVV_MEDIA_FRAME_H

#include "fvv/video.h"
#include "fvv_media/image.h"

#include <vector>

namespace fvv::media {

/* What flattened and unused pixels hold, in codes of 8 bits (times 257 of 16): mid-grey costs a codec next to
 * nothing. */
constexpr uint8_t flat_grey = 128;

/* The video frame: of each picture the tile's source rectangle, scaled to its destination. images[i] belongs
 * to tiles[i]; all have the same channels. From a tile's right and bottom edge to the next multiple of
 * FVV_TILE_ALIGNMENT the edge is repeated, so that blocks that straddle it cost little and bleed nothing;
 * everything else is flat_grey. Error when a source lies outside its picture or a destination outside the
 * frame; overlap is fvv_tiles_validate's business. */
template <class SampleType = uint8_t>
BasicImage<SampleType> compose(const std::vector<fvv_tile> &tiles,
                               const std::vector<BasicImage<SampleType>> &images, uint32_t width,
                               uint32_t height);

/* The grey frame that says which pixels of compose's frame count: each mask (of the size of its camera's
 * picture) brought to its tile, 0 everywhere else. An empty Image stands for "the whole tile". */
Image compose_masks(const std::vector<fvv_tile> &tiles, const std::vector<Image> &masks, uint32_t width,
                    uint32_t height);

/* One camera's part of a frame, at the tile's destination size. */
template <class SampleType>
BasicImage<SampleType> extract(const BasicImage<SampleType> &frame, const fvv_tile &tile);

/* Sets to flat_grey every pixel that is more than margin pixels (in both axes alike: Chebyshev distance) away
 * from the nearest pixel whose mask is > 127. mask is grey and of the picture's size. */
template <class SampleType> void flatten(BasicImage<SampleType> &image, const Image &mask, uint32_t margin);

} // namespace fvv::media

#endif
