// Which faces and vertices of a mesh a camera sees, by casting rays: the truth
// that faster ways are measured by, and the bits that streams carry.
#pragma once

#include "fvv_render/triangle_tree.h"

namespace fvv::render {

// How far a vertex is moved off the surface before it is asked for, metres: more than float32 rounds
// positions within 800 m, less than any detail that a reconstruction has.
constexpr double vertex_lift = 1e-4;

// For each face 1 when camera sees it, else 0. Seen is a face whose centroid (the mean of its vertices)
// projects into the picture (fvv_camera_project, 0 <= u < width, 0 <= v < height), which turns its front
// (counter-clockwise) to the camera's centre, and whose centroid nothing lies in front of: the segment from
// the centre to the centroid meets no other face of the mesh, either side counting, its ends left out. rays
// is of the same mesh; camera is valid.
std::vector<uint8_t> visible_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays);

// The same for vertices. A vertex's normal is the sum of its faces' normals weighted by area; the point asked
// for is vertex_lift away along it, and all faces can hide it. A vertex without a normal is not seen.
std::vector<uint8_t> visible_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays);

// ---- bits for players, fvv.md clause 17 ---------------------------------------------------------------
// What a player takes for all of an element, asked for those alone whose entry in asked (one for each face or
// vertex) is not 0. Others are 0, as are those of which no part is in the picture. The player finds out
// whether a place of an element is in it, so that nothing is lost at the picture's border. Fronts are not
// asked for either: asked comes from fvv_visibility_facing.

// A face is seen when nothing is in front of most of it: of its centroid, and where the result differs for a
// face with a common vertex, of most of nine places, the middles of nine equal parts.
std::vector<uint8_t> seen_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays,
                                const std::vector<uint8_t> &asked);

// A vertex is seen when nothing is in front of the point vertex_lift away from it along its normal.
std::vector<uint8_t> seen_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays,
                                   const std::vector<uint8_t> &asked);

} // namespace fvv::render
