#include "fvvmux/pinhole.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

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

// The border of what is shown is made of the picture's, as far as the limit, and of the circle of the limit,
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

} // namespace fvv::mux
