// The tracked mesh with texture coordinates, and its texture map: the surface cut into charts, their layout
// in one square picture, and the solid textures baked into it, once for all frames.
#pragma once

#include "fvv_geometry/hull.h"
#include "fvv_media/image.h"
#include "fvv_render/picture.h"
#include "fvvsynth/scene.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace fvv::synth {

using hull::Surface;
using render::Mat3;
using render::Vec3;

using Flat = std::array<double, 2>;

// The orthographic projection of a piece of surface on a plane with the unit vectors right and up.
struct Chart {
  std::vector<uint32_t> faces; // connected; counter-clockwise on the plane, as seen from outside
  Vec3 right, up;

  Flat flat(Vec3 p) const { return {dot(p, right), dot(p, up)}; }
};

// Every face is in one chart. region: of each face, an index of axes; a chart lies in one region, and it is
// projected along one of its region's axes, which are orthonormal (y is up in most of its charts). Areas
// shrink to 1 / sqrt(3) at least where a face has its own nearest axis, and to 0.36 at least where it was
// given that of its neighbours, for fewer and smoother borders. Every face must have area. Triangles of a
// chart overlap nowhere; two of them that do, like a sleeve before an arm, go to different charts.
std::vector<Chart> make_charts(const Surface &surface, const std::vector<uint8_t> &region,
                               const std::vector<Mat3> &axes);

// Texels between a chart and the edge of its rectangle: enough for bilinear sampling, and for 4:2:0 chroma.
constexpr uint32_t chart_margin = 4;

struct ChartBox { // of a chart, in texels from the top left corner of the picture, margins included
  uint32_t x, y, width, height;
};

struct Layout {
  uint32_t size;                // texels of each side of the picture
  double density;               // texels per metre of the charts' planes, the same for all
  std::vector<ChartBox> places; // of the charts, which do not overlap
  // The surface, opened at the borders of charts: of each vertex the one that it is a copy of. First come all
  // vertices of the surface in their order, after them further copies.
  std::vector<uint32_t> source;
  std::vector<uint32_t> faces; // as the surface's, of these vertices
  std::vector<Flat> texels;    // of each vertex: x to the right and y down from the top left corner
};

// As dense as it fits. Throws std::invalid_argument when size is too small for the margins alone, or above
// 16384.
Layout lay_out(const Surface &surface, const std::vector<Chart> &charts, uint32_t size);

// The colour (linear) of a face at weights of its three corners that add up to 1.
using Paint = std::function<render::Rgb(uint32_t face, const std::array<double, 3> &weights)>;

// See make_atlas (atlas.h). paint is called from several threads.
media::Image bake(const std::vector<Chart> &charts, const Layout &layout, const Paint &paint,
                  uint32_t threads);

constexpr uint32_t default_atlas_size = 1024;

struct Atlas {
  std::vector<Chart> charts;
  Layout layout;        // of the faces of Scene::faces()
  media::Image picture; // diffuse reflectance alone, as display values

  // Attributes of the scene's vertices, in groups of per numbers, for the layout's vertices.
  template <class Value> std::vector<Value> opened(const std::vector<Value> &values, size_t per) const {
    std::vector<Value> result;
    result.reserve(layout.source.size() * per);
    for (const uint32_t vertex : layout.source)
      result.insert(result.end(), values.begin() + ptrdiff_t(vertex * per),
                    values.begin() + ptrdiff_t((vertex + 1) * per));
    return result;
  }
};

// size: texels of each side; throws std::invalid_argument as lay_out does. A texel is the mean, in linear
// light, of the solid texture at those of 4 x 4 points in it that belong to a face. Colours go on unchanged
// through the margins of charts; what is left is filled smoothly, which costs a codec little. The result is
// the same for any number of threads.
Atlas make_atlas(const Scene &scene, uint32_t size, uint32_t threads);

} // namespace fvv::synth
