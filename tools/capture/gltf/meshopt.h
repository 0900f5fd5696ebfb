// capture/gltf/meshopt.h: bufferViews that are compressed (glTF extensions EXT_meshopt_compression and
// KHR_meshopt_compression), by meshoptimizer. Knows bytes of one view; knows no buffer and no accessor.
//
// Of KHR_meshopt_compression it reads what EXT_meshopt_compression has too: not the filter COLOR, and
// attributes of version 1 only where the library does.
#pragma once

#include "capture/strict_json.h"

#include <string>
#include <string_view>

namespace fvv::capture::gltf {

// What the extension of a view declares.
struct Compressed {
  JsonValue extension;
  uint64_t stride, count;                          // bytes of an element, elements
  uint64_t size() const { return stride * count; } // bytes when decoded
};

// The extension of a view, if it has one: mode, filter, stride and count fit each other and the view.
std::optional<Compressed> compression_of(const JsonValue &view);

// The view's bytes. Before anything is allocated, count is held against the bytes that carry it: at most 64
// bytes come out for one that goes in. FileError at the extension when they do not decode.
std::string decompress(const Compressed &compressed, std::string_view bytes);

} // namespace fvv::capture::gltf
