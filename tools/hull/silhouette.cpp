#include "hull/silhouette.h"

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

// Distance of every pixel's centre from the nearest pixel whose mask is nonzero or not, as asked.
std::vector<float> distance_to(const std::vector<uint8_t> &mask, bool inside, size_t width, size_t height) {
  std::vector<float> d(mask.size());
  for (size_t i = 0; i < mask.size(); i++) d[i] = (mask[i] != 0) == inside ? 0 : far_off;
  Envelope envelope(std::max(width, height));
  for (size_t y = 0; y < height; y++) envelope.transform(&d[y * width], width, 1);
  for (size_t x = 0; x < width; x++) envelope.transform(&d[x], height, width);
  for (float &value : d) value = std::sqrt(value);
  return d;
}

// Binomial over 3 x 3 pixels: takes the steps of the mask's edge away. Rows and columns end at the border.
void smooth(std::vector<float> &d, size_t width, size_t height) {
  const auto line = [](float *value, size_t count, size_t stride) {
    float before = value[0];
    for (size_t i = 0; i < count; i++) {
      const float here = value[i * stride], after = value[std::min(i + 1, count - 1) * stride];
      value[i * stride] = 0.25f * before + 0.5f * here + 0.25f * after;
      before = here;
    }
  };
  for (size_t y = 0; y < height; y++) line(&d[y * width], width, 1);
  for (size_t x = 0; x < width; x++) line(&d[x], height, width);
}

} // namespace

Silhouette::Silhouette(const fvv_camera &from, const std::vector<uint8_t> &mask)
    : camera(from), distance(distance_to(mask, true, from.width, from.height)) {
  camera.name = nullptr;
  camera.name_size = 0;
  const std::vector<float> within = distance_to(mask, false, camera.width, camera.height);
  // The outline runs half a pixel before the nearest centre of the other kind.
  for (size_t i = 0; i < distance.size(); i++)
    distance[i] = distance[i] > 0 ? distance[i] - 0.5f : 0.5f - within[i];
  smooth(distance, camera.width, camera.height);
}

double Silhouette::at(double u, double v) const {
  const double x = std::clamp(u - 0.5, 0.0, camera.width - 1.0),
               y = std::clamp(v - 0.5, 0.0, camera.height - 1.0);
  const size_t i = std::min(size_t(x), size_t(camera.width) - 2),
               j = std::min(size_t(y), size_t(camera.height) - 2);
  const double s = x - double(i), t = y - double(j);
  const float *d = &distance[j * camera.width + i];
  const double above = d[0] + (double(d[1]) - double(d[0])) * s;
  d += camera.width;
  const double below = d[0] + (double(d[1]) - double(d[0])) * s;
  return above + (below - above) * t;
}

Silhouette::View Silhouette::view(const double world[3]) const {
  View view;
  if (!fvv_camera_project(&camera, world, view.pixel, &view.depth)) return view;
  view.seen = view.pixel[0] >= 0 && view.pixel[1] >= 0 && view.pixel[0] <= camera.width &&
              view.pixel[1] <= camera.height;
  if (!view.seen) return view;
  view.per_metre = camera.fx / view.depth;
  view.pixels = at(view.pixel[0], view.pixel[1]);
  view.metres = view.pixels / view.per_metre;
  return view;
}

bool Silhouette::clear_of(const View &view, double radius) const {
  if (!view.seen || view.depth <= 2 * radius) return false;
  // Twice as far as a point moves in the middle of the picture: enough for perspective and lens at its edges,
  // and one pixel and a half for smoothing.
  const double reach = 2 * radius * view.per_metre * view.depth / (view.depth - radius) + 1.5;
  return view.pixels > reach && view.pixel[0] > reach && view.pixel[1] > reach &&
         view.pixel[0] + reach < camera.width && view.pixel[1] + reach < camera.height;
}

} // namespace fvv::hull
