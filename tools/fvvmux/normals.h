// fvvmux/normals.h: whether a stream carries normals, or its players compute them (fvv.md
// clauses 8.12, 8.13).
#pragma once

#include "fvvmux/plan.h"

namespace fvv::mux {

// By the option; for automatic, by how far the normals of the first frame's source are from computed ones.
// Fails when normals are asked for and that source has none.
NormalChoice choose_normals(const Options &options, const capture::Capture &capture);

} // namespace fvv::mux
