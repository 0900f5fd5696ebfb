// camchain.yaml of Kalibr: cam0, cam1, ... with intrinsics fu fv pu pv, a distortion of four coefficients,
// and T_cn_cnm1, which takes points from the camera before into this one. The world is the first camera's.
// OpenCV's axes and pixel centres, metres.

#include "scene/src/import/fields.h"

namespace fvv::import {

namespace {

void set_camera(const Fields &fields, fvv_camera &camera) {
  const Node &kind = fields.at({"camera_model"});
  if (kind.text != "pinhole")
    fields.fail(kind,
                "expected pinhole for camera_model, found " + scene::quote(kind.text) +
                    ", whose projection fvv does not have: calibrate with pinhole-equi or pinhole-radtan");
  const auto f = fields.vector(fields.at({"intrinsics"}), 4);
  camera.fx = f[0];
  camera.fy = f[1];
  camera.cx = f[2] + 0.5;
  camera.cy = f[3] + 0.5;
  set_size(fields, camera);
  const Node &lens = fields.at({"distortion_model"});
  if (lens.text == "none") return;
  if (lens.text != "radtan" && lens.text != "equidistant")
    fields.fail(lens, "expected radtan, equidistant or none for distortion_model, found " +
                          scene::quote(lens.text));
  set_lens(fields, fields.at({"distortion_coeffs"}), lens.text == "equidistant", camera);
}

// next = step * before, of rigid 3 x 4 matrices.
void follow(const std::vector<double> &step, const fvv_camera &before, fvv_camera &next) {
  for (size_t row = 0; row < 3; row++) {
    next.translation[row] = step[4 * row + 3];
    for (size_t k = 0; k < 3; k++) {
      next.translation[row] += step[4 * row + k] * before.translation[k];
      next.rotation[3 * row + k] = 0;
      for (size_t j = 0; j < 3; j++)
        next.rotation[3 * row + k] += step[4 * row + j] * before.rotation[3 * j + k];
    }
  }
}

} // namespace

Calibration read_kalibr(const std::string &file) {
  const Node root = parse_storage(file);
  Calibration calibration;
  calibration.metres_per_unit = 1;
  for (const Node &node : root.children) {
    const std::string expected = "cam" + std::to_string(calibration.cameras.size());
    if (node.name != expected)
      fail_at(file, node.line, "expected " + expected + ", found " + scene::quote(node.name));
    const Fields fields(file, node);
    scene::Camera camera;
    camera.set_name(node.name);
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer cameras
    set_camera(fields, model);
    if (calibration.cameras.empty()) {
      model.rotation[0] = model.rotation[4] = model.rotation[8] = 1;
    } else {
      const Node &chain = fields.at({"T_cn_cnm1"});
      const Fields::Matrix step = fields.matrix(chain);
      if (step.values.size() != 16 || step.columns != 4)
        fields.fail(chain, "expected 4 x 4 numbers for T_cn_cnm1");
      follow(step.values, calibration.cameras.back().calibration, model);
    }
    append(calibration, std::move(camera), file + ": " + node.name);
  }
  require_cameras(calibration, file);
  return calibration;
}

} // namespace fvv::import
