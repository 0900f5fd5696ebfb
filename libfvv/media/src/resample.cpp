// Pictures of another size: exact area averaging, Lanczos' filter, cropping, cubic convolution along a map.
#include "fvv_media/resample.h"

#include "codecs.h"
#include "fvv_media/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace fvv::media {

namespace {

// Source pixels first ... first + count - 1 weigh weights[offset ...] in one destination pixel.
struct Span {
  uint32_t first, count;
  size_t offset;
};

constexpr int32_t one = 1 << 14; // the sum of rounded weights

// Lanczos' window of three lobes.
double lanczos(double x) {
  constexpr double pi = 3.14159265358979323846;
  if (x == 0) return 1;
  if (std::abs(x) >= 3) return 0;
  return 3 * std::sin(pi * x) * std::sin(pi * x / 3) / (pi * pi * x * x);
}

// The weights of a destination pixel add up to total, at most 16384.
struct Axis {
  std::vector<Span> spans;
  std::vector<int32_t> weights;
  int64_t total;
  uint32_t most = 0; // of source pixels in a span

  Axis(uint32_t source, uint32_t destination, Filter filter)
      : total(filter == Filter::area ? int64_t(source) : one) {
    for (uint32_t i = 0; i < destination; i++) {
      if (filter == Filter::area)
        add_area(i, source, destination);
      else
        add_lanczos(i, source, destination);
      most = std::max(most, spans.back().count);
    }
  }

private:
  void add_area(uint32_t i, uint32_t source, uint32_t destination) {
    const uint64_t begin = uint64_t(i) * source, end = begin + source;
    const uint32_t first = uint32_t(begin / destination), last = uint32_t((end - 1) / destination);
    spans.push_back({first, last - first + 1, weights.size()});
    for (uint64_t j = first; j <= last; j++)
      weights.push_back(int32_t(std::min(end, (j + 1) * destination) - std::max(begin, j * destination)));
  }

  // Beyond the border its pixel is repeated.
  void add_lanczos(uint32_t i, uint32_t source, uint32_t destination) {
    const double ratio = double(source) / destination, step = std::max(1.0, ratio);
    const double centre = (i + 0.5) * ratio - 0.5;
    const auto inside = [&](int64_t j) { return uint32_t(std::clamp<int64_t>(j, 0, int64_t(source) - 1)); };
    const int64_t begin = int64_t(std::ceil(centre - 3 * step)), end = int64_t(std::floor(centre + 3 * step));
    std::vector<double> exact(inside(end) - inside(begin) + 1);
    double sum = 0;
    for (int64_t j = begin; j <= end; j++) {
      const double weight = lanczos((double(j) - centre) / step);
      exact[inside(j) - inside(begin)] += weight;
      sum += weight;
    }
    const Span span = {inside(begin), uint32_t(exact.size()), weights.size()};
    int32_t rest = one;
    for (const double weight : exact) {
      weights.push_back(int32_t(std::lround(weight / sum * one)));
      rest -= weights.back();
    }
    // The rounding error goes to the nearest sample, so that flat areas do not change.
    weights[span.offset + inside(std::llround(centre)) - span.first] += rest;
    spans.push_back(span);
  }
};

// Of weighted samples: at most 65535 * 16384 after the first axis, 65535 * 16384 * 16384 after the second;
// negative lobes add less than a half to each.
template <class Sample> using RowSum = std::conditional_t<std::is_floating_point_v<Sample>, double, int32_t>;
template <class Sample> using Sum = std::conditional_t<std::is_floating_point_v<Sample>, double, int64_t>;

template <class Sample> Sample mean(Sum<Sample> sum, int64_t weights) {
  if constexpr (std::is_floating_point_v<Sample>)
    return Sample(sum / double(weights));
  else
    return Sample(std::clamp<int64_t>((sum + weights / 2) / weights, 0, std::numeric_limits<Sample>::max()));
}

template <int channels, class Sample>
void scale_row(const Sample *in, const Axis &axis, RowSum<Sample> *out) {
  for (const Span &span : axis.spans) {
    RowSum<Sample> sum[channels] = {};
    for (uint32_t j = 0; j < span.count; j++)
      for (int c = 0; c < channels; c++)
        sum[c] += axis.weights[span.offset + j] * in[size_t(span.first + j) * channels + size_t(c)];
    for (int c = 0; c < channels; c++) *out++ = sum[c];
  }
}

} // namespace

template <class Sample>
BasicImage<Sample> scale(const BasicImage<Sample> &image, uint32_t width, uint32_t height, Filter filter) {
  check_image(image);
  if (image.width == width && image.height == height) return image;
  BasicImage<Sample> out = make_image<Sample>(width, height, image.channels, 0);
  const Axis columns(image.width, width, filter), rows(image.height, height, filter);
  const size_t in_stride = size_t(image.width) * size_t(image.channels);
  const size_t out_stride = size_t(width) * size_t(image.channels);
  // Scaled rows of the source, each where the one that is rows.most above it was.
  std::vector<RowSum<Sample>> scaled(out_stride * rows.most);
  uint32_t next = 0;
  std::vector<Sum<Sample>> sums(out_stride);
  for (uint32_t y = 0; y < height; y++) {
    const Span &span = rows.spans[y];
    for (next = std::max(next, span.first); next < span.first + span.count; next++) {
      const Sample *in = image.pixels.data() + next * in_stride;
      RowSum<Sample> *row = &scaled[next % rows.most * out_stride];
      if (image.channels == 1)
        scale_row<1>(in, columns, row);
      else
        scale_row<3>(in, columns, row);
    }
    std::fill(sums.begin(), sums.end(), 0);
    for (uint32_t j = 0; j < span.count; j++) {
      const Sum<Sample> weight = rows.weights[span.offset + j];
      const RowSum<Sample> *row = &scaled[(span.first + j) % rows.most * out_stride];
      for (size_t x = 0; x < out_stride; x++) sums[x] += weight * row[x];
    }
    Sample *to = out.pixels.data() + y * out_stride;
    for (size_t x = 0; x < out_stride; x++) to[x] = mean<Sample>(sums[x], columns.total * rows.total);
  }
  return out;
}

template <class Sample>
BasicImage<Sample> crop(const BasicImage<Sample> &image, uint32_t x, uint32_t y, uint32_t width,
                        uint32_t height) {
  check_image(image);
  if (width == 0 || height == 0 || uint64_t(x) + width > image.width || uint64_t(y) + height > image.height)
    throw Error("the rectangle " + std::to_string(width) + " x " + std::to_string(height) + " at " +
                std::to_string(x) + ", " + std::to_string(y) + " is not inside a picture of " +
                std::to_string(image.width) + " x " + std::to_string(image.height));
  if (width == image.width && height == image.height) return image;
  BasicImage<Sample> out = make_image<Sample>(width, height, image.channels, 0);
  const size_t channels = size_t(image.channels), stride = width * channels;
  for (uint32_t row = 0; row < height; row++)
    memcpy(&out.pixels[row * stride], &image.pixels[((size_t(y) + row) * image.width + x) * channels],
           stride * sizeof(Sample));
  return out;
}

template Image scale(const Image &, uint32_t, uint32_t, Filter);
template DeepImage scale(const DeepImage &, uint32_t, uint32_t, Filter);
template LinearImage scale(const LinearImage &, uint32_t, uint32_t, Filter);
template Image crop(const Image &, uint32_t, uint32_t, uint32_t, uint32_t);
template DeepImage crop(const DeepImage &, uint32_t, uint32_t, uint32_t, uint32_t);
template LinearImage crop(const LinearImage &, uint32_t, uint32_t, uint32_t, uint32_t);

namespace {

constexpr int phases = 1024;          // of a pixel
constexpr uint32_t node_distance = 8; // pixels between places where the map is evaluated

using Weights = std::array<int32_t, 4>; // of the samples at -1, 0, 1, 2

std::vector<Weights> make_weights() {
  std::vector<Weights> table(phases);
  for (int i = 0; i < phases; i++) {
    const double t = double(i) / phases, t2 = t * t, t3 = t2 * t;
    const double exact[4] = {(-t3 + 2 * t2 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (-3 * t3 + 4 * t2 + t) / 2,
                             (t3 - t2) / 2};
    Weights &w = table[size_t(i)];
    for (size_t k = 0; k < 4; k++) w[k] = int32_t(std::lround(exact[k] * one));
    // The rounding error goes to the nearer sample, so that flat areas do not change.
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
  Row(const PixelMap &pixel_map, uint32_t width, double height) : map(pixel_map), y(height) {
    // One before the first and two after the last node, for the cubics.
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
  using Total = std::conditional_t<std::is_floating_point_v<Sample>, double, int64_t>;
  constexpr int64_t unit = int64_t(one) * one;
  for (size_t c = 0; c < channels; c++) {
    Total sum = 0;
    for (size_t j = 0; j < 4; j++) {
      const Sample *row = &source.pixels[rows.index[j] * source.width * channels + c];
      Total along = 0;
      for (size_t i = 0; i < 4; i++)
        along += Total((*columns.weight)[i]) * Total(row[columns.index[i] * channels]);
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
