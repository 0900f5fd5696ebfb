// What a camera sees of sixteen places of each face near an outline, by rays. Knows cameras, triangles and
// rays.
#pragma once

#include "face_places.h"

namespace fvv::render {

// Barycentric coordinates, in twelfths, of the middles of the sixteen equal parts of a triangle: the corners'
// parts, then the middle of all, then the others.
constexpr int share_place_count = 16;
constexpr int twelfths[share_place_count][3] = {
    {10, 1, 1}, {1, 10, 1}, {1, 1, 10}, {4, 4, 4}, {8, 2, 2}, {2, 8, 2}, {2, 2, 8}, {7, 4, 1},
    {7, 1, 4},  {4, 7, 1},  {1, 7, 4},  {4, 1, 7}, {1, 4, 7}, {5, 5, 2}, {5, 2, 5}, {2, 5, 5}};
constexpr uint16_t all_share_places = 0xFFFF;

// Of the faces that are asked for: bit i of free is set when nothing stands in front of place i. The middle
// answers for all of a face unless one near it has another answer; the corners' parts do, with the middle,
// where they agree.
struct SharePlaces {
  std::vector<uint8_t> judged; // each face: asked for, and in the picture
  std::vector<uint16_t> free;  // each face
  std::vector<uint8_t> mixed;  // each vertex: an outline passes through the faces around it

  // around and first: of each vertex the faces that use it.
  SharePlaces(Viewer &viewer, const Mesh &mesh, const std::vector<uint8_t> &asked,
              const std::vector<uint32_t> &first, const std::vector<uint32_t> &around);
};

} // namespace fvv::render
