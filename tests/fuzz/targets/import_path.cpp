// The keyframes of fvvrender --path.
#include "../fuzz.h"

#include "fvv_cxx/error.h"
#include "fvv_view/path.h"

#include <cmath>
#include <string_view>

using fvv::render::Vec3;

FVV_FUZZ_TARGET(path, fuzz::Form::bytes) {
  const auto is_finite = [](const Vec3 &v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  };
  try {
    const fvv::view::Path path =
        fvv::view::parse_path({reinterpret_cast<const char *>(data), size}, "path.json");
    constexpr int steps = 64;
    for (int i = -1; i <= steps; i++) {
      // The first steps are short, because keyframes may be close to each other.
      const double share = double(i) / steps;
      const fvv::view::Keyframe key = path.at(path.end() * share * share * share);
      fuzz::expect(is_finite(key.position) && is_finite(key.target) && (!key.up || is_finite(*key.up)),
                   "a camera on the path has a place");
      fuzz::expect(!key.fov || (*key.fov >= 1 && *key.fov <= 170), "the angle of view is in its range");
    }
  } catch (const fvv::Error &) {}
}
