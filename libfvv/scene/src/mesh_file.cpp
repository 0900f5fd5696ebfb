// Chooses reader and writer by file name, and their common checks.

#include "fvv_scene/mesh_file.h"
#include "fvv_cxx/input_file.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"
#include "scene/src/atlas/atlas.h"
#include "scene/src/gltf/pose.h"
#include "scene/src/mesh_build.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

namespace fvv::scene {

namespace {

// Lower case, as ASCII: file names do not follow the locale.
std::string extension_of(const std::string &path) {
  return lower(std::filesystem::path(path).extension().string());
}

[[noreturn]] void fail_extension(const std::string &path, const std::string &extension,
                                 const char *expected) {
  throw Error(path + ": expected a mesh file with extension " + expected + ", found " +
              (extension.empty() ? "no extension" : quote(extension)));
}

} // namespace

bool is_gltf(const std::string &path) {
  const std::string extension = extension_of(path);
  return extension == ".glb" || extension == ".gltf";
}

void check_mesh_memory(const std::string &path, const media::MemoryLimit &limit) {
  if (limit.bytes == UINT64_MAX) return;
  std::error_code error;
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error) return; // whatever reads it reports it
  // A mesh at the default limits, its copies included.
  constexpr uint64_t largest = uint64_t(1) << 30;
  const std::string extension = extension_of(path);
  // A corner of a polygon takes two bytes in a file and twelve in a triangle; Draco has no bit for some
  // faces.
  const uint64_t times = extension == ".obj" || extension == ".ply" ? 16 : is_gltf(path) ? 64 : 1000;
  media::check_memory(path + ": reading a mesh file of " + std::to_string(size) + " bytes",
                      size + std::min(largest, std::min(size, largest) * times), limit);
}

Mesh parse_mesh(const std::string &path, const fvv_limits *limits, MeshReport *report, bool texture,
                bool normals, MeshExtras *extras) {
  const std::string extension = extension_of(path);
  const auto parse = extension == ".obj"                            ? parse_obj
                     : extension == ".ply"                          ? parse_ply
                     : extension == ".drc" || extension == ".draco" ? parse_drc
                     : is_gltf(path)                                ? parse_gltf
                                                                    : nullptr;
  if (!parse) fail_extension(path, extension, ".obj, .ply, .drc, .draco, .glb or .gltf");
  return parse(read_file(path, max_mesh_file), path, limits, report, texture, normals, extras);
}

Mesh read_mesh(const std::string &path, const fvv_limits *limits, MeshReport *report, bool texture,
               bool normals, MeshExtras *extras) {
  Mesh mesh = parse_mesh(path, limits, report, texture, normals, extras);
  if (texture) settle_texture(mesh, {}, limits_or_default(limits), path);
  return mesh;
}

Mesh parse_gltf(std::string_view bytes, const std::string &name, const fvv_limits *limits, MeshReport *report,
                bool texture, bool normals, MeshExtras *extras) {
  const gltf::Scene scene = gltf::read_scene(bytes, name, gltf::NoAnimation{}, limits_or_default(limits),
                                             gltf::texture_for(texture, extras), normals);
  if (report) report->lines_and_points += scene.report.lines_and_points;
  return gltf::pose(scene, std::nullopt, extras);
}

Mesh parse_gltf_pictures(std::string_view bytes, const std::string &name, const fvv_limits *limits,
                         MeshReport *report, bool normals, FacePictures &faces) {
  const gltf::Scene scene = gltf::read_scene(bytes, name, gltf::NoAnimation{}, limits_or_default(limits),
                                             gltf::Texture::pictures, normals);
  if (report) report->lines_and_points += scene.report.lines_and_points;
  faces.replace_pictures(gltf::face_pictures(scene));
  return gltf::pose(scene, std::nullopt);
}

bool is_empty_mesh(const std::string &path) {
  constexpr size_t enough = size_t(1) << 16; // of a header; a file of another kind beyond it has content
  const std::string extension = extension_of(path);
  const bool ply = extension == ".ply";
  if (!ply && extension != ".obj" && !is_gltf(path)) return false;
  if (!why_unreadable(path).empty()) return false; // what is wrong is said when it is read
  std::ifstream file(path, std::ios::binary);
  std::string start(enough + 1, '\0'), kept;
  file.read(&start[0], std::streamsize(start.size()));
  start.resize(size_t(file.gcount()));
  if (is_gltf(path)) return start.size() <= enough && gltf::draws_nothing(start, path);
  std::istringstream lines{std::string(as_usual(start, kept))};
  std::string line;
  bool vertices = false, faces = false;
  // Of OBJ: a page that says that a file is missing is no empty stage.
  constexpr std::string_view known[] = {"g", "o", "s", "vt", "vn", "mtllib", "usemtl"};
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    if (!ply && (first == "v" || first == "f")) return false;
    if (!ply) {
      if (!first.empty() && first[0] != '#' &&
          std::find(std::begin(known), std::end(known), first) == std::end(known))
        return false; // the reader says what is wrong
      continue;
    }
    vertices = vertices || (first == "element" && second == "vertex" && third == "0");
    faces = faces || (first == "element" && (second == "face" || second == "tristrips") && third != "0");
    if (first == "end_header") return vertices && !faces;
  }
  return !ply && !start.empty() && start.size() <= enough;
}

std::string parse_gltf_picture(std::string_view bytes, const std::string &name) {
  return gltf::read_scene(bytes, name, gltf::NoAnimation{}, limits_or_default(nullptr),
                          gltf::Texture::picture)
      .picture;
}

bool may_bring_picture(const std::string &path) {
  return is_gltf(path) || extension_of(path) == ".obj" || extension_of(path) == ".ply";
}

namespace {

// The pictures of a mesh file, at least one.
FacePictures mesh_pictures(const std::string &path) {
  if (!may_bring_picture(path)) fail_extension(path, extension_of(path), ".glb, .gltf, .obj or .ply");
  const std::string bytes = read_file(path, max_mesh_file);
  FacePictures faces;
  if (is_gltf(path)) {
    faces = gltf::face_pictures(gltf::read_scene(bytes, path, gltf::NoAnimation{}, limits_or_default(nullptr),
                                                 gltf::Texture::pictures));
    if (!faces.has_picture()) {
      FacePicture only = {path};
      only.load = [bytes, path] { return parse_gltf_picture(bytes, path); };
      faces = {};
      faces.add(std::move(only), path);
    }
  } else if (extension_of(path) == ".ply") {
    parse_ply_pictures(bytes, path, nullptr, nullptr, false, faces);
  } else {
    const std::optional<std::string> picture = parse_obj_materials(bytes, path).picture;
    if (!picture) throw Error(path + ": expected faces of a material with map_Kd, found none");
    if (const std::string why = why_unreadable(*picture); !why.empty())
      throw Error(path + ": expected the picture " + quote(*picture) + " of map_Kd, which " + why);
    parse_obj_pictures(bytes, path, nullptr, nullptr, false, faces);
  }
  return faces;
}

} // namespace

MeshPicture read_mesh_picture(const std::string &path, const media::MemoryLimit &limit) {
  FacePictures faces = mesh_pictures(path);
  faces.limit = limit;
  const bool is_only = faces.pictures.size() == 1;
  return {atlas_picture(faces, path), is_only ? faces.pictures[0].name : path};
}

AtlasSize mesh_picture_size(const std::string &path) {
  return atlas_size(mesh_pictures(path), path);
}

std::string format_mesh(const Mesh &mesh, const Lattice &lattice, const std::string &name,
                        const std::vector<uint8_t> &colours) {
  const std::string extension = extension_of(name);
  if (extension == ".obj") return format_obj(mesh, name, colours);
  if (extension == ".ply") return format_ply(mesh, name, colours);
  if (extension == ".drc") return format_drc(mesh, lattice, name);
  fail_extension(name, extension, ".obj, .ply or .drc");
}

void write_mesh(const Mesh &mesh, const Lattice &lattice, const std::string &path) {
  write_file(path, format_mesh(mesh, lattice, path));
}

void append_fan(Mesh &mesh, const std::vector<uint32_t> &corners, MeshReport &report) {
  if (corners.size() > 3) report.polygons++;
  for (size_t i = 1; i + 1 < corners.size(); i++)
    mesh.faces.insert(mesh.faces.end(), {corners[0], corners[i], corners[i + 1]});
}

std::vector<uint8_t> display_colours(const std::vector<double> &values, double white) {
  std::vector<uint8_t> out;
  for (const double value : values)
    out.push_back(std::isnan(value) ? uint8_t(128)
                                    : uint8_t(std::floor(std::clamp(value / white, 0.0, 1.0) * 255 + 0.5)));
  return out;
}

double white_of(const std::vector<double> &values, bool are_integers) {
  double most = 0;
  size_t above_one = 0, above_zero = 0;
  bool are_whole = true;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    most = std::max(most, value);
    above_one += value > 1;
    above_zero += value > 0;
    are_whole = are_whole && value == std::floor(value);
  }
  if (are_integers || (are_whole && most > 1)) return most > 255 ? 65535 : 255;
  return 2 * above_one > above_zero ? 255 : 1;
}

std::string_view as_usual(std::string_view bytes, std::string &kept) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (bytes.substr(0, mark.size()) == mark) bytes.remove_prefix(mark.size());
  if (bytes.find('\n') != bytes.npos || bytes.find('\r') == bytes.npos) return bytes;
  kept = bytes;
  std::replace(kept.begin(), kept.end(), '\r', '\n');
  return kept;
}

void settle_unused(Mesh &mesh, const std::string &name) {
  const auto is_number = [&](size_t vertex) {
    return std::all_of(&mesh.positions[3 * vertex], &mesh.positions[3 * vertex] + 3,
                       [](double x) { return std::isfinite(x); });
  };
  std::vector<size_t> missing;
  for (size_t vertex = 0; vertex < mesh.vertex_count(); vertex++)
    if (!is_number(vertex)) missing.push_back(vertex);
  if (missing.empty()) return;
  for (size_t i = 0; i < mesh.faces.size(); i++)
    if (std::binary_search(missing.begin(), missing.end(), size_t(mesh.faces[i])))
      throw Error(name + ": face " + std::to_string(i / 3) + " uses vertex " + std::to_string(mesh.faces[i]) +
                  " (from 0), whose coordinates are not finite numbers");
  for (const size_t vertex : missing) std::fill_n(&mesh.positions[3 * vertex], 3, 0.0);
}

// From texture coordinates and normals per corner, as modelling programs store them,
// to one of each per vertex, as graphics interfaces and fvv want them.

void split_seams(Mesh &mesh, const std::vector<double> &texture, const std::vector<double> &normals,
                 const fvv_limits &limits, const std::string &name) {
  using Values = std::array<double, 5>; // u v, x y z; 0 where there are none
  const auto at_corner = [&](size_t i) {
    Values values = {};
    if (!texture.empty()) std::copy_n(&texture[i * 2], 2, &values[0]);
    if (!normals.empty()) std::copy_n(&normals[i * 3], 3, &values[2]);
    return values;
  };
  if (!texture.empty()) mesh.texture.assign(mesh.vertex_count() * 2, 0);
  if (!normals.empty()) mesh.normals.assign(mesh.vertex_count() * 3, 0);
  std::vector<Values> own(mesh.vertex_count());
  std::vector<bool> taken(mesh.vertex_count());
  // Few vertices lie on seams; a map keeps a file that is all seams from taking quadratic time.
  std::map<std::pair<uint32_t, Values>, uint32_t> copies;
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const uint32_t vertex = mesh.faces[i];
    const Values values = at_corner(i);
    if (!taken[vertex]) {
      taken[vertex] = true;
      own[vertex] = values;
      if (!texture.empty()) std::copy_n(&values[0], 2, &mesh.texture[vertex * size_t(2)]);
      if (!normals.empty()) std::copy_n(&values[2], 3, &mesh.normals[vertex * size_t(3)]);
    }
    if (own[vertex] == values) continue;
    const uint32_t next = static_cast<uint32_t>(mesh.vertex_count());
    const auto [copy, is_new] = copies.emplace(std::pair(vertex, values), next);
    mesh.faces[i] = copy->second;
    if (!is_new) continue;
    if (next >= limits.max_vertices)
      throw Error(name + ": more than the allowed " + std::to_string(limits.max_vertices) +
                  " vertices, split where texture coordinates or normals differ");
    for (size_t axis = 0; axis < 3; axis++)
      mesh.positions.push_back(mesh.positions[vertex * size_t(3) + axis]);
    if (!texture.empty()) mesh.texture.insert(mesh.texture.end(), &values[0], &values[2]);
    if (!normals.empty()) mesh.normals.insert(mesh.normals.end(), &values[2], &values[2] + 3);
  }
}

} // namespace fvv::scene
