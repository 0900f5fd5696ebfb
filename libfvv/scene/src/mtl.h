// Material libraries of Wavefront OBJ (.mtl), as far as the pictures of diffuse colours go.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene {

// What map_Kd names, by material: relative to the folder of the library, with / between folders. Materials
// without map_Kd are left out. Throws Error with name and line, also for options that move or tint the
// picture, and for names that are absolute.
using MaterialPictures = std::map<std::string, std::string, std::less<>>;
MaterialPictures parse_mtl(std::string_view bytes, const std::string &name);

// Reads the libraries of an OBJ file. obj: its path. libraries: what follows each mtllib; used: the materials
// of its faces, "" for none. Throws Error, also if the materials have unlike pictures.
ObjMaterials read_materials(const std::string &obj, const std::vector<std::string_view> &libraries,
                            const std::vector<std::string_view> &used);

} // namespace fvv::scene
