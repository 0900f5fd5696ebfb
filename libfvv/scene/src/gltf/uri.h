// The two kinds of URI that a buffer may have, read so that an untrusted file can only refer to its own
// folder.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace fvv::scene::gltf {

// The bytes of a base64 data: URI (RFC 2397, RFC 4648 clause 4). None if it is not exactly that.
std::optional<std::string> data_uri(std::string_view uri);
bool is_data_uri(std::string_view uri);

// The file that a relative URI names, percent-encoding resolved. None for a scheme, an absolute path, a
// backslash, a segment "..", NUL, or a malformed escape.
std::optional<std::string> relative_file(std::string_view uri);

} // namespace fvv::scene::gltf
