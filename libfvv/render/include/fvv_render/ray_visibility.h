// Which faces and vertices of a mesh a camera sees, by casting rays: the reference for faster methods, and
// the bits of streams.
#pragma once

#include "fvv_render/triangle_tree.h"

namespace fvv::render {

// How far a vertex is moved off the surface before it is tested, metres: more than float32 rounds positions
// within 800 m, less than any detail that a reconstruction has.
constexpr double vertex_lift = 1e-4;

// For each face 1 when camera sees it, else 0. Seen is a face whose centroid (the mean of its vertices)
// projects into the picture (fvv_camera_project, 0 <= u < width, 0 <= v < height), which turns its front
// (counter-clockwise) to the camera's centre, and whose centroid is not occluded: the segment from the centre
// to the centroid meets no other face of the mesh, either side counting, its ends left out. rays is of the
// same mesh; camera is valid.
std::vector<uint8_t> visible_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays);

// The same for vertices. A vertex's normal is the sum of its faces' normals weighted by area; the tested
// point is vertex_lift away along it, and all faces can hide it. A vertex without a normal is not seen.
std::vector<uint8_t> visible_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays);

// ---- bits for players, fvv.md clause 17 ---------------------------------------------------------------
// One bit for all of an element. selected: an entry for each face or vertex, the result of
// fvv_visibility_facing, so that fronts need no test. Elements whose entry is 0 have bit 0, as have those
// with no part in the picture. The player tests whether a place is in the picture, so that nothing is lost at
// its border.

// A face is seen when nothing is in front of most of it: of its centroid, and where the result differs for a
// face with a common vertex, of most of nine places, the middles of nine equal parts.
std::vector<uint8_t> seen_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays,
                                const std::vector<uint8_t> &selected);

// A vertex is seen when nothing is in front of the point vertex_lift away from it along its normal.
std::vector<uint8_t> seen_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays,
                                   const std::vector<uint8_t> &selected);

} // namespace fvv::render
