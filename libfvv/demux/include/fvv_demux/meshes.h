// Decoded meshes and environments in the units of mesh files: metres, texture coordinates as fractions,
// normals as vectors.
#pragma once

#include "fvv/mesh.h"
#include "fvv/stream.h"
#include "fvv_scene/environment.h"
#include "fvv_scene/mesh_file.h"
#include "fvv_scene/mesh_run.h"

#include <optional>
#include <string>
#include <vector>

namespace fvv::demux {

geometry::Lattice lattice_of(const double origin[3], double step);

// mesh lies on the lattice. The order of vertices and faces does not change.
geometry::Mesh in_metres(const fvv_mesh &mesh, const geometry::Lattice &lattice);

// The colours of the vertices of a mesh track's frame, R G B each, where they are what the surface looks
// like: in streams without video. Else, and where the frame has none, empty.
fvv_status colours_of(fvv_stream *stream, const fvv_configuration &configuration, size_t frame,
                      uint16_t mesh_track, std::vector<uint8_t> &colours, fvv_diagnostic &diagnostic);

// Whether a mesh has the faces, texture coordinates and colours of a run, and normals if that has some.
bool is_of_run(const fvv_mesh &mesh, const std::vector<uint8_t> &colours, const scene::MeshRun &run);
// Appends a frame to a run; the first one determines its faces, texture coordinates and colours. time, name:
// as in MeshRun.
void append_frame(const fvv_mesh &mesh, const std::vector<uint8_t> &colours, double time,
                  const std::string &name, scene::MeshRun &run);

// format_run() of frames on a lattice, turned so that +y is up, as glTF has it; up: FVV_UP_...,
// FVV_UP_UNKNOWN turns nothing.
std::string format_glb(scene::MeshRun run, const geometry::Lattice &lattice, uint8_t up,
                       const std::string &picture, scene::Compression compression, const std::string &name,
                       bool *is_local = nullptr);

struct UnpackedEnvironment {
  scene::Environment environment;
  std::optional<geometry::Lattice> lattice; // the finest of all tracks; none if there was no environment
};

// The environment of a group on all environment tracks of the best rung together (fvv.md clause 18.1). A
// damaged track is left out, with a text appended to lost.
UnpackedEnvironment unpack_environment(fvv_stream *stream, size_t group,
                                       const fvv_configuration &configuration,
                                       std::vector<std::string> &lost);

} // namespace fvv::demux
