// capture/capture_cameras.cpp: the cameras of a capture.json.
#include "capture/capture_fields.h"
#include "capture/vocabulary.h"

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

Camera read_camera(const JsonValue &value, const Capture &capture, double pixel_centre) {
  value.allow_keys({"id", "name", "width", "height", "intrinsics", "lens", "rotation", "translation",
                    "pictures", "masks"});
  Camera camera;
  fvv_camera &model = camera.calibration;
  model.id = static_cast<uint16_t>(value.at("id").integer(0, UINT16_MAX - 1));
  const auto name = value.find("name");
  camera.set_name(name ? name->text() : "");
  model.width = static_cast<uint32_t>(value.at("width").integer(1, UINT32_MAX));
  model.height = static_cast<uint32_t>(value.at("height").integer(1, UINT32_MAX));
  const JsonValue intrinsics = value.at("intrinsics");
  intrinsics.allow_keys({"fx", "fy", "cx", "cy", "skew"});
  model.fx = positive(intrinsics.at("fx"));
  model.fy = positive(intrinsics.at("fy"));
  model.cx = finite(intrinsics.at("cx")) + (0.5 - pixel_centre);
  model.cy = finite(intrinsics.at("cy")) + (0.5 - pixel_centre);
  if (const auto skew = intrinsics.find("skew")) model.skew = finite(*skew);
  const JsonValue rotation = value.at("rotation"), translation = value.at("translation");
  for (size_t row = 0; row < 3; row++) {
    for (size_t column = 0; column < 3; column++)
      model.rotation[row * 3 + column] = finite(rotation.items(3, row).items(3, column));
    model.translation[row] = finite(translation.items(3, row)) * capture.metres_per_unit;
  }
  bool r_max_given = false;
  if (const auto lens = value.find("lens")) read_lens(*lens, model, r_max_given);
  if (!r_max_given) model.r_max = fvv_camera_r_max(&model);
  fvv_diagnostic diagnostic = {};
  if (fvv_camera_validate(&model, &diagnostic) != FVV_OK) value.fail(diagnostic.message);
  if (const auto pictures = value.find("pictures")) camera.pictures = read_pattern(*pictures, capture.frames);
  if (const auto masks = value.find("masks")) {
    if (!camera.pictures) masks->fail("expected pictures wherever there are masks");
    camera.masks = read_pattern(*masks, capture.frames);
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
    Camera camera = read_camera(value.item(i), capture, pixel_centre);
    for (size_t j = 0; j < i; j++)
      if (capture.cameras[j].calibration.id == camera.calibration.id)
        value.item(i).at("id").fail("expected an id of its own, found " +
                                    std::to_string(camera.calibration.id) + " as in /cameras/" +
                                    std::to_string(j));
    capture.cameras.push_back(std::move(camera));
  }
}

} // namespace fvv::capture
