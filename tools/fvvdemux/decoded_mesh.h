// A decoded mesh as files have it: metres, texture coordinates as fractions, normals as vectors. Knows the
// integers of fvv/mesh.h; knows no stream and no file.
#pragma once

#include "capture/mesh_file.h"
#include "fvv/mesh.h"

namespace fvv::demux {

capture::Lattice lattice_of(const double origin[3], double step);

// mesh lies on the lattice. Vertices and faces stay in their order.
capture::Mesh in_metres(const fvv_mesh &mesh, const capture::Lattice &lattice);

} // namespace fvv::demux
