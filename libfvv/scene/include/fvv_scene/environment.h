// The static environment around the action, from and to glTF: meshes, each in one colour or with one picture,
// and lights.
#pragma once

#include "fvv/environment.h"
#include "fvv_scene/mesh_file.h"
#include "fvv_scene/transform.h"

#include <optional>

namespace fvv::scene {

// mesh: texture as in Mesh, but any number of repetitions of the picture; empty without one. Normals, or
// none.
struct EnvironmentPart {
  Mesh mesh;
  std::optional<size_t> picture; // of Environment::pictures
  double colour[3] = {1, 1, 1};  // linear light, 0 to 1; a factor where there is a picture
  bool unlit = false, double_sided = false;
  bool clamped = false; // beyond its edge the picture continues with its last pixel, else it repeats
  std::optional<Lattice> lattice; // of its positions, when they come from a stream
};

struct Environment {
  std::vector<EnvironmentPart> parts;
  std::vector<std::string> pictures; // files of PNG or JPEG, not decoded yet
  std::vector<fvv_light> lights;
  std::vector<std::string> notes; // sentences about content of the file that is not here

  // Applies to positions, normals and lights. Faces are turned round when it mirrors.
  void transform(const gltf::Transform &by);
};

// glTF 2.0, as parse_gltf reads it: all triangles of the default scene, those of one material as one part. Of
// materials the base colour counts (factor without alpha, picture, KHR_texture_transform),
// KHR_materials_unlit, doubleSided, and whether the sampler clamps. Lights: KHR_lights_punctual of the nodes
// of the default scene; they cast shadows unless "extras": {"casts_shadows": false} of the light says
// otherwise.
Environment parse_environment(std::string_view bytes, const std::string &name,
                              const fvv_limits *limits = nullptr);

// A GLB, the same bytes for the same environment everywhere, that parse_environment reads back. Positions are
// float32, relative to an origin where they are too large for it, as those of format_run (mesh_run.h): every
// coordinate is verified to lie on the same point of the part's lattice, else of this one, again; the first
// that does not is an error.
std::string format_environment(const Environment &environment, const Lattice &lattice,
                               const std::string &name, bool *is_local = nullptr);

} // namespace fvv::scene
