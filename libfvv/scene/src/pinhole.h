// The part of the plane before a camera with a lens that a picture without a lens shows.
#pragma once

#include "fvv/calibration.h"

#include <optional>

namespace fvv::scene {

// A rectangle of that plane: x / z and y / z in the camera's frame.
struct View {
  double left, top, right, bottom;

  double width() const { return right - left; }
  double height() const { return bottom - top; }
  // Each side moved by that fraction of the way to the other's.
  View towards(const View &other, double share) const;
  // The widest angles across it, through the axis of the camera or beside it; degrees.
  double horizontal_degrees() const;
  double vertical_degrees() const;
};

// The view of a camera with a lens in that plane: up to r_max, and to 75 degrees from the axis.
class LensView {
public:
  // camera: valid.
  explicit LensView(const fvv_camera &camera);

  // The pixel of a point of the plane. false: beyond the limit.
  bool pixel(double x, double y, double at[2]) const;
  // Whether the point is within the limits, and its pixel in the picture.
  bool shows(double x, double y) const;
  // The same 75 degrees to both sides, or above and below: the angle of the lens is too wide for a plane.
  bool is_too_wide() const;
  // The limit is nearer than a corner of the picture; that of 75 degrees if it is nearer than r_max.
  bool is_limited() const { return limited; }

  // The smallest rectangle around the view. None: the picture shows nothing within the limits.
  std::optional<View> around() const;
  // A rectangle inside the view that can grow on no side by more than a ten thousandth. None: it would be too
  // small for a picture.
  std::optional<View> inside() const;

  // The largest |(x, y)|.
  double limit() const { return most; }

private:
  bool edge_is_shown(const View &view, int edge) const;
  double share_shown(const View &view, int edge) const;

  fvv_camera camera; // at the origin, along the axes
  double most;
  bool limited = false;
};

} // namespace fvv::scene
