// Visual hulls: carved from masks, and what a mesh covers in cameras.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_hull(pybind11::module_ &module);

} // namespace fvv::python
