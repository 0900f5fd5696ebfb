// Draco meshes as the points that graphics interfaces draw, each with a value of every attribute, as
// KHR_draco_mesh_compression of glTF has them.
#pragma once

#include "fvv/types.h"
#include "fvv_geometry/mesh.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene {

struct DrcValues {
  unsigned components;
  unsigned type;     // of a component, by OpenGL's codes 5120 to 5126; 0: none of these
  std::string bytes; // little-endian, one value after the other for every point
};

struct DrcPoints {
  uint32_t count;
  std::vector<uint32_t> triangles;          // 3 points each, below count
  std::map<uint32_t, DrcValues> attributes; // by the requested unique identifiers
};

// Checked as by parse_drc. Error "name: what".
DrcPoints parse_drc_points(std::string_view bytes, const std::string &name, const fvv_limits &limits,
                           const std::vector<uint32_t> &attributes);

// The identifiers of a mesh's attributes are 0, 1, ...: positions, texture coordinates and normals, as far as
// it has them. Vertices and faces come in another order, and vertices without a face not at all. Positions
// are on the lattice, in metres, and stay on their points; texture coordinates are whole multiples of
// 2^-texture_bits, and stay what they are; normals are not quantised. Error when float32 is too coarse for
// the lattice.
std::string format_drc_points(const geometry::Mesh &mesh, const geometry::Lattice &lattice,
                              unsigned texture_bits, const std::string &name);

} // namespace fvv::scene
