// capture/mesh_animation.cpp: meshes of one animated file.
#include "capture/mesh_animation.h"
#include "capture/gltf/pose.h"

extern "C" {
#include "base/memory.h"
}

#include <algorithm>

namespace fvv::capture {

MeshAnimation::MeshAnimation(std::optional<Name> animation, fvv_rational from, int64_t first_frame)
    : name(std::move(animation)), start(from), first(first_frame) {}
MeshAnimation::~MeshAnimation() = default;

const gltf::Scene &MeshAnimation::read(const std::string &path, bool texture, bool normals) const {
  const std::lock_guard<std::mutex> lock(mutex);
  std::unique_ptr<const gltf::Scene> &scene = scenes[texture][normals];
  if (!scene) {
    gltf::AnimationChoice choice = gltf::OnlyAnimation{};
    if (name) std::visit([&](const auto &value) { choice = value; }, *name);
    // The defaults hold for the file, those of a caller for the mesh: callers share what was read.
    scene = std::make_unique<const gltf::Scene>(
        gltf::read_scene(read_file(path, max_mesh_file), path, choice, fvv_limits_or_default(nullptr),
                         texture ? gltf::Texture::coordinates : gltf::Texture::skipped, normals));
  }
  return *scene;
}

Mesh MeshAnimation::mesh(const std::string &path, double time, const fvv_limits *limits, MeshReport *report,
                         bool texture, bool normals) const {
  const gltf::Scene &source = read(path, texture, normals);
  Mesh out = gltf::pose(source, time);
  const fvv_limits bounds = fvv_limits_or_default(limits);
  if (out.vertex_count() > bounds.max_vertices || out.face_count() > bounds.max_faces)
    throw FileError(path + ": " + std::to_string(out.vertex_count()) + " vertices and " +
                    std::to_string(out.face_count()) + " faces, at most " +
                    std::to_string(bounds.max_vertices) + " and " + std::to_string(bounds.max_faces) +
                    " are allowed");
  if (report) report->lines_and_points += source.report.lines_and_points;
  return out;
}

double MeshAnimation::end(const std::string &path, bool texture) const {
  double last = 0;
  for (const gltf::Channel &channel : read(path, texture, false).channels)
    last = std::max(last, channel.times.back());
  return last;
}

} // namespace fvv::capture
