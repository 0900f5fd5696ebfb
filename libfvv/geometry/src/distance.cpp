#include "geometry/src/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::hull {

namespace {

constexpr float far_off = 1e8f; // squared pixels; more than any picture's diagonal, and exact in a float

// Squared distances along one line: the lower envelope of the parabolas (q - i)^2 + value[i] (Felzenszwalb
// and Huttenlocher, "Distance transforms of sampled functions", 2012). Parabolas above the limit, and those
// of zeros among zeros, are the nearest to no other place and are left out.
class Envelope {
public:
  Envelope(size_t longest, float largest)
      : most(largest), input(longest), place(longest), limit(longest + 1) {}

  void transform(float *value, size_t count) {
    std::copy(value, value + count, input.begin());
    size_t used = 0;
    for (size_t q = 0; q < count; q++) {
      if (!(input[q] <= most)) continue;
      if (input[q] == 0 && (q == 0 || input[q - 1] == 0) && (q + 1 == count || input[q + 1] == 0)) continue;
      float meets = -std::numeric_limits<float>::infinity();
      while (used > 0 && (meets = crossing(q, place[used - 1])) <= limit[used - 1]) used--;
      if (used == 0) meets = -std::numeric_limits<float>::infinity();
      place[used] = q;
      limit[used++] = meets;
    }
    limit[used] = std::numeric_limits<float>::infinity();
    for (size_t q = 0, k = 0; q < count; q++) {
      if (input[q] == 0) continue;
      if (used == 0) {
        value[q] = most;
        continue;
      }
      while (limit[k + 1] < float(q)) k++;
      const float way = float(q) - float(place[k]);
      value[q] = std::min(way * way + input[place[k]], most);
    }
  }

private:
  float crossing(size_t q, size_t p) const {
    const double a = double(q), b = double(p);
    return float((double(input[q]) + a * a - double(input[p]) - b * b) / (2 * (a - b)));
  }

  const float most;
  std::vector<float> input;
  std::vector<size_t> place;
  std::vector<float> limit; // where each parabola becomes the lowest
};

// limit: pixels; distances above it are it.
std::vector<float> limited_distance(const std::vector<uint8_t> &mask, bool inside, size_t width,
                                    size_t height, float limit) {
  std::vector<float> d(mask.size());
  const float most = limit * limit;
  // Within each row the distance from the last pixel of that kind, forth and back.
  for (size_t y = 0; y < height; y++) {
    const uint8_t *row = &mask[y * width];
    float *out = &d[y * width], way = far_off;
    for (size_t x = 0; x < width; x++) {
      way = (row[x] != 0) == inside ? 0 : way + 1;
      out[x] = way;
    }
    way = far_off;
    for (size_t x = width; x-- > 0;) {
      way = out[x] == 0 ? 0 : way + 1;
      const float nearest = std::min(out[x], way);
      out[x] = nearest < far_off ? nearest * nearest : far_off;
    }
  }
  // Several columns at a time, because neighbours share cache lines.
  constexpr size_t together = 16;
  Envelope envelope(height, most);
  std::vector<float> columns(together * height);
  for (size_t x = 0; x < width; x += together) {
    const size_t count = std::min(together, width - x);
    for (size_t y = 0; y < height; y++)
      for (size_t c = 0; c < count; c++) columns[c * height + y] = d[y * width + x + c];
    for (size_t c = 0; c < count; c++) envelope.transform(&columns[c * height], height);
    for (size_t y = 0; y < height; y++)
      for (size_t c = 0; c < count; c++) d[y * width + x + c] = std::sqrt(columns[c * height + y]);
  }
  return d;
}

} // namespace

std::vector<float> distance_to(const std::vector<uint8_t> &mask, bool inside, size_t width, size_t height) {
  return limited_distance(mask, inside, width, height, no_such_pixel);
}

std::vector<float> signed_distance(const std::vector<uint8_t> &mask, size_t width, size_t height,
                                   float limit) {
  std::vector<float> distance = limited_distance(mask, true, width, height, limit);
  const std::vector<float> within = limited_distance(mask, false, width, height, limit);
  // The outline runs half a pixel before the nearest centre of the other kind.
  for (size_t i = 0; i < distance.size(); i++)
    distance[i] = distance[i] > 0 ? distance[i] - 0.5f : 0.5f - within[i];
  return distance;
}

} // namespace fvv::hull
