// fvvmux/background.h: the environment of a capture as the payload of a BACK chunk. Knows lattices, mesh
// codecs and picture files; knows nothing of frames.
#pragma once

#include "capture/capture.h"
#include "capture/environment.h"

#include <memory>
#include <nlohmann/json.hpp>

namespace fvv::mux {

struct PackedBackground {
  std::vector<uint8_t> payload;
  capture::Lattice lattice = {{0, 0, 0}, 0.001};
  std::string reason; // of its step
  size_t parts = 0, pictures = 0, lights = 0;
  uint64_t vertices = 0, faces = 0;
  uint64_t mesh_bytes = 0, picture_bytes = 0;
  double max_error = 0;              // metres, on each axis
  std::vector<std::string> warnings; // what was left out or made smaller
};

// For people, and for --json.
std::string background_text(const PackedBackground &background);
nlohmann::ordered_json background_json(const PackedBackground &background, uint64_t chunks);

// The environment must be there. Throws cli::Failure, capture::FileError, media::Error.
std::shared_ptr<const PackedBackground> pack_background(const capture::Capture &capture);

} // namespace fvv::mux
