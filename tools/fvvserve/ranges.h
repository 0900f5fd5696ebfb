// fvvserve/ranges.h: conditional and partial requests, as RFC 9110 clauses 8.8, 13 and 14 say. Knows header
// values and the validators of a file; knows no file and no socket.
#pragma once

#include <cstdint>
#include <ctime>
#include <string>
#include <string_view>

namespace fvv::serve {

// What tells one state of a file from another.
struct Validators {
  std::string etag; // strong, with its quotes
  std::time_t modified = 0;
};

// What the request says; empty: the header is absent.
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

} // namespace fvv::serve
