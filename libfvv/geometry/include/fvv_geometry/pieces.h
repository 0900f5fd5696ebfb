// The parts of a mesh: vertices at one place, connected pieces, and the volume that a surface encloses.
#pragma once

#include "fvv_geometry/mesh.h"

namespace fvv::decimate {

// For each vertex the first one in the same place, bit for bit. with_attributes: and with the same texture
// coordinates and normal, if the mesh has some.
std::vector<uint32_t> first_alike(const geometry::Mesh &mesh, bool with_attributes);

// For each vertex the number of its piece, and the number of pieces; UINT32_MAX for one that no face uses.
// Faces are connected where they share a vertex of alike, the result of first_alike.
struct Pieces {
  std::vector<uint32_t> of_vertex;
  std::vector<uint32_t> faces; // of each piece
  std::vector<double> area;    // of each piece, square metres
};
Pieces find_pieces(const geometry::Mesh &mesh, const std::vector<uint32_t> &alike);

// Signed: positive for closed surfaces whose faces wind anticlockwise seen from outside. For an open surface
// it depends on the origin.
double enclosed_volume(const geometry::Mesh &mesh);

// Square metres.
double face_area(const geometry::Mesh &mesh, size_t face);

// The mesh of faces over the vertices of mesh, without unused vertices, in the same order. used: the vertex
// of mesh for each of its vertices.
geometry::Mesh compact(const geometry::Mesh &mesh, const std::vector<uint32_t> &faces,
                       std::vector<uint32_t> &used);

} // namespace fvv::decimate
