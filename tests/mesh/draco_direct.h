// Bitstreams that our own encoder never makes, by Draco itself.
#ifndef FVV_TESTS_MESH_DRACO_DIRECT_H
#define FVV_TESTS_MESH_DRACO_DIRECT_H

#include <cstdint>
#include <vector>

#include "fvv/mesh.h"

struct DracoOptions {
  bool sequential = false;
  bool compressed_indices = false;  // of sequential; clause 3 of spec/draco.md forbids it
  bool floats = false;              // positions as float32
  bool normals = false;             // a further attribute
  bool single_connectivity = true;  // false: texture coordinates with seams of their own
  bool portable_prediction = false; // texture coordinates predicted from positions, as Draco likes best
  bool metadata = false;
  int speed = 5;
};

// A MESH payload that declares the mesh's counts and attributes around what Draco makes of it.
std::vector<uint8_t> draco_payload(const fvv_mesh &mesh, const DracoOptions &options);

#endif
