#include "fvvserve/access.h"

#include <algorithm>
#include <arpa/inet.h>

namespace fvv::serve {

namespace {

bool same_text(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() > end.size() && same_text(text.substr(text.size() - end.size()), end);
}

// "name:port" without port; "" when what stands behind the name is no port.
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

} // namespace fvv::serve
