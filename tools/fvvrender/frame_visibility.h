// What the cameras of a frame see of its mesh, as the stream's visibility tracks have it. Knows streams;
// draws nothing.
#pragma once

#include "fvv/stream.h"

#include <string>
#include <vector>

namespace fvv::rendering {

// What one camera sees around each vertex of the frame's mesh (fvv_visibility_weights).
struct CameraWeights {
  uint16_t camera;
  uint8_t domain; // that they come from: FVV_VISIBILITY_...
  std::vector<uint8_t> weights;
};

// Of all tracks that speak of mesh, which is that of the frame on that track; of a camera that two of them
// have, faces are taken. A track that is lost or unknown adds a line to losses. where: in front of these
// lines. Throws Error when reading fails.
std::vector<CameraWeights> load_visibility(fvv_stream *stream, size_t frame, const fvv_mesh &mesh,
                                           const fvv_configuration &configuration, uint16_t mesh_track,
                                           const std::string &where, std::vector<std::string> &losses);

} // namespace fvv::rendering
