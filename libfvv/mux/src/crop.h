// Which part of each camera's picture shows the scene, group by group.
#pragma once

#include "mux/src/plan.h"

namespace fvv::mux {

// The data by which a camera's pictures can be cropped.
enum class CropBy { masks, mesh, nothing };
CropBy crop_by(const scene::Capture &capture, const scene::Camera &camera);

// The pixels of a camera in which vertices of a mesh lie; everything, if one of them is behind the camera.
// Points beyond the lens' radius of validity are not seen (spec/fvv.md, clause 9.3).
Silhouette box_of_mesh(const geometry::Mesh &mesh, const fvv_camera &camera);

// For each group, and in it for each of the cameras (indices in Capture::cameras): the box of the visible
// scene in all of its frames. By masks: of all pixels above 127. By the mesh: of the pixels in which its
// vertices lie; everything, if one of them is behind the camera. By nothing: everything. Reads all masks, and
// all meshes where a camera needs them.
std::vector<std::vector<Silhouette>> silhouettes(const Plan &plan, const std::vector<size_t> &cameras);

// Of one group.
std::vector<Silhouette> silhouettes(const Plan &plan, const std::vector<size_t> &cameras, size_t group);

} // namespace fvv::mux
