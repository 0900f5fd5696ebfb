#include "fvvserve/reply.h"

#include <arpa/inet.h>

#include <algorithm>
#include <ctime>

namespace http = boost::beast::http;

namespace fvv::serve {

namespace {

bool same_text(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() > end.size() && same_text(text.substr(text.size() - end.size()), end);
}

// "name:port" without port; "" when what follows the name is no port.
std::string_view without_port(std::string_view host) {
  const size_t bracket = host.empty() || host[0] != '[' ? 0 : host.find(']');
  if (bracket == std::string_view::npos) return {};
  const size_t colon = host.find(':', bracket);
  if (colon == std::string_view::npos) return host;
  const std::string_view port = host.substr(colon + 1);
  return std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; })
             ? host.substr(0, colon)
             : std::string_view{};
}

bool is_address(std::string_view name) {
  unsigned char bytes[16];
  if (name.size() > 2 && name.front() == '[' && name.back() == ']')
    return inet_pton(AF_INET6, std::string(name.substr(1, name.size() - 2)).c_str(), bytes) == 1;
  return inet_pton(AF_INET, std::string(name).c_str(), bytes) == 1;
}

} // namespace

bool host_allowed(const Options &options, std::string_view host) {
  const std::string_view name = without_port(host);
  if (same_text(name, "localhost") || ends_with(name, ".localhost") || is_address(name)) return true;
  return std::any_of(options.allow_host.begin(), options.allow_host.end(),
                     [&](const std::string &allowed) { return same_text(name, allowed); });
}

bool origin_allowed(const Options &options, std::string_view origin, std::string_view host) {
  if (origin.empty() || !cors_origin(options, origin).empty()) return true;
  constexpr std::string_view scheme = "http://";
  return origin.size() > scheme.size() && same_text(origin.substr(0, scheme.size()), scheme) &&
         same_text(origin.substr(scheme.size()), host);
}

std::string_view cors_origin(const Options &options, std::string_view origin) {
  for (const std::string &allowed : options.allow_origin) {
    if (allowed == "*") return "*";
    if (!origin.empty() && same_text(allowed, origin)) return allowed;
  }
  return {};
}

namespace {

using Header = http::response_header<>;

constexpr const char *methods = "GET, HEAD, OPTIONS";
// Pages may run their own scripts and wasm, and nothing else: a decoder that needs more fails here.
constexpr const char *content_policy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; img-src 'self' data: "
    "blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

// Scheme and host of an absolute-form target; empty for the origin form.
std::string_view authority_of(const Request &request) {
  const std::string_view target(request.target().data(), request.target().size());
  constexpr std::string_view scheme = "http://";
  if (target.substr(0, scheme.size()) != scheme) return {};
  return target.substr(scheme.size(), target.find('/', scheme.size()) - scheme.size());
}

std::string_view field(const Request &request, http::field name) {
  const auto found = request.find(name);
  return found == request.end() ? std::string_view{}
                                : std::string_view(found->value().data(), found->value().size());
}

Header header_of(const Request &request, unsigned status, bool keep_alive) {
  Header header;
  header.version(11);
  header.result(status);
  header.set(http::field::date, http_date(std::time(nullptr)));
  header.set("X-Content-Type-Options", "nosniff");
  header.set("Referrer-Policy", "no-referrer");
  if (!keep_alive)
    header.set(http::field::connection, "close");
  else if (request.version() == 10)
    header.set(http::field::connection, "keep-alive");
  return header;
}

void add_cors(const Options &options, const Request &request, Header &header) {
  if (options.allow_origin.empty()) {
    header.set("Cross-Origin-Resource-Policy", "same-origin");
    return;
  }
  header.set(http::field::vary, "Origin");
  const std::string_view origin = cors_origin(options, field(request, http::field::origin));
  if (origin.empty()) return;
  header.set("Access-Control-Allow-Origin", boost::beast::string_view(origin.data(), origin.size()));
  header.set("Access-Control-Expose-Headers",
             "Accept-Ranges, Content-Length, Content-Range, ETag, Last-Modified");
  header.set("Cross-Origin-Resource-Policy", "cross-origin");
}

std::string text_of(const Header &header) {
  std::string out = "HTTP/1.1 " + std::to_string(header.result_int()) + " ";
  out.append(header.reason().data(), header.reason().size()) += "\r\n";
  for (const auto &line : header) {
    out.append(line.name_string().data(), line.name_string().size()) += ": ";
    out.append(line.value().data(), line.value().size()) += "\r\n";
  }
  return out += "\r\n";
}

Reply with_text(const Request &request, Header &header, const std::string &line, bool keep_alive) {
  const std::string body = line.empty() ? line : line + "\n";
  if (header.result_int() != 204) header.set(http::field::content_length, std::to_string(body.size()));
  if (!body.empty()) header.set(http::field::content_type, "text/plain; charset=utf-8");
  Reply reply;
  reply.status = header.result_int();
  reply.text = text_of(header) + (request.method() == http::verb::head ? "" : body);
  reply.keep_alive = keep_alive;
  return reply;
}

Reply preflight(const Options &options, const Request &request) {
  Header header = header_of(request, 204, request.keep_alive());
  header.set(http::field::allow, methods);
  add_cors(options, request, header);
  if (header.count("Access-Control-Allow-Origin")) {
    header.set("Access-Control-Allow-Methods", methods);
    header.set("Access-Control-Allow-Headers", "Range, If-Range, If-Match, If-None-Match, If-Modified-Since");
    header.set("Access-Control-Max-Age", "600");
  }
  return with_text(request, header, "", request.keep_alive());
}

Reply file_reply(const Options &options, const Request &request, SiteFile &file) {
  const Conditions conditions = {
      field(request, http::field::if_match),          field(request, http::field::if_none_match),
      field(request, http::field::if_modified_since), field(request, http::field::if_unmodified_since),
      field(request, http::field::if_range),          field(request, http::field::range)};
  const bool head = request.method() == http::verb::head, keep_alive = request.keep_alive();
  const Selection selected = select(conditions, file.validators, file.size, std::time(nullptr), head);
  Header header = header_of(request, selected.status, keep_alive);
  add_cors(options, request, header);
  header.set(http::field::accept_ranges, "bytes");
  header.set(http::field::etag, file.validators.etag);
  header.set(http::field::last_modified, http_date(file.validators.modified));
  // Copies have to be revalidated: files change during development.
  header.set(http::field::cache_control, "no-cache");
  const std::string size = std::to_string(file.size);
  if (selected.status == 416) header.set(http::field::content_range, "bytes */" + size);
  if (selected.status == 412 || selected.status == 416)
    return with_text(request, header, std::string(header.reason()), keep_alive);
  Reply reply;
  reply.status = selected.status;
  reply.keep_alive = keep_alive;
  if (selected.status != 304) {
    header.set(http::field::content_type, file.type);
    header.set(http::field::content_length, std::to_string(selected.count));
    if (std::string_view(file.type).substr(0, 9) == "text/html")
      header.set("Content-Security-Policy", content_policy);
    if (selected.status == 206)
      header.set(http::field::content_range, "bytes " + std::to_string(selected.first) + "-" +
                                                 std::to_string(selected.first + selected.count - 1) + "/" +
                                                 size);
    if (!head) {
      reply.file = std::move(file.descriptor);
      reply.first = selected.first;
      reply.count = selected.count;
    }
  }
  reply.text = text_of(header);
  return reply;
}

} // namespace

std::string_view path_of(const Request &request) {
  const std::string_view authority = authority_of(request);
  std::string_view path(request.target().data(), request.target().size());
  if (!authority.empty()) path.remove_prefix(std::string_view("http://").size() + authority.size());
  return path.substr(0, path.find('?'));
}

Reply plain_reply(const Request &request, unsigned status, const std::string &line, bool keep_alive) {
  Header header = header_of(request, status, keep_alive);
  return with_text(request, header, line, keep_alive);
}

std::optional<Reply> refuse(const Options &options, const Request &request) {
  // Exactly one: RFC 9112 clause 3.2.
  const size_t hosts = request.count(http::field::host);
  if (hosts > 1 || (hosts == 0 && request.version() >= 11) ||
      (hosts == 1 && field(request, http::field::host).empty()))
    return plain_reply(request, 400, "a request has one Host header, which names a host", false);
  // Of two, a proxy may judge one and this server the other: RFC 6454 clause 7.3.
  const size_t origins = request.count(http::field::origin);
  if (origins > 1 || (origins == 1 && field(request, http::field::origin).empty()))
    return plain_reply(request, 400, "a request has one Origin header at most, which is not empty", false);
  const std::string_view authority = authority_of(request);
  const std::string_view host = authority.empty() ? field(request, http::field::host) : authority;
  if (!host.empty() && !host_allowed(options, host))
    return plain_reply(request, 421, "this host name is not served here; --allow-host allows it", false);
  return std::nullopt;
}

Reply reply_to(const Options &options, const Site *site, const Request &request) {
  const bool keep_alive = request.keep_alive();
  if (request.method() == http::verb::options) return preflight(options, request);
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    Header header = header_of(request, 405, false);
    header.set(http::field::allow, methods);
    return with_text(request, header, "expected GET, HEAD or OPTIONS", false);
  }
  SiteFile file;
  const auto path = decode_path(path_of(request));
  const Lookup lookup = site && path ? site->open(*path, file) : Lookup::missing;
  if (lookup == Lookup::found) return file_reply(options, request, file);
  if (lookup == Lookup::busy) {
    // Closed, which gives a descriptor back.
    Header header = header_of(request, 503, false);
    add_cors(options, request, header);
    header.set(http::field::retry_after, "5");
    return with_text(request, header, "no file can be opened now", false);
  }
  Header header = header_of(request, lookup == Lookup::folder ? 301 : 404, keep_alive);
  add_cors(options, request, header);
  if (lookup == Lookup::missing) return with_text(request, header, "not found", keep_alive);
  // As received, still encoded. It begins with one slash: decode_path refuses "//host".
  header.set(http::field::location, std::string(path_of(request)) + "/");
  return with_text(request, header, "", keep_alive);
}

} // namespace fvv::serve
