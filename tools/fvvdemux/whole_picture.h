// A camera's whole picture from its tile: the tile where it was, grey around it. Knows rectangles and pixels.
#pragma once

#include "fvv/video.h"
#include "fvv_media/image.h"

namespace fvv::demux {

// frame: of the video. tile: of the group that the frame is in, NULL: the camera has none. whole: the source
// rectangle is all of the camera's picture, the destination, at (0, 0), the size to make of it. Pixels are
// copied where those of the tile are those of the picture, else interpolated between the nearest four.
template <class Sample>
media::BasicImage<Sample> whole_picture(const media::BasicImage<Sample> &frame, const fvv_tile *tile,
                                        const fvv_tile &whole);

} // namespace fvv::demux
