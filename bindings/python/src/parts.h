// A stream in parts (fvv_mux/parts.h), for fvv/distributed.py.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_parts(pybind11::module_ &module);

} // namespace fvv::python
