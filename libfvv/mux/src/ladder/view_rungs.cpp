#include "mux/src/ladder/view_rungs.h"
#include "fvv_cxx/error.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

constexpr double most_of_better = 2.0 / 3; // of its bytes
constexpr size_t most_found = 4;           // rungs; more of them are hardly told apart

// Over logarithms: a player has a multiple of a bandwidth, not some bytes more.
double x_of(const RungCandidate &one) {
  return std::log(one.bytes);
}
double y_of(const RungCandidate &one) {
  return -std::log(one.error);
}

// Whether b lies on or below the line from a to c.
bool is_below(const RungCandidate &a, const RungCandidate &b, const RungCandidate &c) {
  return (y_of(b) - y_of(a)) * (x_of(c) - x_of(a)) >= (y_of(c) - y_of(a)) * (x_of(b) - x_of(a));
}

// From the first on to fewer bytes.
std::vector<RungCandidate> hull_of(const RungCandidate &first, const std::vector<RungCandidate> &by_bytes) {
  std::vector<RungCandidate> hull = {first};
  for (const RungCandidate &one : by_bytes) {
    while (hull.size() > 1 && is_below(hull[hull.size() - 2], hull.back(), one)) hull.pop_back();
    hull.push_back(one);
  }
  return hull;
}

} // namespace

std::vector<Rung> choose_view_rungs(const RungCandidate &first, std::vector<RungCandidate> candidates) {
  const auto is_useless = [&](const RungCandidate &one) {
    return !(one.bytes < first.bytes) || !(one.psnr < first.psnr);
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), is_useless), candidates.end());
  std::sort(candidates.begin(), candidates.end(), [](const RungCandidate &a, const RungCandidate &b) {
    return a.bytes != b.bytes ? a.bytes > b.bytes : a.error > b.error;
  });
  std::vector<Rung> rungs = {{1, 0, first.psnr, 1}};
  if (candidates.empty()) return rungs;
  double bytes = first.bytes;
  for (const RungCandidate &one : hull_of(first, candidates)) {
    const Rung &better = rungs.back();
    if (rungs.size() == most_found) break;
    if (one.bytes > most_of_better * bytes || !(one.psnr < better.psnr) || one.times < better.times) continue;
    rungs.push_back({1, 0, one.psnr, one.times});
    bytes = one.bytes;
  }
  if (rungs.size() == 1) rungs.push_back({1, 0, candidates.back().psnr, candidates.back().times});
  return rungs;
}

void check_view_rungs(const Options &options) {
  if (!options.ladder_by_views) return;
  const char *const found = !options.ladder.empty()           ? "rungs too"
                            : options.bit_rate                ? "bits a second"
                            : options.codec == FVV_CODEC_OEXR ? "pictures that are lossless"
                            : !options.quality.is_psnr        ? "a number of the codec"
                                                              : nullptr;
  if (found)
    throw Error(option_name("ladder", "auto") + ": expected no other goal than " + option_name("view-loss") +
                    " or a quality in dB, found " + found,
                Error::usage);
}

std::vector<Rung> usual_rungs(double first_psnr) {
  std::vector<Rung> rungs;
  for (int k = 0; k < 3; k++) {
    const double lower = first_psnr - 6 * k;
    rungs.push_back({1, 0, std::max(lower, first_psnr * (1 - 0.25 * k))});
  }
  return rungs;
}

} // namespace fvv::mux
