// Which faces and vertices of a mesh a camera sees, by casting rays: the reference for faster methods.
#pragma once

#include "fvv_render/triangle_tree.h"

namespace fvv::render {

// For each face 1 when camera sees it, else 0. Seen is a face whose centroid (the mean of its vertices)
// projects into the picture (fvv_camera_project, 0 <= u < width, 0 <= v < height), which turns its front
// (counter-clockwise) to the camera's centre, and whose centroid is not occluded: the segment from the centre
// to the centroid meets no other face of the mesh, either side counting, its ends left out. rays is of the
// same mesh; camera is valid.
std::vector<uint8_t> visible_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays);

// The same for vertices. A vertex's normal is the sum of its faces' normals weighted by area; the tested
// point is vertex_lift() away along it, and all faces can hide it. A vertex without a normal is not seen.
std::vector<uint8_t> visible_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays);

} // namespace fvv::render
