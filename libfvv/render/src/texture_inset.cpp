#include "fvv_render/texture_inset.h"

#include "fvv_render/scene_lengths.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>

namespace fvv::render {

namespace {

constexpr double smallest_inset = 1.0 / 2000; // of the mesh's longest side
constexpr size_t most_pixels = 4000;          // of a view, about

// Odd, so that centres of pixels meet, and no longer than a side.
uint32_t stride_of(const fvv_camera &camera) {
  const double pixels = double(camera.width) * camera.height;
  const double stride =
      std::min({std::sqrt(pixels / most_pixels), double(camera.width), double(camera.height)});
  return 2 * uint32_t((stride - 1) / 2 + 0.25) + 1;
}

// A camera with a picture whose pixel (x, y) has its centre on the centre of the middle one of the source's
// stride x stride pixels.
fvv_camera thinned(const fvv_camera &source, uint32_t stride) {
  fvv_camera camera = source;
  camera.width = source.width / stride;
  camera.height = source.height / stride;
  camera.fx /= stride;
  camera.skew /= stride;
  camera.cx /= stride;
  camera.fy /= stride;
  camera.cy /= stride;
  return camera;
}

// A camera that is drawn from the others of its frame.
class HeldOutView {
public:
  HeldOutView(const InsetView &given, uint32_t index, const ViewRenderer &renderer)
      : view(given.source), place(index), frame(renderer), stride(stride_of(view.camera)),
        camera(thinned(view.camera, stride)) {
    const ViewPicture picture = frame.render(camera, place, 0);
    for (uint32_t y = 0; y < camera.height; y++)
      for (uint32_t x = 0; x < camera.width; x++) {
        const size_t at = size_t(y) * camera.width + x;
        if (picture.contributions[at * picture.best].source == no_source) continue;
        if (!given.mask || given.mask[source_pixel(at)] > 127) compared.push_back(at);
      }
  }

  size_t pixels() const { return compared.size(); }

  // The sum of squared differences of display values, 0 to 1.
  double squares(double inset) const {
    const ViewPicture picture = frame.render(camera, place, inset);
    double sum = 0;
    for (const size_t at : compared) {
      const size_t source = 3 * source_pixel(at);
      for (size_t k = 0; k < 3; k++) {
        const double truth =
            view.wide_pixels ? double(view.wide_pixels[source + k]) : view.pixels[source + k] / 65535.0;
        const double difference = double(picture.rgb[3 * at + k]) - truth;
        sum += difference * difference;
      }
    }
    return sum;
  }

private:
  size_t source_pixel(size_t at) const {
    const size_t x = at % camera.width * stride + stride / 2, y = at / camera.width * stride + stride / 2;
    return y * view.camera.width + x;
  }

  const SourceView view;
  const uint32_t place;
  const ViewRenderer &frame;
  const uint32_t stride;
  const fvv_camera camera;
  std::vector<size_t> compared; // pixels of camera, which some other camera shows
};

// All targets of all frames, for one inset after the other.
class Comparison {
public:
  Comparison(const std::vector<InsetFrame> &frames, ViewOptions options) {
    options.samples = 1;
    options.environment = nullptr;
    options.keep_visibility = false;
    for (const InsetFrame &frame : frames) {
      std::vector<SourceView> sources;
      for (const InsetView &view : frame.views) sources.push_back(view.source);
      renderers.push_back(
          std::make_unique<const ViewRenderer>(frame.mesh, std::vector<Vec3>(), std::move(sources), options));
      for (uint32_t i = 0; i < frame.views.size(); i++)
        targets.emplace_back(frame.views[i], i, *renderers.back());
    }
  }

  size_t pixels() const {
    size_t sum = 0;
    for (const HeldOutView &target : targets) sum += target.pixels();
    return sum;
  }

  // Of each target.
  const std::vector<double> &squares(double inset) {
    std::vector<double> &out = known[inset];
    if (out.empty())
      for (const HeldOutView &target : targets) out.push_back(target.squares(inset));
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

  std::vector<std::unique_ptr<const ViewRenderer>> renderers;
  std::deque<HeldOutView> targets;
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

TextureInset find_texture_inset(const std::vector<InsetFrame> &frames, const ViewOptions &options) {
  TextureInset out;
  double side = 0;
  for (const InsetFrame &frame : frames) side = std::max(side, longest_side(frame.mesh));
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
