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
  std::optional<capture::Lattice> lattice; // the finest of all tracks'; nothing: there was no background
};

// What belongs to a group on all background tracks together (fvv.md clause 18.1). Appends to lost a text for
// each track that is damaged, of which nothing is taken.
UnpackedBackground unpack_background(fvv_stream *stream, size_t group, const fvv_configuration &configuration,
                                     std::vector<std::string> &lost);

} // namespace fvv::demux
