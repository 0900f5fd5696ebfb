// fvvmux/connectivity.h: do two frames have the same faces and differ in nothing but where their vertices
// lie?
#pragma once

#include "capture/capture.h"

#include <optional>

namespace fvv::mux {

// For each vertex of a the vertex of b that it has become, when every face of b is that of a at the same
// place and texture coordinates agree: identical faces, or identical up to the order of vertices. Otherwise
// nothing.
std::optional<std::vector<uint32_t>> same_connectivity(const capture::Mesh &a, const capture::Mesh &b);

// The mesh with its vertices in another order: vertex v is order[v] of mesh. Faces are those of like, which
// has the same connectivity.
capture::Mesh reordered(const capture::Mesh &mesh, const std::vector<uint32_t> &order,
                        const capture::Mesh &like);

// Looks at three pairs of neighbouring frames, first, middle and last: does any share its connectivity?
bool has_runs(const capture::Capture &capture);

} // namespace fvv::mux
