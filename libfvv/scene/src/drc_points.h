// A Draco mesh as the points that graphics interfaces draw, each with a value of every attribute, as
// KHR_draco_mesh_compression of glTF wants it.
#pragma once

#include "fvv/types.h"

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

} // namespace fvv::scene
