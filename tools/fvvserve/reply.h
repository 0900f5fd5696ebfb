// The reply to one HTTP request other than WebSocket, and its access control. A page elsewhere reaches a
// server on this machine through the user's browser: under a name of its own that was bound to 127.0.0.1 (DNS
// rebinding), or by a WebSocket, which no same-origin rule stops.
#pragma once

#include "fvvserve/options.h"
#include "fvvserve/site.h"

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

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

using Request = boost::beast::http::request<boost::beast::http::empty_body>;

// The header and a short body as they go out, then count bytes of a file from first on.
struct Reply {
  unsigned status = 0;
  std::string text;
  Descriptor file;
  uint64_t first = 0, count = 0;
  bool keep_alive = false;
};

// A refusal or an error in one line of plain text; the headers that every reply has are added.
Reply plain_reply(const Request &request, unsigned status, const std::string &line, bool keep_alive);

// The header of a reply without the file: checks what holds for every request, WebSocket too. Returns nothing
// when the request may go on.
std::optional<Reply> refuse(const Options &options, const Request &request);

// site NULL: only WebSocket is served.
Reply reply_to(const Options &options, const Site *site, const Request &request);

// Path of a request target, without query; of the absolute form too (RFC 9112 clause 3.2.2).
std::string_view path_of(const Request &request);

} // namespace fvv::serve
