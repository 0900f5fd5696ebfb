// fvvserve/reply.h: what is answered to one request of HTTP, but for WebSocket. Knows headers, policies and
// the site; knows no socket, so that it can't wait.
#pragma once

#include "fvvserve/options.h"
#include "fvvserve/site.h"

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

namespace fvv::serve {

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

// The header of a reply without the file: checks what holds for every request, WebSocket too. Answers nothing
// when the request may go on.
std::optional<Reply> refuse(const Options &options, const Request &request);

// site NULL: nothing is served but WebSocket.
Reply reply_to(const Options &options, const Site *site, const Request &request);

// Path of a request target, without query; of the absolute form too (RFC 9112 clause 3.2.2).
std::string_view path_of(const Request &request);

} // namespace fvv::serve
