// fvvmux/normals.h: whether a stream carries normals, or its players compute them (fvv.md
// clauses 8.12, 8.13).
#pragma once

#include "fvvmux/plan.h"

namespace fvv::mux {

// By the option; for automatic, by how many vertices of the first frame's source lie on hard edges: their own
// faces have their normal, but all around their point, of which players compute it, do not.
// Fails when normals are asked for and that source has none.
NormalChoice choose_normals(const Options &options, const capture::Capture &capture);

} // namespace fvv::mux
