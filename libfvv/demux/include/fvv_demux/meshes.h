// Decoded meshes and environments as files have them: metres, texture coordinates as fractions, normals as
// vectors.
#pragma once

#include "fvv/mesh.h"
#include "fvv/stream.h"
#include "fvv_scene/environment.h"
#include "fvv_scene/mesh_file.h"

#include <optional>
#include <string>
#include <vector>

namespace fvv::demux {

geometry::Lattice lattice_of(const double origin[3], double step);

// mesh lies on the lattice. Vertices and faces stay in their order.
geometry::Mesh in_metres(const fvv_mesh &mesh, const geometry::Lattice &lattice);

struct UnpackedBackground {
  scene::Environment environment;
  std::optional<geometry::Lattice> lattice; // the finest of all tracks'; nothing: there was no background
};

// What belongs to a group on all background tracks together (fvv.md clause 18.1). Appends to lost a text for
// each track that is damaged, of which nothing is taken.
UnpackedBackground unpack_background(fvv_stream *stream, size_t group, const fvv_configuration &configuration,
                                     std::vector<std::string> &lost);

} // namespace fvv::demux
