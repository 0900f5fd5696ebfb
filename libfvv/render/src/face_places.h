// Which of nine places of each face a camera sees, by rays.
#pragma once

#include "fvv_render/triangle_tree.h"

#include <array>
#include <bitset>

namespace fvv::render {

// Barycentric coordinates, in ninths, of the middles of the nine equal parts of a triangle.
constexpr int place_count = 9;
constexpr int ninths[place_count][3] = {{7, 1, 1}, {1, 7, 1}, {1, 1, 7}, {4, 4, 1}, {4, 1, 4},
                                        {1, 4, 4}, {5, 2, 2}, {2, 5, 2}, {2, 2, 5}};
constexpr uint16_t all_places = (1 << place_count) - 1;

inline int count_of(unsigned places) {
  return int(std::bitset<16>(places).count());
}

class Viewer {
public:
  // All are borrowed; rays is of mesh.
  Viewer(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays);

  Vec3 position(uint32_t vertex) const;
  Vec3 at(const uint32_t *face, int a, int b, int c) const; // of any sum
  Vec3 way_from(Vec3 place) const { return centre - place; }
  bool in_picture(Vec3 at) const;
  bool in_picture(uint32_t vertex); // projects it once
  // Whether a part of the face may be in the picture: a corner or its middle is.
  bool face_in_picture(const uint32_t *face);
  bool free(Vec3 place) const { return !rays.blocked(centre, place); }
  bool free(Vec3 place, uint32_t face) const;

private:
  static constexpr uint8_t unknown = 2;
  const fvv_camera &camera;
  const Mesh &mesh;
  const RayCaster &rays;
  Vec3 centre;
  std::vector<uint8_t> shown; // each vertex
};

// Of the selected faces: bit i of free is set when nothing is in front of place i. The middle decides for all
// of a face unless the middle of a face with a common vertex differs.
struct FacePlaces {
  std::vector<uint8_t> judged; // each face: selected, and in the picture
  std::vector<uint16_t> free;  // each face
  std::vector<uint8_t> mixed;  // each vertex: the faces around it differ

  FacePlaces(Viewer &viewer, const Mesh &mesh, const std::vector<uint8_t> &selected);
  bool touches_mixed(const uint32_t *face) const {
    return mixed[face[0]] || mixed[face[1]] || mixed[face[2]];
  }
};

} // namespace fvv::render
