// What fvvinfo reports of a stream.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_information(pybind11::module_ &module);

} // namespace fvv::python
