// The way of a film's camera through a scene: around a point, or along keyframes.
#pragma once

#include "fvv_render/vector.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::view {

using render::Vec3;

// Where the camera is at a time. Metres, in the scene's axes.
struct Keyframe {
  double time = 0; // seconds of the film
  Vec3 position, target;
  std::optional<Vec3> up;         // none: the scene's
  std::optional<double> fov = {}; // vertical field of view in degrees; none: as Target has it
};

// Keyframes joined by cubics (Catmull-Rom for uneven times): the camera passes each of them at its time, and
// its speed has no jumps. Before the first and after the last it rests.
class Path {
public:
  // At least one, in rising order of time; all have up or none has, and the same of fov.
  explicit Path(std::vector<Keyframe> along) : keys(std::move(along)) {}
  Keyframe at(double seconds) const;
  double end() const { return keys.back().time; }

private:
  std::vector<Keyframe> keys;
};

// A JSON array of 1 to 10000 objects {"time", "position", "target", "up", "fov"} (docs/tools/fvvrender.md).
// Error with the place "name: /3/time" for anything else; numbers beyond 1e6, keyframes less than a
// microsecond apart and a fov outside 1 to 170 are errors.
Path parse_path(std::string_view bytes, const std::string &name);

// A circle around an axis through target; the camera looks at target.
struct Orbit {
  Vec3 target, up, start; // unit vectors at right angles: the axis, and the direction in which it begins
  double radius, height;  // metres: from the axis, and above target

  // degrees: from the start, counterclockwise where up points at the viewer.
  Keyframe at(double degrees) const;
};

} // namespace fvv::view
