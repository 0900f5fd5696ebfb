// fvvserve/access.h: who may ask. A page elsewhere reaches a server on this machine through the user's
// browser: under a name of its own that was bound to 127.0.0.1 (DNS rebinding), or by a WebSocket, which no
// same-origin rule stops. Knows header values, no socket.
#pragma once

#include "fvvserve/options.h"

#include <string_view>

namespace fvv::serve {

// host: value of the Host header, with or without port. Allowed are localhost and names below it, every IP
// address (rebinding needs a name), and Options::allow_host.
bool host_allowed(const Options &options, std::string_view host);

// origin: value of the Origin header; empty: none was sent, as programs other than browsers do. Allowed are
// the same origin (http, and host and port of the Host header) and Options::allow_origin.
bool origin_allowed(const Options &options, std::string_view origin, std::string_view host);

// The value of Access-Control-Allow-Origin, or empty.
std::string_view cors_origin(const Options &options, std::string_view origin);

} // namespace fvv::serve
