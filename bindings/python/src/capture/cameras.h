// Cameras out of the calibration files of other programs, and out of capture.json.
#pragma once

#include <pybind11/pybind11.h>

namespace fvv::python {

void register_cameras(pybind11::module_ &module);

} // namespace fvv::python
