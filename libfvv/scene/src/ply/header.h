// The header of a PLY file: what its elements and properties mean for a mesh.
#pragma once

#include "fvv/types.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene {

enum class PlyFormat { ascii, little_endian, big_endian };

struct PlyType {
  unsigned size; // bytes in binary files; 0: not a list
  bool is_float, is_signed;
};

// The meaning of a property for a mesh. unused ones are skipped.
enum class PlyRole {
  unused,
  x,
  y,
  z,
  u,
  v,
  nx,
  ny,
  nz,
  red,
  green,
  blue,
  corners,
  strips, // of triangles, separated by -1
  corner_texture,
  texture_number
};

struct PlyProperty {
  std::string name;
  PlyType type;       // of the scalar, or of the items of a list
  PlyType count_type; // of a list's length
  PlyRole role;

  bool is_list() const { return count_type.size != 0; }
};

struct PlyElement {
  std::string name;
  uint64_t count;
  uint64_t line; // where the header declares it
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format;
  std::vector<PlyElement> elements;
  uint64_t vertex_count, face_count; // as declared; polygons count as one face here
  size_t size;                       // bytes up to the body
  uint64_t lines;                    // lines up to the body
  std::vector<std::string> pictures; // comment TextureFile, as MeshLab and OpenMVS write it
};

// texture: texture coordinates have to be there; else their properties are unused. normals: they may be
// there, and so may colours.
PlyHeader parse_ply_header(std::string_view bytes, const std::string &name, const fvv_limits &limits,
                           bool texture, bool normals, bool colours);

} // namespace fvv::scene
