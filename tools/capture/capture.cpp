// capture/capture.cpp: paths and meshes of a capture.
#include "capture/capture.h"

#include <filesystem>

namespace fvv::capture {

void Camera::set_name(const std::string &text) {
  name = std::make_shared<const std::string>(text);
  calibration.name = name->data();
  calibration.name_size = name->size();
}

fvv_camera Camera::calibration_at(int64_t frame) const {
  if (!moves()) return calibration;
  fvv_camera camera = per_frame.at(frame);
  camera.name = calibration.name;
  camera.name_size = calibration.name_size;
  return camera;
}

std::vector<int64_t> Frames::numbers() const {
  std::vector<int64_t> out;
  for (int64_t i = 0; i < count; i++) out.push_back(number(i));
  return out;
}

std::string description_file(const std::string &given) {
  std::error_code ignored;
  return std::filesystem::is_directory(given, ignored)
             ? (std::filesystem::path(given) / "capture.json").string()
             : given;
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

std::string Capture::atlas_path(int64_t frame) const {
  const Atlas &source = atlas.value();
  return source.pictures ? resolve(source.pictures->file(frame)) : mesh_path(frame);
}

double Capture::animation_time(int64_t frame) const {
  const MeshAnimation &source = *animation;
  const int64_t index = (frame - source.first) / frames.step;
  // At most 10^7 frames of less than 2^32 time units: exact as integers.
  return double(source.start.numerator) / double(source.start.denominator) +
         double(index * int64_t(frame_duration.numerator)) / double(frame_duration.denominator);
}

Mesh load_mesh(const Capture &capture, int64_t frame, const fvv_limits *limits, MeshReport *report,
               bool normals) {
  const std::string path = capture.mesh_path(frame);
  const bool texture = capture.atlas.has_value();
  Mesh mesh = capture.animation ? capture.animation->mesh(path, capture.animation_time(frame), limits, report,
                                                          texture, normals)
                                : read_mesh(path, limits, report, texture, normals);
  for (double &coordinate : mesh.positions) coordinate *= capture.metres_per_unit;
  if (capture.flip_faces) flip_faces(mesh);
  return mesh;
}

std::string load_embedded_atlas(const Capture &capture, int64_t frame) {
  const std::string path = capture.mesh_path(frame);
  return parse_gltf_picture(read_file(path, max_mesh_file), path);
}

} // namespace fvv::capture
