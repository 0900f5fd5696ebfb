// capture/mesh_check.h: what the mesh readers and writers share: growing a mesh within limits, and
// refusing one that no file should hold.
#pragma once

#include "capture/mesh_file.h"

namespace fvv::capture {

// Appends the fan of a polygon around its first corner. corners: at least 3 indices.
void append_fan(Mesh &mesh, const std::vector<uint32_t> &corners, MeshReport &report);

// FileError "name: what" when the mesh has no face, an index out of range or a coordinate that is not finite.
void check_writable(const Mesh &mesh, const std::string &name);

} // namespace fvv::capture
