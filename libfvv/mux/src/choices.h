// What is chosen once for a stream: lattice, normals, winding, visibility.
#pragma once

#include "fvv_mux/plan.h"

namespace fvv::mux {

// By the option; for automatic, by how many vertices of the first frame's source lie on hard edges: their own
// faces have their normal, but all faces around their point, from which players compute it, do not. Fails if
// normals are requested and that source has none.
NormalChoice choose_normals(const Options &options, const scene::Capture &capture);

// By the first, the middle and the last frame. capture as in the plan, its faces as in the files.
WindingChoice choose_winding(const Options &options, const scene::Capture &capture);

// The winding of the stream's faces, for people.
std::string winding_text(const WindingChoice &choice);

// Warns when faces are inside out in the stream; true if it did. The plan's winding is chosen.
bool warn_of_winding(const Plan &plan);

} // namespace fvv::mux
