// Frames of a clip drawn from anywhere (fvv_view).
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_render(pybind11::module_ &module);

} // namespace fvv::python
