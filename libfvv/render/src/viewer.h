// What a camera sees of a mesh, by rays.
#pragma once

#include "fvv_render/triangle_tree.h"

#include <vector>

namespace fvv::render {

// Of 16 bits.
inline int count_of(unsigned places) {
  // Not std::bitset: without POPCNT its count is a call of a function.
  places -= places >> 1 & 0x5555;
  places = (places & 0x3333) + (places >> 2 & 0x3333);
  places = (places + (places >> 4)) & 0x0F0F;
  return int((places + (places >> 8)) & 0x1F);
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
  bool free(Vec3 place, uint32_t face) const;

private:
  static constexpr uint8_t unknown = 2;
  const fvv_camera &camera;
  const Mesh &mesh;
  Vec3 centre;
  RayFan rays;
  std::vector<uint8_t> shown; // each vertex
};

} // namespace fvv::render
