// From the path of a request to an open file below the root, and never to another one; the part of it that
// conditional and partial requests select (RFC 9110 clauses 8.8, 13 and 14).
#pragma once

#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <string_view>

namespace fvv::serve {

// Validators of a file's state.
struct Validators {
  std::string etag; // strong, with its quotes
  std::time_t modified = 0;
};

// Headers of the request; empty: absent.
struct Conditions {
  std::string_view if_match, if_none_match, if_modified_since, if_unmodified_since, if_range, range;
};

// Bytes first ... first + count - 1 of a file; status 200, 206, 304, 412 or 416.
struct Selection {
  unsigned status;
  uint64_t first, count;
};

// Order of evaluation: RFC 9110 clause 13.2.2. head: Range has no meaning (14.2). A header that is not valid,
// a unit other than bytes, and more than one range are passed over, as clause 14.2 allows: status 200.
Selection select(const Conditions &conditions, const Validators &validators, uint64_t size, std::time_t now,
                 bool head);

std::string http_date(std::time_t time);

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
// slash. None if it is malformed or ambiguous: NUL and control characters, an encoded slash, a backslash,
// empty segments, and segments that begin with a dot, which covers "." and ".." and hidden files.
std::optional<std::string> decode_path(std::string_view path);

struct SiteFile {
  Descriptor descriptor;
  uint64_t size = 0;
  Validators validators;
  const char *type = ""; // media type
};

enum class Lookup {
  found,
  missing,
  folder, // the path lacks a slash at its end
  busy    // no descriptor or no memory is free now
};

class Site {
public:
  // Throws Error when root is no folder that can be read. opened: a file anywhere that is /open/clip.fvv;
  // empty: none.
  Site(const std::string &root, std::string opened);
  // decoded: from decode_path. A folder is its index.html. Links may lead anywhere below the root; files
  // outside of it do not exist for requests, as the real path of the opened file is checked.
  Lookup open(const std::string &decoded, SiteFile &file) const;

private:
  bool may_serve(int descriptor) const;

  std::string root; // real path
  std::string opened;
};

} // namespace fvv::serve
