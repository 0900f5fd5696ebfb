// The picture of another camera, by a map from its pixels to those of the source.
#pragma once

#include "fvv_media/image.h"

#include <functional>

namespace fvv::media {

// Where the point (x, y) of the new picture lies in the source, in pixels of either, the centre of the top
// left one at (0.5, 0.5). false: nowhere. The map is smooth: it is evaluated at every eighth pixel of a row
// and interpolated between those by a cubic through the four nearest. It may be called up to 16 pixels
// outside the picture.
using PixelMap = std::function<bool(double x, double y, double source[2])>;

// Cubic convolution (Keys 1981, a = -1/2) of the source around the place of every new pixel's centre, in
// integers, from places rounded to 1/1024 pixel. Meant for maps that keep sizes or enlarge: where a map makes
// smaller by more than 2, fine patterns alias. At the border the source's last row or column is repeated.
// Pixels without a place, or outside the source by more than half a pixel, are 0.
template <class SampleType>
BasicImage<SampleType> resample(const BasicImage<SampleType> &source, uint32_t width, uint32_t height,
                                const PixelMap &map);

} // namespace fvv::media
