// Pictures, masks and sound of a recording, read as fvvmux reads them, for fvv_capture.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_footage(pybind11::module_ &module);

} // namespace fvv::python
