// What a mesh consists of: which vertices are one place, which faces hang together, how much room a surface
// encloses.
#pragma once

#include "fvv_geometry/mesh.h"

namespace fvv::decimate {

// For each vertex the first one in the same place, bit for bit. with_attributes: and with the same texture
// coordinates and normal, if the mesh has some.
std::vector<uint32_t> first_alike(const geometry::Mesh &mesh, bool with_attributes);

// For each vertex the number of its piece, and the number of pieces; UINT32_MAX for one that no face uses.
// Faces hang together where they share a vertex of alike, which is as first_alike answers.
struct Pieces {
  std::vector<uint32_t> of_vertex;
  std::vector<uint32_t> faces; // of each piece
  std::vector<double> area;    // of each piece, square metres
};
Pieces find_pieces(const geometry::Mesh &mesh, const std::vector<uint32_t> &alike);

// Signed: positive for closed surfaces whose faces wind anticlockwise seen from outside. Of an open one a
// number that moves with the origin.
double enclosed_volume(const geometry::Mesh &mesh);

// Square metres.
double face_area(const geometry::Mesh &mesh, size_t face);

// The mesh of other faces over the vertices of mesh: without those that no face uses, the order kept. used:
// for each of its vertices the one of mesh.
geometry::Mesh compact(const geometry::Mesh &mesh, const std::vector<uint32_t> &faces,
                       std::vector<uint32_t> &used);

} // namespace fvv::decimate
