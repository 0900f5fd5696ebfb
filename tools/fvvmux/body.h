// fvvmux/body.h: a surface as cameras show it: which pixels it covers, and its outline as a line to draw.
// Knows the rasteriser; knows no files and no pictures.
#pragma once

#include "fvv_media/image.h"
#include "fvv_render/rasteriser.h"

#include <vector>

namespace fvv::mux {

// The same camera with a picture of another size.
fvv_camera resized(const fvv_camera &camera, uint32_t width, uint32_t height);

// Triangles, brought near the origin and to a size of about 1: so neither float32 nor the rasteriser's near
// plane matters, wherever and in whatever unit the scene is.
class Body {
public:
  Body() = default; // nothing: covers no pixel
  // positions: three for each vertex; coordinates that are not finite are errors: std::invalid_argument.
  Body(const std::vector<double> &positions, std::vector<uint32_t> faces);
  bool empty() const { return faces.empty(); }

  // Whether its faces alone say that their insides are out (fvv_render/winding.h).
  bool inside_out() const;

  // The face that each pixel's centre sees, or render::no_face.
  std::vector<uint32_t> nearest(const fvv_camera &camera) const;
  // One value for every pixel of the camera's picture: 255 when the surface covers the pixel's centre.
  std::vector<uint8_t> cover(const fvv_camera &camera) const;
  // Draws the outline into a picture of the camera, a light line with dark rims: where the surface ends, and
  // where it jumps in depth.
  void draw_outline(const fvv_camera &camera, media::Image &image) const;

private:
  render::Projection projection(const fvv_camera &camera) const;
  render::Mesh mesh() const;

  double origin[3] = {0, 0, 0}, scale = 1;
  std::vector<float> positions; // (source - origin) * scale
  std::vector<uint32_t> faces;
};

} // namespace fvv::mux
