// The environment of a stream as capture::Environment: world metres, texture coordinates as places in the
// picture. Knows BACK records; writes no file.
#pragma once

#include "capture/environment.h"
#include "fvv/stream.h"

#include <optional>
#include <string>
#include <vector>

namespace fvv::demux {

struct UnpackedBackground {
  capture::Environment environment;
  capture::Lattice lattice;
};

// The first background track, NULL: none.
const fvv_track *background_track_of(const fvv_configuration &configuration,
                                     std::vector<std::string> *warnings);

// What belongs to a group on that track. Nothing: it has none; or it is damaged, and why tells.
std::optional<UnpackedBackground> unpack_background(fvv_stream *stream, size_t group, uint16_t track,
                                                    std::string &why);

} // namespace fvv::demux
