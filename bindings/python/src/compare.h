// Sequences of meshes compared (fvv_compare).
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_compare(pybind11::module_ &module);

} // namespace fvv::python
