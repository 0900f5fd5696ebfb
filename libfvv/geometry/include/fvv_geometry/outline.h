// A surface as cameras show it, and how well its silhouette agrees with a mask.
#pragma once

#include "fvv_render/rasteriser.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace fvv::geometry {

// The same camera with a picture of another size.
fvv_camera resized(const fvv_camera &camera, uint32_t width, uint32_t height);

constexpr uint32_t outline_samples = 3;

// Triangles, brought near the origin and to a size of about 1: so neither float32 nor the rasteriser's near
// plane matters, wherever and in whatever unit the scene is.
class ViewedSurface {
public:
  ViewedSurface() = default; // nothing: covers no pixel
  // positions: three for each vertex; coordinates that are not finite are errors: std::invalid_argument.
  ViewedSurface(const std::vector<double> &positions, std::vector<uint32_t> faces);
  bool empty() const { return faces.empty(); }

  // Whether its faces alone say that their insides are out (fvv_render/normals.h).
  bool inside_out() const;

  // The face that each pixel's centre sees, or render::no_face.
  std::vector<uint32_t> nearest(const fvv_camera &camera) const;
  // One value for every pixel of the camera's picture: 255 when the surface covers the pixel's centre.
  std::vector<uint8_t> cover(const fvv_camera &camera) const;
  // How far each sample of a picture of that size is from the outline: from where the surface ends, and from
  // where it jumps in depth. In samples; outline_samples along each side of a pixel, row by row.
  std::vector<float> outline_distance(const fvv_camera &camera, uint32_t width, uint32_t height) const;

private:
  render::Projection projection(const fvv_camera &camera) const;
  render::Mesh mesh() const;

  double origin[3] = {0, 0, 0}, scale = 1;
  std::vector<float> positions; // (source - origin) * scale
  std::vector<uint32_t> faces;
};

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

} // namespace fvv::geometry
