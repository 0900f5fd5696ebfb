// What one frame, the sound and the environment of a stream hold, by the names of conformance/PROTOCOL.md,
// each as SHA-256.
#pragma once

#include "fvv/stream.h"

#include <nlohmann/json.hpp>

#include <set>
#include <string>

namespace fvv::conformance {

std::string sha256(const void *bytes, size_t size);

// Null: something of the frame does not decode.
nlohmann::json frame_arrays(fvv_stream *stream, size_t frame);
// By track: the packets of the chunks at some offsets. An object.
nlohmann::json sounds(fvv_stream *stream, std::set<uint64_t> offsets);
// By track: the environments of the last configuration. An object.
nlohmann::json environments(fvv_stream *stream);

} // namespace fvv::conformance
