#include "fvv_geometry/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::hull {

namespace {

constexpr float far_off = 1e8f; // squared pixels; more than any picture's diagonal, and exact in a float

// Squared distances along one line: the lower envelope of the parabolas (q - i)^2 + value[i] (Felzenszwalb
// and Huttenlocher, "Distance transforms of sampled functions", 2012).
class Envelope {
public:
  explicit Envelope(size_t longest) : input(longest), place(longest), limit(longest + 1) {}

  void transform(float *value, size_t count, size_t stride) {
    for (size_t i = 0; i < count; i++) input[i] = value[i * stride];
    size_t last = 0;
    place[0] = 0;
    limit[0] = -std::numeric_limits<float>::infinity();
    limit[1] = std::numeric_limits<float>::infinity();
    for (size_t q = 1; q < count; q++) {
      float meets = crossing(q, place[last]);
      while (meets <= limit[last]) meets = crossing(q, place[--last]);
      place[++last] = q;
      limit[last] = meets;
      limit[last + 1] = std::numeric_limits<float>::infinity();
    }
    for (size_t q = 0, k = 0; q < count; q++) {
      while (limit[k + 1] < float(q)) k++;
      const float way = float(q) - float(place[k]);
      value[q * stride] = way * way + input[place[k]];
    }
  }

private:
  float crossing(size_t q, size_t p) const {
    const double a = double(q), b = double(p);
    return float((double(input[q]) + a * a - double(input[p]) - b * b) / (2 * (a - b)));
  }

  std::vector<float> input;
  std::vector<size_t> place;
  std::vector<float> limit;
};

} // namespace

std::vector<float> distance_to(const std::vector<uint8_t> &mask, bool inside, size_t width, size_t height) {
  std::vector<float> d(mask.size());
  for (size_t i = 0; i < mask.size(); i++) d[i] = (mask[i] != 0) == inside ? 0 : far_off;
  Envelope envelope(std::max(width, height));
  for (size_t y = 0; y < height; y++) envelope.transform(&d[y * width], width, 1);
  for (size_t x = 0; x < width; x++) envelope.transform(&d[x], height, width);
  for (float &value : d) value = std::sqrt(value);
  return d;
}

std::vector<float> signed_distance(const std::vector<uint8_t> &mask, size_t width, size_t height) {
  std::vector<float> distance = distance_to(mask, true, width, height);
  const std::vector<float> within = distance_to(mask, false, width, height);
  // The outline runs half a pixel before the nearest centre of the other kind.
  for (size_t i = 0; i < distance.size(); i++)
    distance[i] = distance[i] > 0 ? distance[i] - 0.5f : 0.5f - within[i];
  return distance;
}

} // namespace fvv::hull
