// Material libraries of Wavefront OBJ (.mtl), as far as the pictures of diffuse colours go.
#pragma once

#include "scene/src/atlas/atlas.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene {

// What map_Kd names, by material: relative to the folder of the library, with / between folders. Materials
// without map_Kd are left out. Throws Error with name and line, also for options that move or tint the
// picture, and for names that are absolute.
struct MaterialPicture {
  std::string file;
  bool is_clamped = false; // -clamp on: beyond its borders it goes on as there; else it repeats
};
using MaterialPictures = std::map<std::string, MaterialPicture, std::less<>>;
MaterialPictures parse_mtl(std::string_view bytes, const std::string &name);

// Kd by material, display values; those without are left out.
std::map<std::string, std::array<uint8_t, 3>, std::less<>> parse_mtl_colours(std::string_view bytes);

// The path of a picture that a file with meshes names: below the folder of that, or in one beside it. Throws
// Error for other places.
std::string picture_path(const std::string &mesh, const std::string &folder, const std::string &name,
                         const std::string &where);

// What each of the used materials shows, likewise: its picture, else its colour.
std::vector<FacePicture> material_pictures(const std::string &obj,
                                           const std::vector<std::string_view> &libraries,
                                           const std::vector<std::string_view> &used);

// Reads the libraries of an OBJ file. obj: its path. libraries: what follows each mtllib; used: the materials
// of its faces, "" for none; of unlike pictures it names the first. Throws Error.
ObjMaterials read_materials(const std::string &obj, const std::vector<std::string_view> &libraries,
                            const std::vector<std::string_view> &used);

} // namespace fvv::scene
