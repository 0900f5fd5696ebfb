// Push reading: bytes in, frames and damage out, as they arrive.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_live(pybind11::module_ &module);

} // namespace fvv::python
