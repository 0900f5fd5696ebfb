#include "fvvmux/undistort.h"

#include "cli/cli.h"
#include "fvv_media/resample.h"
#include "fvvmux/pinhole.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

namespace fvv::mux {

namespace {

constexpr double most_growth = 2; // of a side of the picture

// The intrinsics, by which frames of a camera are alike.
struct Lens {
  double values[14];

  explicit Lens(const fvv_camera &c) : values{c.fx, c.fy, c.cx, c.cy, c.skew, c.r_max} {
    std::copy_n(c.distortion, 8, values + 6);
  }
  bool operator<(const Lens &other) const {
    return std::lexicographical_compare(values, values + 14, other.values, other.values + 14);
  }
};

struct Chosen {
  View view;
  double width, height; // of the picture that is as fine as the old one on the axis, or of the largest
};

[[noreturn]] void fail(const fvv_camera &camera, const std::string &what) {
  throw cli::Failure("--undistort: camera " + std::to_string(camera.id) + ": " + what, cli::usage);
}

Chosen choose(const fvv_camera &camera, double alpha) {
  const LensView lens(camera);
  if (lens.is_too_wide())
    fail(camera,
         "the lens shows 150 degrees or more, which no plane picture can; leave this camera's lens, or "
         "the camera, as it is");
  const std::optional<View> inside = lens.inside(), around = lens.around();
  if (!inside) fail(camera, "no part of the picture lies within r_max and 75 degrees of the axis");
  Chosen chosen = {inside->towards(*around, alpha), 0, 0};
  const double width = camera.fx * chosen.view.width(), height = camera.fy * chosen.view.height();
  const double most[2] = {std::min(most_growth * camera.width, double(media::max_dimension)),
                          std::min(most_growth * camera.height, double(media::max_dimension))};
  const double factor = std::min({1.0, most[0] / width, most[1] / height});
  chosen.width = width * factor;
  chosen.height = height * factor;
  return chosen;
}

fvv_camera pinhole(const fvv_camera &source, const View &view, uint32_t width, uint32_t height) {
  fvv_camera camera = source;
  camera.lens = FVV_LENS_NONE;
  std::fill_n(camera.distortion, 8, 0.0);
  camera.skew = 0;
  camera.width = width;
  camera.height = height;
  camera.fx = width / view.width();
  camera.fy = height / view.height();
  camera.cx = -view.left * camera.fx;
  camera.cy = -view.top * camera.fy;
  // Corners of the picture that nothing was seen of bound it no more than r_max does.
  const double limit = LensView(source).limit();
  const double corner = std::hypot(std::max(-view.left, view.right), std::max(-view.top, view.bottom));
  camera.r_max = corner <= limit * (1 + 1e-9) ? INFINITY : limit;
  return camera;
}

// The new picture's pixel goes out as a ray and comes back through the lens.
media::PixelMap map_between(const fvv_camera &target, const LensView &lens) {
  return [target, lens](double x, double y, double at[2]) {
    return lens.pixel((x - target.cx) / target.fx, (y - target.cy) / target.fy, at);
  };
}

// Adds what one frame's camera shows.
void judge(const fvv_camera &source, const View &view, const fvv_camera &target, Undistorted &report) {
  constexpr int grid = 64;
  const LensView lens(source);
  int kept = 0, blank = 0;
  for (int i = 0; i < grid * grid; i++) {
    const double x = (i % grid + 0.5) / grid, y = (i / grid + 0.5) / grid;
    const double at[2] = {x * source.width, y * source.height};
    double ray[3];
    if (fvv_camera_unproject(&source, at, ray))
      kept += ray[0] >= view.left && ray[0] <= view.right && ray[1] >= view.top && ray[1] <= view.bottom;
    blank += !lens.shows(view.left + x * view.width(), view.top + y * view.height());
  }
  report.horizontal = std::max(report.horizontal, view.horizontal_degrees());
  report.vertical = std::max(report.vertical, view.vertical_degrees());
  report.kept = std::min(report.kept, double(kept) / (grid * grid));
  report.blank = std::max(report.blank, double(blank) / (grid * grid));
  report.finest = std::min({report.finest, target.fx / source.fx, target.fy / source.fy});
  report.limited = report.limited || lens.is_limited();
}

} // namespace

Undistortion::Undistortion(capture::Capture &capture, double wished) : alpha(wished) {
  for (capture::Camera &camera : capture.cameras) replace(capture, camera);
}

void Undistortion::replace(const capture::Capture &capture, capture::Camera &camera) {
  pairs.push_back({camera, camera, false});
  if (!camera.pictures || camera.calibration.lens == FVV_LENS_NONE) return;
  std::vector<fvv_camera *> all = {&camera.calibration};
  for (auto &[number, calibration] : camera.per_frame) all.push_back(&calibration);
  std::map<Lens, Chosen> known;
  const auto chosen = [&](const fvv_camera &one) -> const Chosen & {
    const Lens lens(one);
    const auto found = known.find(lens);
    return found != known.end() ? found->second : known.emplace(lens, choose(one, alpha)).first->second;
  };
  double width = 1, height = 1;
  // The camera's own is that of no frame when it moves, but may be as sharp as any.
  for (const fvv_camera *one : all) {
    width = std::max(width, std::round(chosen(*one).width));
    height = std::max(height, std::round(chosen(*one).height));
  }
  const fvv_camera &own = camera.calibration;
  Undistorted report = {
      own.id, own.width, own.height, uint32_t(width), uint32_t(height), 0, 0, /* kept */ INFINITY,
      0,      INFINITY,  false};
  for (fvv_camera *one : all) {
    const fvv_camera source = *one;
    const View &view = chosen(source).view;
    *one = pinhole(source, view, report.width, report.height);
    judge(source, view, *one, report);
    fvv_diagnostic diagnostic = {};
    cli::check(fvv_camera_validate(one, &diagnostic), capture.path, diagnostic);
  }
  reports.push_back(report);
  pairs.back().target = camera;
  pairs.back().is_new = true;
}

template <class Sample>
media::BasicImage<Sample> Undistortion::apply(size_t camera, int64_t frame,
                                              media::BasicImage<Sample> picture) const {
  const Pair &pair = pairs[camera];
  if (!pair.is_new) return picture;
  // Of a frame without calibration nobody takes colours; its picture goes the camera's own way.
  const bool known = pair.source.is_calibrated(frame);
  const fvv_camera source = known ? pair.source.calibration_at(frame) : pair.source.calibration,
                   target = known ? pair.target.calibration_at(frame) : pair.target.calibration;
  return media::resample(picture, target.width, target.height, map_between(target, LensView(source)));
}

template media::Image Undistortion::apply(size_t, int64_t, media::Image) const;
template media::DeepImage Undistortion::apply(size_t, int64_t, media::DeepImage) const;
template media::LinearImage Undistortion::apply(size_t, int64_t, media::LinearImage) const;

std::string Undistortion::text() const {
  std::string out;
  for (const Undistorted &one : reports) {
    char line[240];
    std::snprintf(line, sizeof line,
                  "  undistort camera %u: %ux%u without lens for %ux%u, %.1f x %.1f degrees, %.1f %% of the "
                  "picture kept, %.1f %% blank, %.3g px for one on the axis%s\n",
                  one.id, one.width, one.height, one.source_width, one.source_height, one.horizontal,
                  one.vertical, 100 * one.kept, 100 * one.blank, one.finest,
                  one.limited ? "; cut at r_max or 75 degrees from the axis" : "");
    out += line;
  }
  return out.empty() ? "  undistort no camera with pictures has a lens\n" : out;
}

nlohmann::ordered_json Undistortion::json() const {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Undistorted &one : reports)
    out.push_back({{"camera", one.id},
                   {"source_width", one.source_width},
                   {"source_height", one.source_height},
                   {"width", one.width},
                   {"height", one.height},
                   {"horizontal_degrees", one.horizontal},
                   {"vertical_degrees", one.vertical},
                   {"kept", one.kept},
                   {"blank", one.blank},
                   {"axis_scale", one.finest},
                   {"limited", one.limited}});
  return out;
}

} // namespace fvv::mux
