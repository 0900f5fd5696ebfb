// capture/capture.cpp: paths and meshes of a capture.
#include "capture/capture.h"

#include <filesystem>

namespace fvv::capture {

void Camera::set_name(const std::string &text) {
  name = std::make_shared<const std::string>(text);
  calibration.name = name->data();
  calibration.name_size = name->size();
}

std::vector<int64_t> Frames::numbers() const {
  std::vector<int64_t> out;
  for (int64_t i = 0; i < count; i++) out.push_back(number(i));
  return out;
}

std::string Capture::resolve(const std::string &file) const {
  // Joining with an absolute path gives that path.
  return (std::filesystem::path(path).parent_path() / file).string();
}

std::string Capture::mesh_path(int64_t frame) const {
  return resolve(meshes.value().file(frame));
}
std::string Capture::picture_path(const Camera &camera, int64_t frame) const {
  return resolve(camera.pictures.value().file(frame));
}
std::string Capture::mask_path(const Camera &camera, int64_t frame) const {
  return resolve(camera.masks.value().file(frame));
}

Mesh load_mesh(const Capture &capture, int64_t frame, const fvv_limits *limits, MeshReport *report) {
  Mesh mesh = read_mesh(capture.mesh_path(frame), limits, report);
  for (double &coordinate : mesh.positions) coordinate *= capture.metres_per_unit;
  return mesh;
}

} // namespace fvv::capture
