#include "capture/cameras.h"

#include "fvv_scene/import.h"
#include "source.h"
#include "values.h"

#include <pybind11/stl.h>

namespace fvv::python {

namespace {

// format: a name of fvvimport. paths: the files, or the folder of colmap. size: of the pictures of
// middlebury and krt. Returns cameras in units of the format, and metres per unit, 0 when the format does not
// know.
py::tuple read_calibration(const std::string &format, const std::vector<std::string> &paths,
                           const std::pair<uint32_t, uint32_t> &size) {
  const import::Calibration read = [&] {
    const py::gil_scoped_release release;
    return import::read(*import::find_format(format), paths, size.first, size.second);
  }();
  py::list cameras;
  for (const scene::Camera &camera : read.cameras)
    cameras.append(std::make_shared<Camera>(camera.calibration));
  return py::make_tuple(cameras, read.metres_per_unit);
}

} // namespace

void register_cameras(py::module_ &module) {
  module.def("read_calibration", &read_calibration, py::arg("format"), py::arg("paths"), py::arg("size"));
}

} // namespace fvv::python
