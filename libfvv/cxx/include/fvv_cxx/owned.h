// What libfvv allocated, freed at the end of a scope.
#pragma once

#include "fvv/mesh.h"

#include <vector>

namespace fvv {

struct OwnedMesh : fvv_mesh {
  OwnedMesh() : fvv_mesh() {}
  OwnedMesh(const OwnedMesh &) = delete;
  OwnedMesh &operator=(const OwnedMesh &) = delete;
  ~OwnedMesh() { fvv_mesh_free(this); }
};

struct OwnedBytes : fvv_bytes {
  OwnedBytes() : fvv_bytes() {}
  OwnedBytes(const OwnedBytes &) = delete;
  OwnedBytes &operator=(const OwnedBytes &) = delete;
  ~OwnedBytes() { fvv_bytes_free(this); }
  std::vector<uint8_t> copy() const { return {data, data + size}; }
};

} // namespace fvv
