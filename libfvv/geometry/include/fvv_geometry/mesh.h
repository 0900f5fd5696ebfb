// Checks and changes of triangle meshes (Mesh of fvv_cxx/values.h), and the lattice that the meshes of a
// stream lie on.
#pragma once

#include "fvv_cxx/values.h"

#include <string>

namespace fvv::geometry {

// Points origin + step * index (fvv/mesh.h), in metres.
struct Lattice {
  double origin[3];
  double step;
};

// Throws Error "name: what is wrong" for a mesh without faces, with arrays that do not fit each other, an
// index out of range, or a number that is not finite. What readers of mesh files guarantee.
void check(const Mesh &mesh, const std::string &name);

// Reverses all faces: their first corner stays, the others change places. Normals are reversed too when most
// of them would point to the wrong side then; in some files the normals are right and only the faces are
// wrong.
void flip_faces(Mesh &mesh);

// Around the vertices that faces use, without the lowest and highest 0.5 % on each axis: a few that are far
// off do not count. Where that box is four times as large as the one without the lowest and highest 5 %, what
// lies between is stray, and the smaller box is returned. Coordinates that are not finite are left out. All 0
// without any.
struct TypicalBox {
  double low[3] = {}, high[3] = {};

  double diagonal() const;
};
TypicalBox typical_box(const Mesh &mesh);

// Largest of ... 0.001, 0.002, 0.005, 0.01 ... that is not above value; 0 < value, finite.
double round_down_125(double value);

} // namespace fvv::geometry
