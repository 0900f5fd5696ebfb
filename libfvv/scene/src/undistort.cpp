// Pinhole cameras in place of cameras with a lens, and their pictures.
#include "fvv_scene/undistort.h"
#include "fvv_cxx/error.h"
#include "fvv_media/resample.h"
#include "scene/src/pinhole.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

namespace fvv::scene {

namespace {

constexpr double degree = 3.14159265358979323846 / 180;
constexpr double widest =
    75 * degree;                     // from the axis: at 75 degrees a pixel of the plane is 15 times as fine
constexpr int samples = 33;          // of an edge
constexpr double pixel_slack = 1e-6; // of points that lie on the border

// Left, top, right, bottom.
constexpr double View::*edges[4] = {&View::left, &View::top, &View::right, &View::bottom};

double angle(double from, double to) {
  return (std::atan(to) - std::atan(from)) / degree;
}

// A point of an edge of a rectangle, t from 0 to 1.
void on_edge(const View &view, int edge, double t, double &x, double &y) {
  const bool upright = edge % 2 == 0;
  x = upright ? view.*edges[edge] : view.left + t * view.width();
  y = upright ? view.top + t * view.height() : view.*edges[edge];
}

} // namespace

View View::towards(const View &other, double share) const {
  View out = *this;
  for (const auto edge : edges) out.*edge += share * (other.*edge - out.*edge);
  return out;
}

double View::horizontal_degrees() const {
  return angle(left, right);
}
double View::vertical_degrees() const {
  return angle(top, bottom);
}

LensView::LensView(const fvv_camera &source) : camera(source) {
  for (int i = 0; i < 9; i++) camera.rotation[i] = i % 4 == 0;
  std::fill_n(camera.translation, 3, 0.0);
  const double angle_limit = camera.lens == FVV_LENS_FISHEYE ? camera.r_max : std::atan(camera.r_max);
  most = std::tan(std::min(angle_limit, widest));
  for (int corner = 0; corner < 4; corner++) {
    const double at[2] = {corner % 2 ? double(camera.width) : 0, corner / 2 ? double(camera.height) : 0};
    double ray[3];
    limited = limited || !fvv_camera_unproject(&camera, at, ray) || std::hypot(ray[0], ray[1]) > most;
  }
}

bool LensView::pixel(double x, double y, double at[2]) const {
  const double point[3] = {x, y, 1};
  return std::hypot(x, y) <= most * (1 + 1e-12) && fvv_camera_project(&camera, point, at, nullptr);
}

bool LensView::shows(double x, double y) const {
  double at[2];
  if (!pixel(x, y, at)) return false;
  return at[0] >= -pixel_slack && at[0] <= camera.width + pixel_slack && at[1] >= -pixel_slack &&
         at[1] <= camera.height + pixel_slack;
}

bool LensView::is_too_wide() const {
  const double far = most * (1 - 1e-9);
  return most >= std::tan(widest) * (1 - 1e-9) &&
         ((shows(-far, 0) && shows(far, 0)) || (shows(0, -far) && shows(0, far)));
}

// The border of the view consists of the picture's border, as far as the limit, and the circle of the limit,
// as far as the picture.
std::optional<View> LensView::around() const {
  View view = {INFINITY, INFINITY, -INFINITY, -INFINITY};
  const auto add = [&](double x, double y) {
    view = {std::min(view.left, x), std::min(view.top, y), std::max(view.right, x), std::max(view.bottom, y)};
  };
  const View picture = {0, 0, double(camera.width), double(camera.height)};
  constexpr int along = 4 * (samples - 1);
  for (int edge = 0; edge < 4; edge++)
    for (int i = 0; i <= along; i++) {
      double at[2], ray[3];
      on_edge(picture, edge, double(i) / along, at[0], at[1]);
      if (fvv_camera_unproject(&camera, at, ray) && std::hypot(ray[0], ray[1]) <= most) add(ray[0], ray[1]);
    }
  for (int i = 0; i < 360; i++) {
    const double x = most * std::cos(i * degree), y = most * std::sin(i * degree);
    if (shows(x, y)) add(x, y);
  }
  if (!(view.width() > 0 && view.height() > 0)) return std::nullopt;
  return view;
}

double LensView::share_shown(const View &view, int edge) const {
  int shown = 0;
  for (int i = 0; i < samples; i++) {
    double x, y;
    on_edge(view, edge, double(i) / (samples - 1), x, y);
    shown += shows(x, y);
  }
  return double(shown) / samples;
}

bool LensView::edge_is_shown(const View &view, int edge) const {
  return share_shown(view, edge) == 1;
}

// From the rectangle around everything, the edge that sees least moves in by a step until all see something
// everywhere; then each moves out again as far as it can. What is shown has no holes, so edges tell for all
// that is between them.
std::optional<View> LensView::inside() const {
  const std::optional<View> outer = around();
  if (!outer) return std::nullopt;
  constexpr int steps = 256;
  View view = *outer;
  const double step[2] = {view.width() / steps, view.height() / steps};
  const auto out = [&](int edge) { return (edge < 2 ? -1 : 1) * step[edge % 2]; };
  for (;;) {
    int worst = -1;
    double least = 1;
    for (int edge = 0; edge < 4; edge++) {
      const double share = share_shown(view, edge);
      if (share < least) {
        least = share;
        worst = edge;
      }
    }
    if (worst < 0) break;
    view.*edges[worst] -= out(worst);
    if (view.width() < 2 * step[0] || view.height() < 2 * step[1]) return std::nullopt;
  }
  for (int edge = 0; edge < 4; edge++) {
    const auto fits = [&](double by) {
      View larger = view;
      larger.*edges[edge] += by;
      for (int each = 0; each < 4; each++)
        if (!edge_is_shown(larger, each)) return false;
      return true;
    };
    double room = 0;
    for (double by = out(edge); std::fabs(by) > std::fabs(out(edge)) / 64; by /= 2)
      if (fits(room + by)) room += by;
    view.*edges[edge] += room;
  }
  return view;
}

namespace {

constexpr double most_growth = 2; // of a side of the picture

// The intrinsics, which frames of a camera may share.
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
  refuse_option("undistort", "camera " + std::to_string(camera.id) + ": " + what);
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
  // Corners of the picture that show nothing limit it no more than r_max does.
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

Undistortion::Undistortion(Capture &capture, double wished) : alpha(wished) {
  for (Camera &camera : capture.cameras) replace(capture, camera);
}

void Undistortion::replace(const Capture &capture, Camera &camera) {
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
  // If the camera moves, its own calibration is that of no frame, but may be as sharp as any.
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
    fvv::check(fvv_camera_validate(one, &diagnostic), capture.path, diagnostic);
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
  // The picture of a frame without calibration is not used for colours; the camera's own calibration applies
  // to it.
  const bool known = pair.source.is_calibrated(frame);
  const fvv_camera source = known ? pair.source.calibration_at(frame) : pair.source.calibration,
                   target = known ? pair.target.calibration_at(frame) : pair.target.calibration;
  return media::resample(picture, target.width, target.height, map_between(target, LensView(source)));
}

template media::Image Undistortion::apply(size_t, int64_t, media::Image) const;
template media::DeepImage Undistortion::apply(size_t, int64_t, media::DeepImage) const;
template media::LinearImage Undistortion::apply(size_t, int64_t, media::LinearImage) const;

} // namespace fvv::scene
