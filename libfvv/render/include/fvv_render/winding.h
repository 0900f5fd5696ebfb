// fvv_render/winding.h: which side of a mesh's faces is out, by its faces alone. Knows triangles; knows no
// cameras.
#pragma once

#include "fvv_render/rasteriser.h"

namespace fvv::render {

// Whether the faces enclose a negative volume: they run anticlockwise seen from within. Of open surfaces,
// which enclose none, the volume towards the middle of their vertices counts, and only if it is no rounding
// error.
bool inside_out(const Mesh &mesh);

} // namespace fvv::render
