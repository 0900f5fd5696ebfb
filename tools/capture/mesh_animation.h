// capture/mesh_animation.h: one animated glTF file as the meshes of a whole sequence. Reads the file once,
// whoever asks first; knows nothing of frames.
#pragma once

#include "capture/mesh_file.h"

#include <memory>
#include <mutex>
#include <optional>
#include <variant>

namespace fvv::capture {

namespace gltf {
struct Scene;
}

class MeshAnimation {
public:
  using Name = std::variant<int64_t, std::string>; // an index from 0, or a name

  MeshAnimation(std::optional<Name> animation, fvv_rational from, int64_t first_frame);
  ~MeshAnimation();

  // The scene at a time in seconds, in the file's units. path: the file, the same in every call. Vertices and
  // faces are the same at every time; before the first keyframe and behind the last one the nearest counts.
  // texture, normals: as parse_gltf has it. FileError. Several threads may call these two.
  Mesh mesh(const std::string &path, double time, const fvv_limits *limits, MeshReport *report, bool texture,
            bool normals) const;
  // Time of the last keyframe in seconds; reads the file for what mesh() without normals is going to be
  // asked.
  double end(const std::string &path, bool texture) const;

  const std::optional<Name> name; // nothing: the only one
  const fvv_rational start;       // seconds from the beginning of the animation to frame number first
  const int64_t first;

private:
  const gltf::Scene &read(const std::string &path, bool texture, bool normals) const;

  mutable std::mutex mutex;
  mutable std::unique_ptr<const gltf::Scene> scenes[2][2]; // without and with texture coordinates, normals
};

} // namespace fvv::capture
