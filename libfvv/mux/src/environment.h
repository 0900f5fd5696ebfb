// The environment of a capture as the payload of a BACK chunk.
#pragma once

#include "fvv_scene/capture.h"
#include "fvv_scene/environment.h"

#include <memory>
#include <string>
#include <vector>

namespace fvv::mux {

struct PackedEnvironment {
  std::vector<uint8_t> payload;
  geometry::Lattice lattice = {{0, 0, 0}, 0.001};
  std::string reason; // of its step
  size_t parts = 0, pictures = 0, lights = 0;
  uint64_t vertices = 0, faces = 0;
  uint64_t mesh_bytes = 0, picture_bytes = 0;
  double max_error = 0;              // metres, on each axis
  std::vector<std::string> warnings; // what was left out or reduced
};

// A picture file of an environment converted for a stream: without the metadata of cameras and editors, and
// no larger than every reader supports.
struct FittedPicture {
  std::string file;
  uint32_t width = 0, height = 0;
  bool scaled = false; // larger than max_picture_side: made smaller, and JPEG at quality 92
};
// name: of the file, for messages. Throws Error if it is not a picture.
FittedPicture fit_picture(const std::string &file, const std::string &name, const media::MemoryLimit &limit);

// The environment must be there. Throws Error.
std::shared_ptr<const PackedEnvironment> pack_environment(const scene::Capture &capture);

} // namespace fvv::mux
