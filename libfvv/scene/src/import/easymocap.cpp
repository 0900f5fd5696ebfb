// intri.yml and extri.yml of EasyMocap, EasyVolcap and the ZJU-MoCap sets: cv::FileStorage with the keys
// K_NAME, dist_NAME, R_NAME or Rot_NAME, and T_NAME of each camera of "names". World to camera, OpenCV's axes
// and pixel centres.

#include "scene/src/import/fields.h"

#include <algorithm>

namespace fvv::import {

namespace {

// Where the files have no H_NAME and W_NAME, which may be reals, the size is the caller's.
void set_size_of(const Fields &fields, const std::string &path, const std::string &name, uint32_t width,
                 uint32_t height, fvv_camera &camera) {
  const Node *w = fields.find({("W_" + name).c_str()}), *h = fields.find({("H_" + name).c_str()});
  camera.width = w ? pixels_of(fields, *w, fields.number(*w)) : width;
  camera.height = h ? pixels_of(fields, *h, fields.number(*h)) : height;
  if (!camera.width || !camera.height)
    throw Error(path + ": has no W_" + name + " and H_" + name + ": pass the size of the pictures");
}

} // namespace

Calibration read_easymocap(const std::string &folder, uint32_t width, uint32_t height) {
  const std::string inner = folder + "/intri.yml", outer = folder + "/extri.yml";
  const Node intrinsics = parse_storage(inner), extrinsics = parse_storage(outer);
  const Fields in(inner, intrinsics), out(outer, extrinsics);
  Calibration calibration;
  for (const Node &entry : in.at({"names"}).children) {
    const std::string &name = entry.text;
    if (!entry.is_scalar || name.empty()) in.fail(entry, "expected names of cameras");
    scene::Camera camera;
    camera.set_name(name);
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer cameras
    set_size_of(in, inner, name, width, height, model);
    set_matrix(in, in.at({("K_" + name).c_str()}), model);
    const std::string long_name = "dist_" + name, short_name = "D_" + name;
    if (const Node *lens = in.find({long_name.c_str(), short_name.c_str()}))
      set_lens(in, *lens, false, model);
    // Both are written; the matrix has lost less to rounding.
    const Node *matrix = out.find({("Rot_" + name).c_str()});
    set_turn(out, matrix ? *matrix : out.at({("R_" + name).c_str()}), model);
    const auto t = out.vector(out.at({("T_" + name).c_str()}), 3);
    std::copy(t.begin(), t.end(), model.translation);
    append(calibration, std::move(camera), inner + ": " + name);
  }
  require_cameras(calibration, inner);
  return calibration;
}

} // namespace fvv::import
