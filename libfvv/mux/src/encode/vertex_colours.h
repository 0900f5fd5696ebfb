// Colours that meshes bring for their vertices, brought to the vertices of the stream.
#pragma once

#include "mux/src/meshes/meshes.h"

#include <optional>

namespace fvv::mux {

// Three bytes for each place: of the nearest place on the source's surface. metres: places, which count from
// origin_of(lattice).
std::vector<uint8_t> transferred(const geometry::Mesh &source, const std::vector<uint8_t> &colours,
                                 const std::vector<float> &metres, const geometry::Lattice &lattice);

// Decoders show the colours of a key mesh on its delta frames, too. Finds frames whose own colours differ so
// much from those that they have to be key frames. Without colours of vertices in the stream it finds none.
class KeyColours {
public:
  // plan and key are borrowed. frame: counted from 0.
  KeyColours(const Plan &plan, size_t frame, const PreparedMesh &key);

  // Whether they may be shown in another frame of the same connectivity.
  bool serve(size_t frame, const PreparedMesh &mesh);

private:
  const Plan &plan;
  const PreparedMesh &key;
  geometry::Mesh source; // as in the file
  std::vector<uint8_t> colours;
  std::optional<std::vector<uint8_t>> of_key; // on its vertices; made when first needed
};

} // namespace fvv::mux
