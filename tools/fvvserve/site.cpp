#include "fvvserve/site.h"

#include "cli/cli.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>

namespace fvv::serve {

namespace {

constexpr const char *date_format = "%a, %d %b %Y %H:%M:%S GMT";

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

// Only the form that is to be sent (IMF-fixdate); others count as absent.
std::optional<std::time_t> parse_date(std::string_view text) {
  std::tm fields = {};
  const std::string copy(trimmed(text));
  const char *end = strptime(copy.c_str(), date_format, &fields);
  if (!end || *end) return std::nullopt;
  return timegm(&fields);
}

// Whether a list of entity tags contains that of the file. A weak tag fits only where the comparison is weak
// (8.8.3.2).
bool has_tag(std::string_view list, const std::string &etag, bool weak) {
  list = trimmed(list);
  if (list == "*") return true;
  while (!list.empty()) {
    const bool is_weak = list.substr(0, 2) == "W/";
    if (is_weak) list.remove_prefix(2);
    const size_t close = list.empty() || list[0] != '"' ? std::string_view::npos : list.find('"', 1);
    if (close == std::string_view::npos) return false;
    if (list.substr(0, close + 1) == etag && (weak || !is_weak)) return true;
    list = trimmed(list.substr(close + 1));
    if (list.empty() || list[0] != ',') return false;
    list = trimmed(list.substr(1));
  }
  return false;
}

// 1*DIGIT; what is too large for 64 bits is after the end of every file.
std::optional<uint64_t> parse_position(std::string_view text) {
  constexpr uint64_t largest = std::numeric_limits<uint64_t>::max();
  if (text.empty()) return std::nullopt;
  uint64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<uint64_t>(c - '0');
    value = value > (largest - digit) / 10 ? largest : value * 10 + digit;
  }
  return value;
}

Selection select_range(std::string_view range, uint64_t size) {
  const Selection whole = {200, 0, size}, unsatisfiable = {416, 0, 0};
  constexpr std::string_view unit = "bytes";
  const size_t equals = range.find('=');
  // Range units are case-insensitive (14.1).
  if (equals != unit.size() || !std::equal(unit.begin(), unit.end(), range.begin(), [](char a, char b) {
        return a == std::tolower(static_cast<unsigned char>(b));
      }))
    return whole;
  const std::string_view spec = trimmed(range.substr(equals + 1));
  const size_t dash = spec.find('-');
  if (dash == std::string_view::npos) return whole; // of a list the second dash or a comma is no digit
  const auto first = parse_position(spec.substr(0, dash)), last = parse_position(spec.substr(dash + 1));
  if (dash == 0) {
    if (!last) return whole;
    if (*last == 0) return unsatisfiable;
    if (size == 0) return whole; // satisfiable (14.1.2), but no Content-Range can say so
    const uint64_t count = std::min(*last, size);
    return {206, size - count, count};
  }
  if (!first || (!last && dash + 1 != spec.size()) || (last && *last < *first)) return whole;
  if (*first >= size) return unsatisfiable;
  return {206, *first, last ? std::min(*last - *first, size - *first - 1) + 1 : size - *first};
}

// A date is a strong validator only when a second change cannot have fallen into the same second (8.8.2.2).
bool range_holds(std::string_view if_range, const Validators &validators, std::time_t now) {
  if (if_range.empty()) return true;
  if (if_range.front() == '"') return if_range == validators.etag;
  const auto date = parse_date(if_range);
  return date && *date == validators.modified && validators.modified < now - 1;
}

} // namespace

Selection select(const Conditions &c, const Validators &validators, uint64_t size, std::time_t now,
                 bool head) {
  if (!c.if_match.empty()) {
    if (!has_tag(c.if_match, validators.etag, false)) return {412, 0, 0};
  } else if (const auto date = parse_date(c.if_unmodified_since)) {
    if (validators.modified > *date) return {412, 0, 0};
  }
  if (!c.if_none_match.empty()) {
    if (has_tag(c.if_none_match, validators.etag, true)) return {304, 0, 0};
  } else if (const auto date = parse_date(c.if_modified_since)) {
    if (validators.modified <= *date) return {304, 0, 0};
  }
  if (head || c.range.empty() || !range_holds(trimmed(c.if_range), validators, now)) return {200, 0, size};
  return select_range(trimmed(c.range), size);
}

std::string http_date(std::time_t time) {
  std::tm fields = {};
  gmtime_r(&time, &fields);
  char text[64];
  return {text, std::strftime(text, sizeof text, date_format, &fields)};
}

namespace {

struct MediaType {
  std::string_view extension;
  const char *type;
};

constexpr MediaType media_types[] = {
    {"fvv", "model/vnd.fvv"},
    {"wasm", "application/wasm"}, // or compileStreaming refuses it
    {"js", "text/javascript; charset=utf-8"},
    {"mjs", "text/javascript; charset=utf-8"},
    {"css", "text/css; charset=utf-8"},
    {"html", "text/html; charset=utf-8"},
    {"json", "application/json"},
    {"map", "application/json"},
    {"txt", "text/plain; charset=utf-8"},
    {"md", "text/plain; charset=utf-8"},
    {"png", "image/png"},
    {"jpg", "image/jpeg"},
    {"jpeg", "image/jpeg"},
    {"svg", "image/svg+xml"},
    {"ico", "image/x-icon"},
    {"ply", "model/ply"},
    {"obj", "model/obj"},
    {"glb", "model/gltf-binary"},
    {"gltf", "model/gltf+json"},
};

const char *type_of(std::string_view path) {
  const size_t dot = path.rfind('.');
  if (dot != std::string_view::npos && path.find('/', dot) == std::string_view::npos)
    for (const MediaType &known : media_types)
      if (path.substr(dot + 1) == known.extension) return known.type;
  return "application/octet-stream";
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool good_segments(std::string_view path) {
  while (!path.empty()) {
    const size_t slash = path.find('/');
    const std::string_view segment = path.substr(0, slash);
    if (segment.empty() || segment[0] == '.') return false;
    if (slash == std::string_view::npos) break;
    path.remove_prefix(slash + 1);
  }
  return true;
}

// Any change of the content changes one of these, also a file of the same size and age put in its place. The
// clock of a file system ticks every few milliseconds: two changes within one tick that keep the size are not
// distinguished.
std::string etag_of(const struct stat &status) {
  char text[96];
  std::snprintf(text, sizeof text, "\"%llx-%llx.%lx-%llx.%lx\"", (unsigned long long)status.st_size,
                (unsigned long long)status.st_mtim.tv_sec, (unsigned long)status.st_mtim.tv_nsec,
                (unsigned long long)status.st_ctim.tv_sec, (unsigned long)status.st_ctim.tv_nsec);
  return text;
}

std::optional<std::string> place_of(int descriptor) {
  char path[PATH_MAX];
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t length = readlink(link.c_str(), path, sizeof path);
  if (length <= 0 || static_cast<size_t>(length) >= sizeof path) return std::nullopt;
  return std::string(path, static_cast<size_t>(length));
}

} // namespace

Descriptor &Descriptor::operator=(Descriptor &&other) noexcept {
  std::swap(value, other.value);
  return *this;
}

Descriptor::~Descriptor() {
  if (value >= 0) close(value);
}

int Descriptor::release() {
  const int number = value;
  value = -1;
  return number;
}

std::optional<std::string> decode_path(std::string_view path) {
  if (path.empty() || path[0] != '/') return std::nullopt;
  std::string out;
  for (size_t i = 1; i < path.size(); i++) {
    unsigned char c = static_cast<unsigned char>(path[i]);
    if (c == '%') {
      const int high = i + 2 < path.size() ? hex_digit(path[i + 1]) : -1;
      const int low = i + 2 < path.size() ? hex_digit(path[i + 2]) : -1;
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<unsigned char>(high * 16 + low);
      i += 2;
      if (c == '/') return std::nullopt;
    }
    if (c < 32 || c == 127 || c == '\\') return std::nullopt;
    out += static_cast<char>(c);
  }
  if (!good_segments(out)) return std::nullopt;
  return out;
}

Site::Site(const std::string &folder, std::string file) : opened(std::move(file)) {
  char *real = realpath(folder.c_str(), nullptr);
  if (!real) throw Error("--root: " + folder + ": cannot open: " + std::strerror(errno));
  root = real;
  std::free(real);
  struct stat status;
  if (stat(root.c_str(), &status) != 0 || !S_ISDIR(status.st_mode))
    throw Error("--root: " + folder + ": is not a folder");
}

bool Site::may_serve(int descriptor) const {
  const std::string inside = root == "/" ? root : root + "/";
  const auto place = place_of(descriptor);
  if (!place || place->compare(0, inside.size(), inside) != 0) return false;
  // A link must not lead to a hidden file.
  return place->find("/.", root.size()) == std::string::npos;
}

Lookup Site::open(const std::string &decoded, SiteFile &file) const {
  std::string path = decoded;
  if (path.empty() || path.back() == '/') path += "index.html";
  const bool is_opened = !opened.empty() && path == "open/clip.fvv";
  // Without O_NONBLOCK a FIFO below the root would hold the server.
  Descriptor descriptor(
      ::open((is_opened ? opened : root + "/" + path).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat status;
  if (descriptor.get() < 0)
    return errno == EMFILE || errno == ENFILE || errno == ENOMEM ? Lookup::busy : Lookup::missing;
  if (fstat(descriptor.get(), &status) != 0) return Lookup::missing;
  if (!is_opened && !may_serve(descriptor.get())) return Lookup::missing;
  if (S_ISDIR(status.st_mode)) return Lookup::folder;
  if (!S_ISREG(status.st_mode)) return Lookup::missing;
  file.descriptor = std::move(descriptor);
  file.size = static_cast<uint64_t>(status.st_size);
  file.validators = {etag_of(status), status.st_mtim.tv_sec};
  file.type = type_of(path);
  return Lookup::found;
}

} // namespace fvv::serve
