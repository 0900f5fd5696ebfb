// What pickle keeps of meshes, cameras and pictures: for processes that work on frames of one clip.
#pragma once

#include "values.h"

namespace fvv::python {

// After register_values.
void register_pickles(const py::module_ &module);

} // namespace fvv::python
