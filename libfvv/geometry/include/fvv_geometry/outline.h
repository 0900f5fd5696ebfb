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

// Triangles, moved near the origin and scaled to a size of about 1, so that float32 and the near plane of the
// rasteriser are adequate for scenes at any place and in any unit.
class ViewedSurface {
public:
  ViewedSurface() = default; // empty: covers no pixel
  // positions: three for each vertex; coordinates that are not finite are errors: std::invalid_argument.
  ViewedSurface(const std::vector<double> &positions, std::vector<uint32_t> faces);
  bool empty() const { return faces.empty(); }

  // Whether its faces alone show that they are inside out (fvv_render/normals.h).
  bool inside_out() const;

  // The face that each pixel's centre sees, or render::no_face.
  std::vector<uint32_t> nearest(const fvv_camera &camera) const;
  // One value for every pixel of the camera's picture: 255 when the surface covers the pixel's centre.
  std::vector<uint8_t> cover(const fvv_camera &camera) const;
  // The distance of each sample of a picture of that size from the outline: from where the surface ends or
  // jumps in depth. In samples; outline_samples along each side of a pixel, row by row.
  std::vector<float> outline_distance(const fvv_camera &camera, uint32_t width, uint32_t height) const;

private:
  render::Projection projection(const fvv_camera &camera,
                                render::Projection::Rays rays = render::Projection::Rays::traced) const;
  render::Mesh mesh() const;

  double origin[3] = {0, 0, 0}, scale = 1;
  std::vector<float> positions; // (source - origin) * scale
  std::vector<uint32_t> faces;
};

// Intersection over union of two masks of one size, nonzero inside; none if both are empty.
std::optional<double> silhouette_iou(const std::vector<uint8_t> &a, const std::vector<uint8_t> &b);

// Masks are width x height, row by row, nonzero inside.
struct SilhouetteMatch {
  std::optional<double> iou; // silhouette_iou()
  // Mean distance of the outlines in pixels, averaged over both directions. The border of the picture is no
  // outline. The picture's diagonal if only one has an outline, none if neither has.
  std::optional<double> distance;
  // The offset of the projected outline from the mask's, in pixels right and down. None if the outlines do
  // not determine it (too short, straight, or far apart).
  std::optional<std::array<double, 2>> offset;
};

SilhouetteMatch compare(const std::vector<uint8_t> &projected, const std::vector<uint8_t> &mask,
                        uint32_t width, uint32_t height);

// Where a projected surface and a mask of the same camera differ, in pixels.
struct MaskDifference {
  double length = 0;            // of the mask's outline
  double missed = 0, extra = 0; // of the mask, not covered; covered, outside of the mask
  double far = 0;               // of these, further from the mask's outline than a limit
};
// Masks are width x height, row by row, nonzero inside.
MaskDifference difference(const std::vector<uint8_t> &projected, const std::vector<uint8_t> &mask,
                          uint32_t width, uint32_t height, double far);

// The match of one camera and the diagonal of its picture, relative to which distances are compared between
// cameras.
struct CameraMatch {
  SilhouetteMatch match;
  double diagonal; // pixels
};

// Indices of cameras whose distance exceeds twice the median of the other cameras' by more than a pixel, the
// worst first. Among fewer than three measured cameras there are no outliers.
std::vector<size_t> outlier_cameras(const std::vector<CameraMatch> &cameras);

enum class Suspicion {
  nothing,
  half_pixel, // all outlines lie half a pixel up and left, or down and right
  misses_all  // the mesh overlaps no mask
};
Suspicion suspect(const std::vector<CameraMatch> &cameras);

// None if there are no values. With an even number the mean of the middle two.
std::optional<double> median(std::vector<double> values);

} // namespace fvv::geometry
