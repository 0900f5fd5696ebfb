// Lengths that are not measured but chosen. They follow the scene, because the unit of a capture is
// arbitrary: a scene has the same picture at every scale.
#pragma once

#include "fvv_render/rasteriser.h"

namespace fvv::render {

// Of the box around the vertices; coordinates that are not finite are left out. 0 without any.
double longest_side(const Mesh &mesh);

// Nothing nearer than this to the plane through the camera's centre is drawn, z_c: a centimetre, or a
// hundredth of the mesh's longest side where that is less. Above 0.
double near_plane(const Mesh &mesh);

// How far a vertex is moved off the surface before its visibility is tested: a tenth of a millimetre, or a
// ten-thousandth of the mesh's longest side where that is less: less than any detail that a reconstruction
// has. Where float32 rounds positions by more (of a mesh longer than 400), four times as much as it rounds.
double vertex_lift(const Mesh &mesh);

} // namespace fvv::render
