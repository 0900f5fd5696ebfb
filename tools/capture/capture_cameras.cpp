// capture/capture_cameras.cpp: the cameras of a capture.json.
#include "capture/capture_fields.h"
#include "capture/vocabulary.h"

#include <algorithm>
#include <cmath>

namespace fvv::capture {

namespace {

// What a value of radius means is up to the lens: fvv_camera_validate judges it.
void read_lens(const JsonValue &value, fvv_camera &camera, bool &r_max_given) {
  value.allow_keys({"model", "coefficients", "r_max"});
  const JsonValue model = value.at("model");
  const std::string text = model.text();
  bool known = false;
  for (const NamedLens &lens : named_lenses)
    if (text == lens.name) {
      camera.lens = lens.lens;
      known = true;
    }
  if (!known) model.fail("expected none, radtan or fisheye, found " + model.found());
  const auto coefficients =
      camera.lens == FVV_LENS_NONE ? value.find("coefficients") : std::optional(value.at("coefficients"));
  if (coefficients) {
    const size_t count = coefficients->size();
    const bool fits = camera.lens == FVV_LENS_RADTAN    ? count == 4 || count == 5 || count == 8
                      : camera.lens == FVV_LENS_FISHEYE ? count == 4
                                                        : count == 0;
    if (!fits)
      coefficients->fail(std::string("expected ") +
                         (camera.lens == FVV_LENS_RADTAN    ? "4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6)"
                          : camera.lens == FVV_LENS_FISHEYE ? "4 (k1 k2 k3 k4)"
                                                            : "no") +
                         " coefficients for " + text + ", found " + std::to_string(count));
    for (size_t i = 0; i < count; i++) camera.distortion[i] = finite(coefficients->item(i));
  }
  if (const auto r_max = value.find("r_max")) {
    r_max_given = true;
    camera.r_max = r_max->is_text() && r_max->text() == unbounded ? INFINITY : positive(*r_max);
  }
}

// How a capture.json counts, where a calibration is read.
struct Convention {
  double metres_per_unit, pixel_centre;
};

void read_intrinsics(const JsonValue &value, const Convention &convention, fvv_camera &model) {
  value.allow_keys({"fx", "fy", "cx", "cy", "skew"});
  model.fx = positive(value.at("fx"));
  model.fy = positive(value.at("fy"));
  model.cx = finite(value.at("cx")) + (0.5 - convention.pixel_centre);
  model.cy = finite(value.at("cy")) + (0.5 - convention.pixel_centre);
  const auto skew = value.find("skew");
  model.skew = skew ? finite(*skew) : 0;
}

void read_rotation(const JsonValue &value, fvv_camera &model) {
  for (size_t row = 0; row < 3; row++)
    for (size_t column = 0; column < 3; column++)
      model.rotation[row * 3 + column] = finite(value.items(3, row).items(3, column));
}

void read_translation(const JsonValue &value, const Convention &convention, fvv_camera &model) {
  for (size_t row = 0; row < 3; row++)
    model.translation[row] = finite(value.items(3, row)) * convention.metres_per_unit;
}

// value: where the camera stands, for the message.
void validate(const JsonValue &value, const fvv_camera &model) {
  fvv_diagnostic diagnostic = {};
  if (fvv_camera_validate(&model, &diagnostic) != FVV_OK) value.fail(diagnostic.message);
}

[[noreturn]] void refuse_second(const JsonValue &number) {
  number.fail("expected one entry for each frame, found a second one for " + number.found());
}

void add_lost(const JsonValue &number, Camera &camera) {
  const int64_t frame = number.integer(0, INT32_MAX);
  if (camera.per_frame.count(frame) || !camera.lost.insert(frame).second) refuse_second(number);
}

// The entries of a camera that moves: what they lack is as the camera itself has it.
void read_per_frame(const JsonValue &value, const Frames &frames, const Convention &convention,
                    bool r_max_given, Camera &camera) {
  for (size_t i = 0, count = value.size(); i < count; i++) {
    const JsonValue entry = value.item(i);
    if (const auto calibrated = entry.find("calibrated")) {
      entry.allow_keys({"frame", "calibrated"});
      if (calibrated->boolean()) calibrated->fail("expected false, or no such key, found true");
      add_lost(entry.at("frame"), camera);
      continue;
    }
    entry.allow_keys({"frame", "intrinsics", "lens", "rotation", "translation"});
    fvv_camera model = camera.calibration;
    model.name = nullptr;
    model.name_size = 0;
    if (const auto intrinsics = entry.find("intrinsics")) read_intrinsics(*intrinsics, convention, model);
    if (const auto rotation = entry.find("rotation")) read_rotation(*rotation, model);
    if (const auto translation = entry.find("translation")) read_translation(*translation, convention, model);
    bool given = r_max_given;
    if (const auto lens = entry.find("lens")) {
      std::fill(std::begin(model.distortion), std::end(model.distortion), 0.0);
      given = false;
      read_lens(*lens, model, given);
    }
    if (!given) model.r_max = fvv_camera_r_max(&model);
    validate(entry, model);
    const JsonValue number = entry.at("frame");
    const int64_t frame = number.integer(0, INT32_MAX);
    if (camera.lost.count(frame) || !camera.per_frame.emplace(frame, model).second) refuse_second(number);
  }
  for (int64_t i = 0; i < frames.count; i++)
    if (!camera.per_frame.count(frames.number(i)) && !camera.lost.count(frames.number(i)))
      value.fail("expected an entry for each of the capture's " + std::to_string(frames.count) +
                 " frames, found none for frame " + std::to_string(frames.number(i)));
}

Camera read_camera(const JsonValue &value, const Capture &capture, const Convention &convention) {
  value.allow_keys({"id", "name", "width", "height", "intrinsics", "lens", "rotation", "translation",
                    "per_frame", "texture", "pictures", "masks"});
  Camera camera;
  fvv_camera &model = camera.calibration;
  model.id = static_cast<uint16_t>(value.at("id").integer(0, UINT16_MAX - 1));
  const auto name = value.find("name");
  camera.set_name(name ? name->text() : "");
  model.width = static_cast<uint32_t>(value.at("width").integer(1, UINT32_MAX));
  model.height = static_cast<uint32_t>(value.at("height").integer(1, UINT32_MAX));
  read_intrinsics(value.at("intrinsics"), convention, model);
  read_rotation(value.at("rotation"), model);
  read_translation(value.at("translation"), convention, model);
  bool r_max_given = false;
  if (const auto lens = value.find("lens")) read_lens(*lens, model, r_max_given);
  if (!r_max_given) model.r_max = fvv_camera_r_max(&model);
  validate(value, model);
  if (const auto entries = value.find("per_frame"))
    read_per_frame(*entries, capture.frames, convention, r_max_given, camera);
  if (const auto texture = value.find("texture")) camera.texture = texture->boolean();
  if (const auto pictures = value.find("pictures"))
    camera.pictures = read_picture_source(*pictures, capture.frames);
  if (const auto masks = value.find("masks")) {
    if (!camera.pictures) masks->fail("expected pictures wherever there are masks");
    camera.masks = read_picture_source(*masks, capture.frames);
  }
  return camera;
}

} // namespace

void read_cameras(const JsonValue &value, Capture &capture, double pixel_centre) {
  fvv_limits limits;
  fvv_limits_default(&limits);
  const size_t count = value.size();
  if (count > limits.max_cameras)
    value.fail("expected at most " + std::to_string(limits.max_cameras) + " cameras, found " +
               std::to_string(count));
  for (size_t i = 0; i < count; i++) {
    Camera camera = read_camera(value.item(i), capture, {capture.metres_per_unit, pixel_centre});
    for (size_t j = 0; j < i; j++)
      if (capture.cameras[j].calibration.id == camera.calibration.id)
        value.item(i).at("id").fail("expected an id of its own, found " +
                                    std::to_string(camera.calibration.id) + " as in /cameras/" +
                                    std::to_string(j));
    capture.cameras.push_back(std::move(camera));
  }
}

} // namespace fvv::capture
