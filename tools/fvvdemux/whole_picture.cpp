#include "fvvdemux/whole_picture.h"

#include "fvv_media/frame.h"

#include <algorithm>
#include <cmath>

namespace fvv::demux {

namespace {

// One axis of a pixel of the whole picture: the two pixels of the tile around its centre, and the share of
// the second. Outside of the tile: none.
struct Tap {
  bool inside;
  uint32_t first, second;
  double share;
};

std::vector<Tap> taps_of(uint32_t picture, uint32_t size, uint32_t source, uint32_t source_size,
                         uint32_t destination_size) {
  std::vector<Tap> taps(size);
  for (uint32_t i = 0; i < size; i++) {
    // Of the tile's pixels, in 1/(2 size) of the picture's: exact, so that pixels that are the same are found
    // to be.
    const int64_t centre = int64_t(2 * i + 1) * picture - int64_t(2) * size * source;
    const double at = double(centre * destination_size) / double(int64_t(2) * size * source_size);
    const double low = std::floor(at - 0.5);
    const auto clamped = [&](double k) { return uint32_t(std::clamp(k, 0.0, double(destination_size - 1))); };
    taps[i] = {centre >= 0 && at < destination_size, clamped(low), clamped(low + 1), at - 0.5 - low};
  }
  return taps;
}

} // namespace

template <class Sample>
media::BasicImage<Sample> whole_picture(const media::BasicImage<Sample> &frame, const fvv_tile *tile,
                                        const fvv_tile &whole) {
  const fvv_rect &to = whole.destination;
  media::BasicImage<Sample> out =
      media::make_image<Sample>(to.width, to.height, frame.channels, media::flat_grey_of<Sample>);
  if (!tile) return out;
  const media::BasicImage<Sample> part = media::extract(frame, *tile);
  const std::vector<Tap> columns = taps_of(whole.source.width, to.width, tile->source.x, tile->source.width,
                                           tile->destination.width),
                         rows = taps_of(whole.source.height, to.height, tile->source.y, tile->source.height,
                                        tile->destination.height);
  const size_t channels = size_t(frame.channels);
  constexpr double rounding = std::is_floating_point_v<Sample> ? 0 : 0.5;
  for (size_t y = 0; y < to.height; y++)
    for (size_t x = 0; x < to.width; x++) {
      const Tap &row = rows[y], &column = columns[x];
      if (!row.inside || !column.inside) continue;
      for (size_t c = 0; c < channels; c++) {
        const auto at = [&](size_t v, size_t u) {
          return double(part.pixels[(v * part.width + u) * channels + c]);
        };
        const double above = at(row.first, column.first) * (1 - column.share) +
                             at(row.first, column.second) * column.share,
                     below = at(row.second, column.first) * (1 - column.share) +
                             at(row.second, column.second) * column.share;
        out.pixels[(y * to.width + x) * channels + c] =
            Sample(above * (1 - row.share) + below * row.share + rounding);
      }
    }
  return out;
}

template media::Image whole_picture(const media::Image &, const fvv_tile *, const fvv_tile &);
template media::DeepImage whole_picture(const media::DeepImage &, const fvv_tile *, const fvv_tile &);
template media::LinearImage whole_picture(const media::LinearImage &, const fvv_tile *, const fvv_tile &);

} // namespace fvv::demux
