// Distances in a picture of two kinds of pixels, exact, in time proportional to the picture (Felzenszwalb and
// Huttenlocher, "Distance transforms of sampled functions", 2012).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fvv::hull {

// mask: width x height pixels, row by row. Both functions return one value for the centre of every pixel, in
// pixels; no_such_pixel if there is no pixel of the other kind.
constexpr float no_such_pixel = 1e4f;

// The distance of the nearest pixel that is nonzero (inside) or zero; 0 on those themselves.
std::vector<float> distance_to(const std::vector<uint8_t> &mask, bool inside, size_t width, size_t height);

// The distance from the outline, which runs between the pixels; negative inside. Distances beyond the limit,
// of which computing takes most of the time, are the limit less half a pixel.
std::vector<float> signed_distance(const std::vector<uint8_t> &mask, size_t width, size_t height,
                                   float limit = no_such_pixel);

} // namespace fvv::hull
