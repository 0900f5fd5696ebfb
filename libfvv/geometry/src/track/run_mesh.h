// The mesh of a run: what is known of it before it moves.
#pragma once

#include "fvv_geometry/mesh.h"
#include "fvv_geometry/surface.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace fvv::track {

using render::Vec3;

// Without faces of two equal corners, and with one vertex in a place.
struct RunMesh {
  explicit RunMesh(const geometry::Mesh &mesh);

  std::vector<Vec3> points;
  std::vector<uint32_t> number; // of each vertex of the mesh given that of here; UINT32_MAX: no face uses it
  std::vector<std::array<uint32_t, 3>> faces;
  // Neighbours of each vertex by rising number: those from first[v] to first[v + 1].
  std::vector<uint32_t> neighbours;
  std::vector<size_t> first;
  std::vector<double> areas; // a third of the faces around each vertex
  double area = 0;           // of all faces
  std::vector<uint32_t> piece;
  std::vector<double> piece_areas;

  // The unit in which lengths of the method are given: a millimetre of a scene whose largest piece has the
  // area of a person, 2 square metres. Other scenes are treated as if they were that large.
  double unit() const;

  geometry::Mesh at(const std::vector<Vec3> &places) const;
  // Of the vertices at some places: unit length, zero without area.
  std::vector<Vec3> normals(const std::vector<Vec3> &places) const;
  std::vector<render::TriangleTree::Triangle> triangles(const std::vector<Vec3> &places) const;
};

} // namespace fvv::track
