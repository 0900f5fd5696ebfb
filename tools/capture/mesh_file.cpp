// capture/mesh_file.cpp: which reader and writer belongs to which file name, and what all of them share.
#include "capture/mesh_file.h"
#include "capture/gltf/pose.h"
#include "capture/mesh_check.h"
#include "capture/text_scan.h"

extern "C" {
#include "base/memory.h"
}

#include <cmath>
#include <filesystem>

namespace fvv::capture {

namespace {

// Lower case, as ASCII: file names do not follow the locale.
std::string extension_of(const std::string &path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char &c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

[[noreturn]] void fail_extension(const std::string &path, const std::string &extension,
                                 const char *expected) {
  throw FileError(path + ": expected a mesh file with extension " + expected + ", found " +
                  (extension.empty() ? "no extension" : quote(extension)));
}

} // namespace

bool is_gltf(const std::string &path) {
  const std::string extension = extension_of(path);
  return extension == ".glb" || extension == ".gltf";
}

Mesh read_mesh(const std::string &path, const fvv_limits *limits, MeshReport *report, bool texture,
               bool normals) {
  const std::string extension = extension_of(path);
  const auto parse = extension == ".obj"   ? parse_obj
                     : extension == ".ply" ? parse_ply
                     : extension == ".drc" ? parse_drc
                     : is_gltf(path)       ? parse_gltf
                                           : nullptr;
  if (!parse) fail_extension(path, extension, ".obj, .ply, .drc, .glb or .gltf");
  return parse(read_file(path, max_mesh_file), path, limits, report, texture, normals);
}

Mesh parse_gltf(std::string_view bytes, const std::string &name, const fvv_limits *limits, MeshReport *report,
                bool texture, bool normals) {
  const gltf::Scene scene =
      gltf::read_scene(bytes, name, gltf::NoAnimation{}, fvv_limits_or_default(limits),
                       texture ? gltf::Texture::coordinates : gltf::Texture::skipped, normals);
  if (report) report->lines_and_points += scene.report.lines_and_points;
  return gltf::pose(scene, std::nullopt);
}

std::string parse_gltf_picture(std::string_view bytes, const std::string &name) {
  return gltf::read_scene(bytes, name, gltf::NoAnimation{}, fvv_limits_or_default(nullptr),
                          gltf::Texture::picture)
      .picture;
}

void write_mesh(const Mesh &mesh, const Lattice &lattice, const std::string &path) {
  const std::string extension = extension_of(path);
  if (extension == ".obj")
    write_file(path, format_obj(mesh, path));
  else if (extension == ".ply")
    write_file(path, format_ply(mesh, path));
  else if (extension == ".drc")
    write_file(path, format_drc(mesh, lattice, path));
  else
    fail_extension(path, extension, ".obj, .ply or .drc");
}

void append_fan(Mesh &mesh, const std::vector<uint32_t> &corners, MeshReport &report) {
  if (corners.size() > 3) report.polygons++;
  for (size_t i = 1; i + 1 < corners.size(); i++)
    mesh.faces.insert(mesh.faces.end(), {corners[0], corners[i], corners[i + 1]});
}

void check_writable(const Mesh &mesh, const std::string &name) {
  if (mesh.faces.empty()) throw FileError(name + ": the mesh to write has no face");
  if (mesh.positions.size() % 3 || mesh.faces.size() % 3 || mesh.vertex_count() > INT32_MAX)
    throw FileError(name + ": the mesh to write has " + std::to_string(mesh.positions.size()) +
                    " coordinates and " + std::to_string(mesh.faces.size()) +
                    " corners, expected multiples of 3 and at most 2147483647 vertices");
  for (size_t i = 0; i < mesh.positions.size(); i++)
    if (!std::isfinite(mesh.positions[i]))
      throw FileError(name + ": vertex " + std::to_string(i / 3) + " of the mesh to write is not finite");
  if (!mesh.texture.empty() && mesh.texture.size() != mesh.vertex_count() * 2)
    throw FileError(name + ": the mesh to write has " + std::to_string(mesh.texture.size()) +
                    " texture coordinates, expected two for each of " + std::to_string(mesh.vertex_count()) +
                    " vertices");
  for (size_t i = 0; i < mesh.texture.size(); i++)
    if (!std::isfinite(mesh.texture[i]))
      throw FileError(name + ": a texture coordinate of vertex " + std::to_string(i / 2) +
                      " of the mesh to write is not finite");
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size())
    throw FileError(name + ": the mesh to write has " + std::to_string(mesh.normals.size()) +
                    " coordinates of normals, expected three for each of " +
                    std::to_string(mesh.vertex_count()) + " vertices");
  for (size_t i = 0; i < mesh.normals.size(); i++)
    if (!std::isfinite(mesh.normals[i]))
      throw FileError(name + ": the normal of vertex " + std::to_string(i / 3) +
                      " of the mesh to write is not finite");
  for (size_t i = 0; i < mesh.faces.size(); i++)
    if (mesh.faces[i] >= mesh.vertex_count())
      throw FileError(name + ": face " + std::to_string(i / 3) + " of the mesh to write has index " +
                      std::to_string(mesh.faces[i]) + " of " + std::to_string(mesh.vertex_count()) +
                      " vertices");
}

} // namespace fvv::capture
