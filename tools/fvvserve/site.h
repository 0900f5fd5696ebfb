// fvvserve/site.h: from the path of a request to an open file below the root, and never to another one. Knows
// the file system; knows no HTTP but the spelling of paths.
#pragma once

#include "fvvserve/ranges.h"

#include <optional>
#include <string>
#include <string_view>

namespace fvv::serve {

// A file descriptor that closes itself.
class Descriptor {
public:
  explicit Descriptor(int number = -1) : value(number) {}
  Descriptor(Descriptor &&other) noexcept : value(other.release()) {}
  Descriptor &operator=(Descriptor &&other) noexcept;
  ~Descriptor();
  int get() const { return value; }
  int release();

private:
  int value;
};

// The path of a request target (origin form, query already cut off), percent-decoded, without the leading
// slash. Nothing for what is malformed or could mean two things: NUL and control characters, an encoded
// slash, a backslash, empty segments, and segments that begin with a dot, which covers "." and ".." and
// hidden files.
std::optional<std::string> decode_path(std::string_view path);

struct SiteFile {
  Descriptor descriptor;
  uint64_t size = 0;
  Validators validators;
  const char *type = ""; // media type
};

enum class Lookup { found, missing, folder }; // folder: the same with a slash behind is what is meant

class Site {
public:
  // Throws Error when root is no folder that can be read.
  explicit Site(const std::string &root);
  // decoded: from decode_path. A folder is its index.html. Links may lead anywhere below the root; what lies
  // outside of it is missing, whatever leads there, since it is the opened file that is asked where it lies.
  Lookup open(const std::string &decoded, SiteFile &file) const;

private:
  std::string root; // real path
};

} // namespace fvv::serve
