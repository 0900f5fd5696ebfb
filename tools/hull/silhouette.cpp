#include "hull/silhouette.h"

#include "hull/distance.h"

#include <algorithm>

namespace fvv::hull {

namespace {

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
    : camera(from), distance(signed_distance(mask, from.width, from.height)) {
  camera.name = nullptr;
  camera.name_size = 0;
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
