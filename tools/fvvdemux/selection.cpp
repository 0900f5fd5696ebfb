#include "fvvdemux/selection.h"

#include "cli/cli.h"

#include <algorithm>
#include <charconv>

namespace fvv::demux {

namespace {

constexpr int64_t most = INT32_MAX;

bool take_number(const char *&at, const char *end, int64_t &number) {
  const auto result = std::from_chars(at, end, number);
  // from_chars takes a minus sign, a list has none.
  if (result.ec != std::errc() || *at == '-' || number > most) return false;
  at = result.ptr;
  return true;
}

} // namespace

Selection Selection::parse(const std::string &option, const std::string &text) {
  std::vector<Range> found;
  const char *at = text.data(), *const end = at + text.size();
  bool good = at != end;
  while (good) {
    Range range;
    good = take_number(at, end, range.first);
    range.last = range.first;
    if (good && at != end && *at == '-')
      good = take_number(++at, end, range.last) && range.first <= range.last;
    if (!good) break;
    found.push_back(range);
    if (at == end) break;
    good = *at++ == ',';
  }
  if (!good)
    throw cli::Failure(
        option + ": expected numbers from 0 to 2147483647 such as 0-9,25, found '" + text + "'", cli::usage);
  std::sort(found.begin(), found.end(), [](const Range &a, const Range &b) { return a.first < b.first; });
  Selection out;
  for (const Range &range : found)
    if (!out.ranges.empty() && range.first <= out.ranges.back().last + 1)
      out.ranges.back().last = std::max(out.ranges.back().last, range.last);
    else
      out.ranges.push_back(range);
  return out;
}

bool Selection::has(int64_t number) const {
  return !within(number, number).empty();
}

std::vector<Selection::Range> Selection::within(int64_t first, int64_t last) const {
  if (first > last) return {};
  if (everything()) return {{first, last}};
  std::vector<Range> out;
  auto at =
      std::partition_point(ranges.begin(), ranges.end(), [&](const Range &r) { return r.last < first; });
  for (; at != ranges.end() && at->first <= last; ++at)
    out.push_back({std::max(first, at->first), std::min(last, at->last)});
  return out;
}

} // namespace fvv::demux
