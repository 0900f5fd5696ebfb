// Faces on which a picture repeats, cut where its tiles meet, so that each piece shows one of them.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <array>
#include <string>
#include <vector>

namespace fvv::scene {

// Where a face is cut along u or v: at all whole numbers, at 0 and 1 alone (a picture that is clamped), or
// nowhere.
enum class TileBorders { all, own, none };

struct TileCut {
  // Follows the vertices of the mesh and the earlier ones of these: a part of the way between two of them.
  struct Vertex {
    uint32_t from, to;
    double part;
  };
  std::vector<Vertex> added;
  std::vector<uint32_t> faces; // 3 vertices each
  std::vector<uint32_t> whole; // the face of the mesh that each is a piece of
  std::vector<double> texture; // u v of each corner, not shifted
};

// texture: u v of each corner of mesh.faces. borders: of each face, along u and v. places: x y z of each
// vertex, by which edges meet; those of the mesh, or where it is animated of its rest, so that all frames are
// cut alike. Coordinates that are less than snap from a whole number count as that. Faces that meet at an
// edge are cut at the same points of it. Throws Error where there would be too many pieces.
TileCut cut_at_tiles(const Mesh &mesh, const std::vector<double> &texture,
                     const std::vector<std::array<TileBorders, 2>> &borders,
                     const std::vector<double> &places, double snap, const fvv_limits &limits,
                     const std::string &name);

// Adds the vertices, with normals where there are some, and replaces the faces.
void apply_cut(const TileCut &cut, Mesh &mesh);

} // namespace fvv::scene
