// What the cameras of a frame see of its mesh, as the stream's visibility tracks have it. Knows streams;
// draws nothing.
#pragma once

#include "fvv/stream.h"

#include <string>
#include <vector>

namespace fvv::rendering {

// Bits of one camera: one entry for each face or vertex of the frame's mesh, 1: seen.
struct CameraBits {
  uint16_t camera;
  uint8_t domain; // FVV_VISIBILITY_FACES or FVV_VISIBILITY_VERTICES
  std::vector<uint8_t> seen;
};

// Of all tracks that speak of the mesh on that track; of a camera that two of them have, faces are taken. A
// track that is lost or unknown adds a line to losses. where: in front of these lines. Throws cli::Failure
// when reading fails.
std::vector<CameraBits> load_visibility(fvv_stream *stream, size_t frame,
                                        const fvv_configuration &configuration, uint16_t mesh_track,
                                        const std::string &where, std::vector<std::string> &losses);

} // namespace fvv::rendering
