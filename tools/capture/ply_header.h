// capture/ply_header.h: the text in front of every PLY file: which elements follow, and how each is laid out.
// Checked completely, counts against the size of the file included, before a body is read.
#pragma once

#include "capture/mesh_file.h"

#include <string>
#include <string_view>
#include <vector>

namespace fvv::capture {

enum class PlyFormat { ascii, little_endian, big_endian };

struct PlyType {
  unsigned size; // bytes in binary files; 0: not a list
  bool is_float, is_signed;
};

// What a property is to a mesh. unused ones are skipped.
enum class PlyRole { unused, x, y, z, u, v, nx, ny, nz, corners, corner_texture, texture_number };

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
};

// texture: texture coordinates have to be there; else their properties are unused. normals: they may be
// there.
PlyHeader parse_ply_header(std::string_view bytes, const std::string &name, const fvv_limits &limits,
                           bool texture, bool normals);

} // namespace fvv::capture
