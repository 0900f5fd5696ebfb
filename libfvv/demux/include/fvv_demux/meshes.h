// Decoded meshes and environments in the units of mesh files: metres, texture coordinates as fractions,
// normals as vectors.
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

// mesh lies on the lattice. The order of vertices and faces does not change.
geometry::Mesh in_metres(const fvv_mesh &mesh, const geometry::Lattice &lattice);

// A GLB of a mesh on a lattice, in metres, turned so that +y is up, as glTF has it; up: FVV_UP_...,
// FVV_UP_UNKNOWN turns nothing. texture: a file of PNG or JPEG for a mesh with texture coordinates, shown
// without lighting; empty: none, and the mesh is grey. name: of the file, for messages. Error for a
// coordinate that a float32 would take to another point of the lattice.
std::string format_glb(geometry::Mesh mesh, const geometry::Lattice &lattice, uint8_t up,
                       const std::string &texture, const std::string &name);

struct UnpackedBackground {
  scene::Environment environment;
  std::optional<geometry::Lattice> lattice; // the finest of all tracks; none if there was no background
};

// The environment of a group on all background tracks of the best rung together (fvv.md clause 18.1). A
// damaged track is left out, with a text appended to lost.
UnpackedBackground unpack_background(fvv_stream *stream, size_t group, const fvv_configuration &configuration,
                                     std::vector<std::string> &lost);

} // namespace fvv::demux
