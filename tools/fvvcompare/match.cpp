#include "fvvcompare/match.h"

#include <algorithm>

namespace fvv::compare {

namespace {

std::string text_of(fvv_rational duration) {
  return std::to_string(duration.numerator) + "/" + std::to_string(duration.denominator) + " s";
}

// What --frames and --start make of the numbers of A.
const Sequence::Frame &frame_of(const Sequence &a, int64_t number, const char *option) {
  const auto &list = a.frames();
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const auto &f) { return f.number == number; });
  if (found != list.end()) return *found;
  throw Error(std::string(option) + ": expected a frame of " + a.path() + ", which has " +
                  std::to_string(list.front().number) + " to " + std::to_string(list.back().number) +
                  ", found " + std::to_string(number),
              Error::usage);
}

// "a.fvv: 3 of 50 frames have no partner: 47 to 49"
void tell_alone(const Sequence &sequence, const std::vector<bool> &counts, const std::vector<bool> &met,
                std::vector<std::string> &warnings) {
  const auto &list = sequence.frames();
  scene::Gaps gaps(list.size() > 1 ? list[1].number - list[0].number : 1);
  size_t alone = 0, all = 0;
  for (size_t i = 0; i < list.size(); i++) {
    if (!counts[i]) continue;
    all++;
    if (met[i]) continue;
    alone++;
    gaps.add(list[i].number);
  }
  if (alone)
    warnings.push_back(sequence.path() + ": " + std::to_string(alone) + " of " + std::to_string(all) +
                       (alone == 1 ? " frames has no partner: " : " frames have no partner: ") + gaps.text());
}

} // namespace

Matching match(const Sequence &a, const Sequence &b, const std::optional<fvv::Range> &frames,
               std::optional<int64_t> start) {
  if (a.scale_unknown() != b.scale_unknown())
    throw Error("unlike units: " + a.path() + " is in " +
                (a.scale_unknown() ? "units of its source" : "metres") + ", " + b.path() + " in " +
                (b.scale_unknown() ? "units of its source" : "metres"));
  const fvv_rational one = a.frame_duration(), other = b.frame_duration();
  if (one.numerator != other.numerator || one.denominator != other.denominator)
    throw Error("unlike frame rates: a frame of " + a.path() + " lasts " + text_of(one) + ", one of " +
                b.path() + " " + text_of(other));
  const bool by_number = !start && !a.is_stream() && !b.is_stream();
  const int64_t shift = start ? frame_of(a, *start, "--start").place : 0;
  const auto key_of_a = [&](const Sequence::Frame &f) { return by_number ? f.number : f.place; };
  const auto key_of_b = [&](const Sequence::Frame &f) { return by_number ? f.number : f.place + shift; };
  int64_t first = INT64_MIN, last = INT64_MAX; // keys that are asked for
  if (frames) {
    first = key_of_a(frame_of(a, frames->first, "--frames"));
    last = key_of_a(frame_of(a, frames->last, "--frames"));
  }
  const auto &in_a = a.frames(), &in_b = b.frames();
  std::vector<bool> counts_a(in_a.size()), counts_b(in_b.size()), met_a(in_a.size()), met_b(in_b.size());
  const auto inside = [&](int64_t key) { return key >= first && key <= last; };
  for (size_t i = 0; i < in_a.size(); i++) counts_a[i] = inside(key_of_a(in_a[i]));
  for (size_t k = 0; k < in_b.size(); k++) counts_b[k] = inside(key_of_b(in_b[k]));
  Matching out;
  for (size_t i = 0, k = 0; i < in_a.size() && k < in_b.size();) {
    const int64_t left = key_of_a(in_a[i]), right = key_of_b(in_b[k]);
    if (left == right && counts_a[i]) {
      met_a[i] = met_b[k] = true;
      out.pairs.push_back({i, k});
    }
    i += left <= right;
    k += right <= left;
  }
  if (out.pairs.empty())
    throw Error(a.path() + " and " + b.path() +
                " have no frame in common; --start says which frame of the first is the second's first");
  tell_alone(a, counts_a, met_a, out.warnings);
  tell_alone(b, counts_b, met_b, out.warnings);
  return out;
}

} // namespace fvv::compare
