// A mesh prepared for measurements: normals, areas, a tree for nearest points, and sample points.
#pragma once

#include "fvv_geometry/mesh.h"
#include "fvv_render/triangle_tree.h"

#include <vector>

namespace fvv::compare {

using render::Vec3;

// A point on a surface.
struct Sample {
  uint32_t face;
  std::array<double, 3> barycentric;
  Vec3 point;
};

// The faces of a mesh: everything that is needed to know places on them.
class Faces {
public:
  // Indices of the mesh are in range, no position is NaN.
  explicit Faces(const geometry::Mesh &mesh);

  double area() const { return cumulative.empty() ? 0 : cumulative.back(); }
  Vec3 face_normal(uint32_t face) const; // unit length; zero without area

  // count points, one in each of count strips of equal area that the faces are cut into in their order;
  // where, follows a sequence of low discrepancy (Roberts, "The unreasonable effectiveness of quasirandom
  // sequences", 2018, in three dimensions). The same points for the same mesh. There must be an area.
  std::vector<Sample> sample(size_t count) const;

  // guess, enough: as ClosestFinder has them.
  render::ClosestPoint nearest(Vec3 from, uint32_t guess = UINT32_MAX, double enough = -1) const {
    return faces_tree.nearest(from, guess, enough);
  }
  // As ClosestFinder has it.
  const std::vector<uint32_t> &along_surface() const { return faces_tree.along_surface(); }

protected:
  std::vector<render::TriangleTree::Triangle> triangles;

private:
  std::vector<double> cumulative; // area of all faces up to and with each
  render::ClosestFinder faces_tree;
};

// The same with its vertices.
class Surface : public Faces {
public:
  explicit Surface(const geometry::Mesh &mesh);

  // Places of vertices that faces use, each once, in the order of their first vertices; and the normals
  // there: the sum of the normals of all faces around weighted by area, unit length; zero where these cancel.
  const std::vector<Vec3> &points() const { return used; }
  const std::vector<Vec3> &normals() const { return used_normals; }
  // The vertices' normals, interpolated over a face: the mesh's own when it has some, else normals().
  Vec3 smooth_normal(uint32_t face, const std::array<double, 3> &barycentric) const;

  // Of points(), as face.
  render::ClosestPoint nearest_vertex(Vec3 from) const { return points_tree.nearest(from); }

  struct Box {
    Vec3 low, high;
  };
  Box box() const; // of points()

private:
  std::vector<std::array<uint32_t, 3>> corners; // indices in points()
  std::vector<Vec3> used, used_normals;
  std::vector<std::array<Vec3, 3>> own_normals; // of the corners of faces; empty: normals() hold
  render::ClosestFinder points_tree;
};

// Points as triangles without extent, for a ClosestFinder that finds the nearest of them.
std::vector<render::TriangleTree::Triangle> as_triangles(const std::vector<Vec3> &points);
std::vector<Vec3> positions_of(const geometry::Mesh &mesh);

} // namespace fvv::compare
