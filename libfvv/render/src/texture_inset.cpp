#include "fvv_render/texture_inset.h"

#include "fvv_render/scene_lengths.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace fvv::render {

namespace {

constexpr double smallest_inset = 1.0 / 2000; // of the mesh's longest side

// One inset after the other.
class Comparison {
public:
  Comparison(const std::vector<HeldOutFrame> &frames, const ViewOptions &options)
      : drawn(frames, options), measure(frames, drawn) {}

  size_t pixels() const { return measure.pixels(); }

  // Of each camera the sum of squared differences.
  const std::vector<double> &squares(double inset) {
    std::vector<double> &out = known[inset];
    if (out.empty())
      for (const ViewScore &score : measure.held_out(drawn, inset, false)) out.push_back(score.squares);
    return out;
  }

  double error(double inset) { return sum_of(squares(inset)); }

  // Of the insets that were tried.
  double best() const {
    const auto less = [](const auto &a, const auto &b) { return sum_of(a.second) < sum_of(b.second); };
    return std::min_element(known.begin(), known.end(), less)->first;
  }

private:
  static double sum_of(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
  }

  const DrawnFrames drawn;
  const ViewMeasure measure;
  std::map<double, std::vector<double>> known;
};

// Where the parabola through three points is least, which are at rising places and whose middle is lowest.
double vertex_of(const double (&at)[3], const double (&value)[3]) {
  const double left = (value[1] - value[0]) / (at[1] - at[0]),
               right = (value[2] - value[1]) / (at[2] - at[1]);
  const double curvature = (right - left) / (at[2] - at[0]);
  return curvature > 0 ? (at[0] + at[1] - left / curvature) / 2 : at[1];
}

} // namespace

TextureInset find_texture_inset(const std::vector<HeldOutFrame> &frames, const ViewOptions &options) {
  TextureInset out;
  double side = 0;
  for (const HeldOutFrame &frame : frames) side = std::max(side, longest_side(frame.mesh));
  Comparison compare(frames, options);
  out.pixels = compare.pixels();
  if (!(side > 0) || out.pixels < least_compared) return out;
  double last = 0, inset = smallest_inset * side, next = 2 * inset;
  if (compare.error(inset) < compare.error(0)) {
    for (; inset < largest_inset * side && compare.error(next) < compare.error(inset); next *= 2) {
      last = inset;
      inset = next;
    }
    const double below = (last + inset) / 2, above = (inset + next) / 2;
    if (compare.error(below) < compare.error(inset)) {
      next = inset;
      inset = below;
    } else if (compare.error(above) < compare.error(inset)) {
      last = inset;
      inset = above;
    } else {
      last = below;
      next = above;
    }
    if (compare.error(next) > compare.error(inset))
      (void)compare.error(
          vertex_of({last, inset, next}, {compare.error(last), compare.error(inset), compare.error(next)}));
  }
  const double best = compare.best();
  const std::vector<double> &without = compare.squares(0), &with = compare.squares(best);
  const double scale = 3 * double(out.pixels);
  out.before = 10 * std::log10(scale / compare.error(0));
  out.after = 10 * std::log10(scale / compare.error(best));
  for (size_t i = 0; i < with.size(); i++) {
    out.views += without[i] > 0;
    out.better += with[i] < without[i];
  }
  if (out.after - out.before >= least_gain && 2 * out.better >= out.views) out.inset = best;
  return out;
}

} // namespace fvv::render
