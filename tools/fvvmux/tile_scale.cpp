#include "fvvmux/tile_scale.h"

#include "fvvmux/moving.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

constexpr int steps = 16; // of the scale

// Pixels of the capture's picture, mean over the groups.
double mean_area(const std::vector<std::vector<Silhouette>> &boxes, size_t camera) {
  double sum = 0;
  for (const std::vector<Silhouette> &group : boxes)
    sum += double(group[camera].right - group[camera].left) * (group[camera].bottom - group[camera].top);
  return std::max(1.0, sum / double(boxes.size()));
}

} // namespace

std::vector<double> usefulness(const capture::Capture &capture, const std::vector<size_t> &cameras,
                               const std::vector<std::vector<Silhouette>> &boxes) {
  std::vector<fvv_camera> seen;
  for (const size_t index : cameras) seen.push_back(described(capture, capture.cameras[index]));
  std::vector<double> out;
  double sum = 0;
  for (size_t k = 0; k < seen.size(); k++) {
    double together = 0;
    for (const fvv_camera &other : seen) {
      double cosine = 0; // of the third rows: the optical axes
      for (int i = 6; i < 9; i++) cosine += seen[k].rotation[i] * other.rotation[i];
      together += cosine > 0 ? cosine * cosine : 0;
    }
    out.push_back(mean_area(boxes, k) / (seen[k].fx * seen[k].fy) / std::max(together, 1.0));
    sum += out.back();
  }
  for (double &value : out) value /= sum;
  return out;
}

std::vector<fvv_tile> scaled_by_use(const std::vector<fvv_tile> &full,
                                    const std::vector<std::vector<Silhouette>> &boxes,
                                    const std::vector<double> &usefulness, double amount) {
  std::vector<double> pixels; // in full
  double all = 0;
  for (size_t k = 0; k < full.size(); k++) {
    pixels.push_back(mean_area(boxes, k) * full[k].destination.width * full[k].destination.height /
                     (double(full[k].source.width) * full[k].source.height));
    all += pixels.back();
  }
  // What a camera cannot use is shared out among the others: the water level that gives amount * all.
  const auto total = [&](double level) {
    double sum = 0;
    for (size_t k = 0; k < full.size(); k++) sum += std::min(pixels[k], level * usefulness[k]);
    return sum;
  };
  double low = 0, high = 1;
  for (size_t k = 0; k < full.size(); k++) high = std::max(high, pixels[k] / usefulness[k]);
  for (int i = 0; i < 60; i++) (total((low + high) / 2) < amount * all ? low : high) = (low + high) / 2;
  std::vector<fvv_tile> out = full;
  for (size_t k = 0; k < full.size(); k++) {
    const double scale = std::sqrt(std::min(1.0, high * usefulness[k] / pixels[k]));
    const double part = std::clamp(std::floor(scale * steps + 1e-6), 1.0, double(steps)) / steps;
    const auto side = [&](uint16_t size) { return uint16_t(std::max(1.0, std::round(size * part))); };
    out[k].destination.width = side(full[k].destination.width);
    out[k].destination.height = side(full[k].destination.height);
  }
  return out;
}

} // namespace fvv::mux
