// calibration_*.json of the CMU Panoptic Studio (Joo et al. 2015): K, distCoef, R and t of each camera as
// OpenCV has them, in centimetres. Others write the same keys as a list, or by the cameras' names.

#include "fvv_scene/strict_json.h"
#include "scene/src/import/camera.h"

#include <cmath>

namespace fvv::import {

namespace {

using scene::JsonValue;

constexpr uint64_t max_json_size = uint64_t(16)
                                   << 20; // as for a capture.json: values cost many times their text

double finite(const JsonValue &value) {
  const double number = value.number();
  if (!std::isfinite(number)) value.fail("expected a finite number, found " + value.found());
  return number;
}

void read_matrix(const JsonValue &matrix, double values[9]) {
  for (size_t i = 0; i < 9; i++) values[i] = finite(matrix.items(3, i / 3).items(3, i % 3));
}

// Of keys with the same meaning; an error when several are there.
std::optional<JsonValue> first_of(const JsonValue &entry, std::initializer_list<const char *> keys) {
  std::optional<JsonValue> found;
  for (const char *key : keys)
    if (auto one = entry.find(key)) {
      if (found) one->fail("expected one key of this meaning, found a second");
      found.emplace(*one);
    }
  return found;
}

fvv_camera read_camera(const JsonValue &entry) {
  fvv_camera camera = {};
  if (const auto resolution = first_of(entry, {"resolution", "image_size", "imgSize"})) {
    camera.width = static_cast<uint32_t>(resolution->items(2, 0).integer(1, INT32_MAX));
    camera.height = static_cast<uint32_t>(resolution->items(2, 1).integer(1, INT32_MAX));
  } else if (const auto width = entry.find("width")) {
    camera.width = static_cast<uint32_t>(width->integer(1, INT32_MAX));
    camera.height = static_cast<uint32_t>(entry.at("height").integer(1, INT32_MAX));
  } else {
    entry.at("resolution");
  }
  double k[9], coefficients[8] = {};
  read_matrix(entry.at("K"), k);
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    entry.at("K").fail("expected zeros below the diagonal and 1 at its end, found others");
  camera.fx = k[0];
  camera.skew = k[1];
  camera.cx = k[2] + 0.5;
  camera.fy = k[4];
  camera.cy = k[5] + 0.5;
  if (const auto lens = first_of(entry, {"distCoef", "dist", "distortion"})) {
    const size_t count = lens->size();
    if (count != 0 && count != 4 && count != 5 && count != 8)
      lens->fail("expected 4, 5 or 8 coefficients, found " + std::to_string(count));
    for (size_t i = 0; i < count; i++) coefficients[i] = finite(lens->item(i));
  }
  set_radtan(camera, coefficients);
  read_matrix(entry.at("R"), camera.rotation);
  // A column, as the studio writes it, or a plain list.
  const auto t_or_none = first_of(entry, {"t", "T"});
  const JsonValue t = t_or_none ? *t_or_none : entry.at("t");
  for (size_t i = 0; i < 3; i++) {
    const JsonValue row = t.items(3, i);
    camera.translation[i] = finite(row.is_number() ? row : row.items(1, 0));
  }
  return camera;
}

} // namespace

Calibration read_panoptic(const std::string &file) {
  const nlohmann::json document = scene::parse_strict_json(scene::read_file(file, max_json_size), file);
  const JsonValue root(document, file);
  Calibration calibration;
  const auto add = [&](const JsonValue &entry, const std::string &key) {
    scene::Camera camera;
    camera.calibration = read_camera(entry);
    // append() allows far fewer cameras than ids
    camera.calibration.id = static_cast<uint16_t>(calibration.cameras.size());
    const auto name = entry.find("name");
    camera.set_name(name ? name->text() : key);
    append(calibration, std::move(camera), entry.place());
  };
  const auto listed = root.is_object() ? root.find("cameras") : std::optional<JsonValue>(root);
  if (listed && !listed->is_object()) {
    for (size_t i = 0; i < listed->size(); i++) add(listed->item(i), std::to_string(i));
  } else {
    const JsonValue &named = listed ? *listed : root;
    for (const std::string &key : named.keys()) add(named.at(key.c_str()), key);
  }
  // The studio's own files are in centimetres, and say which calibration they are of.
  if (root.is_object() && root.find("calibDataSource")) calibration.metres_per_unit = 0.01;
  require_cameras(calibration, file);
  return calibration;
}

} // namespace fvv::import
