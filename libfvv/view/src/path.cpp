#include "fvv_view/path.h"

#include "fvv_scene/strict_json.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fvv::view {

namespace {

constexpr size_t most_keyframes = 10000;
constexpr double farthest = 1e6;    // metres, seconds
constexpr double least_span = 1e-6; // seconds between keyframes: slopes stay finite

double bounded(const scene::JsonValue &value, double least, double most) {
  const double number = value.number();
  if (!(number >= least && number <= most)) {
    char text[80];
    std::snprintf(text, sizeof text, "expected a number from %g to %g, found ", least, most);
    value.fail(text + value.found());
  }
  return number;
}

Vec3 vector(const scene::JsonValue &value) {
  const auto part = [&](size_t i) { return bounded(value.items(3, i), -farthest, farthest); };
  return {part(0), part(1), part(2)};
}

Keyframe keyframe(const scene::JsonValue &value) {
  value.allow_keys({"time", "position", "target", "up", "fov"});
  Keyframe out;
  out.time = bounded(value.at("time"), 0, farthest);
  out.position = vector(value.at("position"));
  out.target = vector(value.at("target"));
  if (!(render::length(out.target - out.position) > 0))
    value.at("target").fail("expected another point than position");
  if (const auto up = value.find("up")) {
    out.up = vector(*up);
    if (!(render::length(*out.up) > 0)) up->fail("expected a direction, found zeros");
  }
  if (const auto fov = value.find("fov")) out.fov = bounded(*fov, 1, 170);
  return out;
}

// The numbers of a keyframe, those that it lacks as 0.
using Numbers = std::array<double, 10>;

Numbers numbers_of(const Keyframe &key) {
  const Vec3 up = key.up.value_or(Vec3());
  return {key.position.x, key.position.y, key.position.z, key.target.x, key.target.y,
          key.target.z,   up.x,           up.y,           up.z,         key.fov.value_or(0)};
}

// Change by the second at keyframe i: the mean of the spans around it, each weighted by the other's length.
double slope(const std::vector<Keyframe> &keys, size_t i, size_t number) {
  const auto rate = [&](size_t a) {
    return (numbers_of(keys[a + 1])[number] - numbers_of(keys[a])[number]) /
           (keys[a + 1].time - keys[a].time);
  };
  if (i == 0) return rate(0);
  if (i + 1 == keys.size()) return rate(i - 1);
  const double before = keys[i].time - keys[i - 1].time, after = keys[i + 1].time - keys[i].time;
  return (rate(i - 1) * after + rate(i) * before) / (before + after);
}

} // namespace

Keyframe Path::at(double seconds) const {
  if (seconds <= keys.front().time) return keys.front();
  if (seconds >= keys.back().time) return keys.back();
  const auto next = std::upper_bound(keys.begin(), keys.end(), seconds,
                                     [](double time, const Keyframe &key) { return time < key.time; });
  const size_t a = size_t(next - keys.begin()) - 1, b = a + 1;
  const double span = keys[b].time - keys[a].time, t = (seconds - keys[a].time) / span;
  const Numbers from = numbers_of(keys[a]), to = numbers_of(keys[b]);
  Numbers n;
  for (size_t i = 0; i < n.size(); i++)
    n[i] = (1 + 2 * t) * (1 - t) * (1 - t) * from[i] + t * (1 - t) * (1 - t) * span * slope(keys, a, i) +
           t * t * (3 - 2 * t) * to[i] + t * t * (t - 1) * span * slope(keys, b, i);
  Keyframe out = {seconds, {n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {}};
  if (keys[a].up) out.up = Vec3{n[6], n[7], n[8]};
  // A cubic may leave the range of the keyframes.
  if (keys[a].fov) out.fov = std::clamp(n[9], 1.0, 170.0);
  return out;
}

Path parse_path(std::string_view bytes, const std::string &name) {
  const nlohmann::json document = scene::parse_strict_json(bytes, name);
  const scene::JsonValue root(document, name);
  const size_t count = root.size();
  if (count < 1 || count > most_keyframes)
    root.fail("expected 1 to " + std::to_string(most_keyframes) + " keyframes, found " +
              std::to_string(count));
  std::vector<Keyframe> keys;
  for (size_t i = 0; i < count; i++) {
    const scene::JsonValue item = root.item(i);
    keys.push_back(keyframe(item));
    if (!i) continue;
    const Keyframe &before = keys[i - 1], &now = keys[i];
    if (!(now.time - before.time >= least_span))
      item.at("time").fail("expected more than that of the keyframe before, by at least a microsecond");
    if (now.up.has_value() != before.up.has_value()) item.fail("expected up in all keyframes, or in none");
    if (now.fov.has_value() != before.fov.has_value()) item.fail("expected fov in all keyframes, or in none");
  }
  return Path(std::move(keys));
}

Keyframe Orbit::at(double degrees) const {
  const double angle = degrees * 3.14159265358979323846 / 180;
  const Vec3 side = render::cross(up, start);
  return {0, target + (start * std::cos(angle) + side * std::sin(angle)) * radius + up * height, target, up};
}

} // namespace fvv::view
