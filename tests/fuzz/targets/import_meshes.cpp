// Mesh files of other programs. A reader returns a mesh whose indices and arrays fit, or throws Error.
#include "../fuzz.h"

#include "fvv_cxx/error.h"
#include "fvv_scene/environment.h"
#include "fvv_scene/mesh_file.h"
#include "scene/src/mtl.h"

#include <string_view>

namespace {

void expect_consistent(const fvv::geometry::Mesh &mesh) {
  const size_t vertices = mesh.vertex_count();
  for (const uint32_t index : mesh.faces) fuzz::expect(index < vertices, "faces index vertices");
  fuzz::expect(mesh.texture.empty() || mesh.texture.size() == 2 * vertices,
               "each vertex has its texture coordinates");
  fuzz::expect(mesh.normals.empty() || mesh.normals.size() == 3 * vertices, "each vertex has its normal");
}

template <class Parse> void parse(const uint8_t *data, size_t size, const Parse &parse_file) {
  // A copy of exactly this size, and the digest chooses what is read.
  const fuzz::Bytes bytes(data, data + size);
  const std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
  const uint32_t options = fuzz::digest(data, size);
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = limits.max_faces = 1 << 16;
  fvv::scene::MeshReport report;
  fvv::scene::MeshExtras extras;
  try {
    expect_consistent(
        parse_file(text, "input", &limits, &report, (options & 1) != 0, (options & 2) != 0, &extras));
  } catch (const fvv::Error &) {}
}

} // namespace

FVV_FUZZ_TARGET(obj, fuzz::Form::bytes) {
  parse(data, size, fvv::scene::parse_obj);
  const std::string_view text(reinterpret_cast<const char *>(data), size);
  // Libraries are files; the bytes are read as one, too.
  try {
    (void)fvv::scene::parse_obj_materials(text, "input");
  } catch (const fvv::Error &) {}
  try {
    for (const auto &[material, picture] : fvv::scene::parse_mtl(text, "input"))
      fuzz::expect(!material.empty() && !picture.file.empty() && picture.file[0] != '/' &&
                       picture.file.find(':') == picture.file.npos &&
                       picture.file.find('\\') == picture.file.npos,
                   "a material has a relative name of its picture");
  } catch (const fvv::Error &) {}
}

FVV_FUZZ_TARGET(ply, fuzz::Form::bytes) {
  parse(data, size, fvv::scene::parse_ply);
}

FVV_FUZZ_TARGET(gltf, fuzz::Form::glb) {
  parse(data, size, fvv::scene::parse_gltf);
  const std::string_view text(reinterpret_cast<const char *>(data), size);
  try {
    for (const fvv::scene::EnvironmentPart &part : fvv::scene::parse_environment(text, "input").parts)
      expect_consistent(part.mesh);
  } catch (const fvv::Error &) {}
  try {
    (void)fvv::scene::parse_gltf_picture(text, "input");
  } catch (const fvv::Error &) {}
}
