#include "fvv_demux/selection.h"
#include "fvv_cxx/error.h"

#include <algorithm>

namespace fvv::demux {

Selection Selection::parse(const std::string &option, const std::string &text) {
  std::vector<fvv::Range> found;
  bool good = true;
  for (size_t at = 0; good && at <= text.size();) {
    const size_t comma = std::min(text.find(',', at), text.size());
    const std::optional<fvv::Range> range = fvv::scan_range(std::string_view(text).substr(at, comma - at));
    good = range.has_value();
    if (good) found.push_back(*range);
    at = comma + 1;
  }
  if (!good)
    refuse_option(option, "expected numbers from 0 to 2147483647 such as 0-9,25, found '" + text + "'");
  std::sort(found.begin(), found.end(),
            [](const fvv::Range &a, const fvv::Range &b) { return a.first < b.first; });
  Selection out;
  for (const fvv::Range &range : found)
    if (!out.ranges.empty() && range.first <= out.ranges.back().last + 1)
      out.ranges.back().last = std::max(out.ranges.back().last, range.last);
    else
      out.ranges.push_back(range);
  return out;
}

bool Selection::has(int64_t number) const {
  return !within(number, number).empty();
}

std::vector<fvv::Range> Selection::within(int64_t first, int64_t last) const {
  if (first > last) return {};
  if (everything()) return {{first, last}};
  std::vector<fvv::Range> out;
  auto at =
      std::partition_point(ranges.begin(), ranges.end(), [&](const fvv::Range &r) { return r.last < first; });
  for (; at != ranges.end() && at->first <= last; ++at)
    out.push_back({std::max(first, at->first), std::min(last, at->last)});
  return out;
}

} // namespace fvv::demux
