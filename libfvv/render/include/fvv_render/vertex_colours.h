// The colour of each vertex of a mesh, from the pictures of the cameras that see it.
#pragma once

#include "fvv_render/rasteriser.h"

#include <memory>

namespace fvv::render {

// A camera's picture. Borrowed.
struct ColourView {
  fvv_camera camera;             // valid; its pixels are those of the picture
  const uint8_t *pixels;         // R, G, B, display values, width x height, rows from the top
  const uint8_t *mask = nullptr; // a byte a pixel, above 127 where it shows the scene; NULL: everywhere
  // An entry for each vertex, 0 to 255: how much of the surface around it the camera sees
  // (fvv_visibility_weights); NULL: rays decide.
  const uint8_t *seen = nullptr;
};

struct VertexColours {
  std::vector<uint8_t> rgb; // three a vertex, display values
  std::vector<uint8_t>
      weight; // one a vertex: how well the cameras show it; 0: it has its colour from around it
};

// Gathers colours from one view after the other. A vertex has the mean of the cameras that show it well, by
// the cosine between its normal and the ray; cameras that differ much from the others count little. Samples
// next to the silhouette, next to surface that the camera does not see, and at grazing angles are used only
// where there are no others: their colours are mixed with what lies behind. Vertices that no camera shows
// take their colours from their neighbours on the surface; a piece that no camera shows at all, from all
// others; grey without any camera. The same on every machine.
class VertexColourGatherer {
public:
  explicit VertexColourGatherer(const Mesh &mesh); // borrowed
  ~VertexColourGatherer();

  // Takes what it needs of the view. The order of views may change the last bits of colours.
  void add(const ColourView &view);
  VertexColours colours() const;

private:
  struct State;
  std::unique_ptr<State> state;
};

} // namespace fvv::render
