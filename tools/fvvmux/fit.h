// fvvmux/fit.h: how well the silhouette of a mesh agrees with a mask, and which cameras do worse than the
// others. Knows two masks at a time; knows no camera model, no mesh and no files.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace fvv::mux {

// Masks are width x height, row by row, nonzero inside.
struct Fit {
  // Intersection over union of the two silhouettes; nothing when both are empty.
  std::optional<double> iou;
  // Mean distance of the outlines in pixels, averaged over both directions. The border of the picture is no
  // outline. The picture's diagonal when one has an outline and the other has none, nothing when both lack
  // it.
  std::optional<double> distance;
  // By how many pixels, right and down, the projected outline should be moved back: where it lies as seen
  // from the mask's. Nothing when the outlines don't say (too short, straight, or far apart).
  std::optional<std::array<double, 2>> offset;
};

Fit compare(const std::vector<uint8_t> &projected, const std::vector<uint8_t> &mask, uint32_t width,
            uint32_t height);

// One camera's Fit and the diagonal of its picture, by which distances of unlike cameras are compared.
struct Measured {
  Fit fit;
  double diagonal; // pixels
};

// Indices of cameras whose distance is more than twice the median of the other cameras' plus a pixel, the
// worst first. Among fewer than three measured cameras none stands out.
std::vector<size_t> standing_out(const std::vector<Measured> &cameras);

enum class Suspicion {
  nothing,
  half_pixel, // all outlines lie half a pixel up and left, or down and right
  misses_all  // the mesh meets no mask
};
Suspicion suspect(const std::vector<Measured> &cameras);

// Of the values that are there; nothing when there are none. With an even number the mean of the middle two.
std::optional<double> median(std::vector<double> values);

} // namespace fvv::mux
