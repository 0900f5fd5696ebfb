// Files of OpenCV's calibration programs, one camera in each: cv::FileStorage, camera_info of ROS, plain
// lists. OpenCV's axes and coefficients are those of fvv; its pixel centres lie at integers.

#include "scene/src/import/fields.h"

#include <algorithm>
#include <filesystem>

namespace fvv::import {

namespace {

// The names of lens models that programs beside OpenCV write.
bool is_fisheye(const Fields &fields) {
  if (const Node *flag = fields.find({"fisheye_model"})) return fields.integer(*flag, 0, 1) == 1;
  const Node *model = fields.find({"distortion_model"});
  if (!model) return false;
  for (const char *name : {"equidistant", "fisheye", "kannala_brandt4"})
    if (model->text == name) return true;
  for (const char *name : {"plumb_bob", "rational_polynomial", "radtan", "opencv", "none", ""})
    if (model->text == name) return false;
  fields.fail(*model, "expected plumb_bob, rational_polynomial or equidistant for distortion_model, found " +
                          scene::quote(model->text));
}

} // namespace

Calibration read_opencv(const std::vector<std::string> &files) {
  Calibration calibration;
  for (const std::string &path : files) {
    const Node root = parse_storage(path);
    const Fields fields(path, root);
    scene::Camera camera;
    camera.set_name(std::filesystem::path(path).stem().string());
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer cameras
    set_size(fields, model);
    set_matrix(fields, fields.at({"camera_matrix", "cameraMatrix", "K", "M", "mtx"}), model);
    set_lens(fields, fields.at({"distortion_coefficients", "distCoeffs", "dist_coeffs", "D", "dist"}),
             is_fisheye(fields), model);
    if (fields.find({"rectification_matrix"}) && !fields.find({"rvec", "R"}))
      throw Error(path +
                  ": is a camera_info of ROS, which has no pose: expected rvec or R, and tvec or T, world "
                  "to camera, beside its keys");
    const Node &turn = fields.at({"rvec", "R"});
    if (turn.name == "rvec") {
      set_rotation_vector(fields.vector(turn, 3), model);
    } else {
      const auto r = fields.square(turn);
      std::copy(r.begin(), r.end(), model.rotation);
    }
    const auto t = fields.vector(fields.at({"tvec", "T", "t"}), 3);
    std::copy(t.begin(), t.end(), model.translation);
    append(calibration, std::move(camera), path);
  }
  return calibration;
}

} // namespace fvv::import
