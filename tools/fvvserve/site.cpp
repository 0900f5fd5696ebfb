#include "fvvserve/site.h"

#include "cli/cli.h"

#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace fvv::serve {

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
// told apart.
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

Site::Site(const std::string &folder) {
  char *real = realpath(folder.c_str(), nullptr);
  if (!real) throw Error("--root: " + folder + ": cannot open: " + std::strerror(errno));
  root = real;
  std::free(real);
  struct stat status;
  if (stat(root.c_str(), &status) != 0 || !S_ISDIR(status.st_mode))
    throw Error("--root: " + folder + ": is not a folder");
}

Lookup Site::open(const std::string &decoded, SiteFile &file) const {
  std::string path = decoded;
  if (path.empty() || path.back() == '/') path += "index.html";
  // Without O_NONBLOCK a FIFO below the root would hold the server.
  Descriptor descriptor(::open((root + "/" + path).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat status;
  if (descriptor.get() < 0 || fstat(descriptor.get(), &status) != 0) return Lookup::missing;
  const std::string inside = root == "/" ? root : root + "/";
  const auto place = place_of(descriptor.get());
  if (!place || place->compare(0, inside.size(), inside) != 0) return Lookup::missing;
  // A link to a hidden file is no way to it.
  if (place->find("/.", root.size()) != std::string::npos) return Lookup::missing;
  if (S_ISDIR(status.st_mode)) return Lookup::folder;
  if (!S_ISREG(status.st_mode)) return Lookup::missing;
  file.descriptor = std::move(descriptor);
  file.size = static_cast<uint64_t>(status.st_size);
  file.validators = {etag_of(status), status.st_mtim.tv_sec};
  file.type = type_of(path);
  return Lookup::found;
}

} // namespace fvv::serve
