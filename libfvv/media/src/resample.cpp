/* Cubic convolution along a map. See fvv_media/resample.h. */
#include "fvv_media/resample.h"

#include "codecs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace fvv::media {
namespace {

constexpr int phases = 1024;          // of a pixel
constexpr int32_t one = 1 << 14;      // the sum of four weights
constexpr uint32_t node_distance = 8; // pixels between places where the map is asked

using Weights = std::array<int32_t, 4>; // of the samples at -1, 0, 1, 2

std::vector<Weights> make_weights() {
  std::vector<Weights> table(phases);
  for (int i = 0; i < phases; i++) {
    const double t = double(i) / phases, t2 = t * t, t3 = t2 * t;
    const double exact[4] = {(-t3 + 2 * t2 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (-3 * t3 + 4 * t2 + t) / 2,
                             (t3 - t2) / 2};
    Weights &w = table[size_t(i)];
    for (size_t k = 0; k < 4; k++) w[k] = int32_t(std::lround(exact[k] * one));
    // What rounding took goes to the nearer sample: flat areas stay as they are.
    w[t < 0.5 ? 1 : 2] += one - (w[0] + w[1] + w[2] + w[3]);
  }
  return table;
}

const std::vector<Weights> &weights() {
  static const std::vector<Weights> table = make_weights();
  return table;
}

struct Place {
  double x = 0, y = 0; // in the source
  bool known = false;
};

Place ask(const PixelMap &map, double x, double y) {
  double found[2];
  Place place;
  place.known = map(x, y, found) && std::isfinite(found[0]) && std::isfinite(found[1]);
  if (place.known) place = {found[0], found[1], true};
  return place;
}

// The map along one row of pixel centres.
class Row {
public:
  Row(const PixelMap &asked, uint32_t width, double height) : map(asked), y(height) {
    // One before the first and two behind the last node, for the cubics.
    for (uint32_t i = 0; i < (width - 1) / node_distance + 4; i++)
      nodes.push_back(ask(map, 0.5 + (double(i) - 1) * node_distance, y));
  }
  Place operator()(uint32_t x) const {
    const size_t i = x / node_distance;
    const Place *p = &nodes[i];
    if (!p[0].known || !p[1].known || !p[2].known || !p[3].known) return ask(map, x + 0.5, y);
    const double t = double(x % node_distance) / node_distance; // Lagrange's polynomials on -1, 0, 1, 2
    const double a = -t * (t - 1) * (t - 2) / 6, b = (t + 1) * (t - 1) * (t - 2) / 2;
    const double c = -(t + 1) * t * (t - 2) / 2, d = (t + 1) * t * (t - 1) / 6;
    return {a * p[0].x + b * p[1].x + c * p[2].x + d * p[3].x,
            a * p[0].y + b * p[1].y + c * p[2].y + d * p[3].y, true};
  }

private:
  const PixelMap &map;
  double y;
  std::vector<Place> nodes;
};

// The four samples of an axis around a place, those beyond the border moved onto it.
struct Taps {
  size_t index[4];
  const Weights *weight;

  Taps(double place, uint32_t size) {
    const int64_t fine = std::llround((place - 0.5) * phases);
    const int64_t first = fine >= 0 ? fine / phases : -((-fine + phases - 1) / phases);
    weight = &weights()[size_t(fine - first * phases)];
    for (int k = 0; k < 4; k++) index[k] = size_t(std::clamp<int64_t>(first - 1 + k, 0, int64_t(size) - 1));
  }
};

bool is_inside(double place, uint32_t size) {
  return place >= -0.5 && place <= double(size) + 0.5;
}

template <class Sample> void convolve(const BasicImage<Sample> &source, const Place &place, Sample *out) {
  const Taps columns(place.x, source.width), rows(place.y, source.height);
  const size_t channels = size_t(source.channels);
  using Sum = std::conditional_t<std::is_floating_point_v<Sample>, double, int64_t>;
  constexpr int64_t unit = int64_t(one) * one;
  for (size_t c = 0; c < channels; c++) {
    Sum sum = 0;
    for (size_t j = 0; j < 4; j++) {
      const Sample *row = &source.pixels[rows.index[j] * source.width * channels + c];
      Sum along = 0;
      for (size_t i = 0; i < 4; i++)
        along += Sum((*columns.weight)[i]) * Sum(row[columns.index[i] * channels]);
      sum += along * (*rows.weight)[j];
    }
    if constexpr (std::is_floating_point_v<Sample>)
      out[c] = Sample(sum / unit);
    else
      out[c] = Sample(std::clamp<int64_t>((sum + unit / 2) / unit, 0, std::numeric_limits<Sample>::max()));
  }
}

} // namespace

template <class Sample>
BasicImage<Sample> resample(const BasicImage<Sample> &source, uint32_t width, uint32_t height,
                            const PixelMap &map) {
  check_image(source);
  BasicImage<Sample> out = make_image<Sample>(width, height, source.channels, 0);
  Sample *to = out.pixels.data();
  for (uint32_t y = 0; y < height; y++) {
    const Row row(map, width, y + 0.5);
    for (uint32_t x = 0; x < width; x++, to += source.channels) {
      const Place place = row(x);
      if (place.known && is_inside(place.x, source.width) && is_inside(place.y, source.height))
        convolve(source, place, to);
    }
  }
  return out;
}

template Image resample(const Image &, uint32_t, uint32_t, const PixelMap &);
template DeepImage resample(const DeepImage &, uint32_t, uint32_t, const PixelMap &);
template LinearImage resample(const LinearImage &, uint32_t, uint32_t, const PixelMap &);

} // namespace fvv::media
