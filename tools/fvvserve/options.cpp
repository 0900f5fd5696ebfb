#include "fvvserve/options.h"

#include "cli/cli.h"

#include <algorithm>

namespace fvv::serve {

LiveInput parse_live(const std::string &text) {
  const size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  const bool good = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' || c == '_';
  });
  if (equals == std::string::npos || !good || equals + 1 == text.size())
    throw Error("--live: expected NAME=FILE with up to 64 letters, digits, - and _ in NAME, found '" + text +
                    "'",
                Error::usage);
  return {name, text.substr(equals + 1)};
}

std::string parse_origin(const std::string &text) {
  if (text == "*") return text;
  const size_t scheme = text.find("://");
  const std::string host = scheme == std::string::npos ? "" : text.substr(scheme + 3);
  const std::string before = text.substr(0, scheme == std::string::npos ? 0 : scheme);
  if ((before != "http" && before != "https") || host.empty() ||
      host.find_first_of("/?#@* ") != std::string::npos)
    throw Error("--allow-origin: expected http://HOST[:PORT], https://HOST[:PORT] or *, found '" + text + "'",
                Error::usage);
  std::string out = text;
  // A browser sends scheme and host in lower case.
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return out;
}

} // namespace fvv::serve
