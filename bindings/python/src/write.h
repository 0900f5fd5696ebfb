// Writing: frames from arrays, and captures on disk, become streams.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_write(pybind11::module_ &module);

} // namespace fvv::python
