// Decimation of single meshes.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_decimate(pybind11::module_ &module);

} // namespace fvv::python
