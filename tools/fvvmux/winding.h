// fvvmux/winding.h: which side of a capture's faces is out. Players take colours only for faces that turn to
// a camera (fvv.md clause 17), so a mesh whose faces are wound inside out has none; cameras stand outside of
// what they film, which tells. Knows meshes and cameras; knows no colour.
#pragma once

#include "fvvmux/plan.h"

namespace fvv::mux {

// By the first, the middle and the last frame. capture as in the plan, its faces as in the files.
WindingChoice choose_winding(const Options &options, const capture::Capture &capture);

// How the faces of the stream stand, for people.
std::string winding_text(const WindingChoice &choice);

// Warns when faces are inside out in the stream; true if it did. The plan's winding is chosen.
bool warn_of_winding(const Plan &plan);

} // namespace fvv::mux
