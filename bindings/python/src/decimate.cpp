#include "decimate.h"

#include "arrays.h"
#include "fvv_geometry/decimate.h"
#include "fvv_mux/option_table.h"
#include "options.h"
#include "source.h"

#include <pybind11/stl.h>

namespace fvv::python {

namespace {

// What a pixel is, and how many of them the surface may be off.
struct Wanted {
  decimate::Footprint footprint;
  decimate::Budget budget;
};

Wanted wanted_of(const std::optional<std::string> &max_error, const std::optional<int64_t> &triangles,
                 const std::vector<std::shared_ptr<Camera>> &cameras, double scale) {
  Wanted out;
  for (const auto &camera : cameras) out.footprint.add(camera->calibration, scale, scale);
  if (triangles) {
    if (*triangles < 1)
      throw Failure(FVV_ERROR_ARGUMENT, "triangles: expected 1 or more, found " + std::to_string(*triangles));
    out.budget.triangles = size_t(*triangles);
    if (cameras.empty()) out.footprint = decimate::Footprint::uniform(1);
    return out;
  }
  const mux::MaxError error = [&] {
    try {
      mux::Options options;
      mux::set_option(options, "max-error", *max_error);
      return *options.max_error;
    } catch (const Error &refused) {
      refuse(refused, FVV_ERROR_ARGUMENT);
    }
  }();
  out.budget.pixels = error.value;
  if (error.unit == mux::MaxError::metres)
    out.footprint = decimate::Footprint::uniform(1);
  else if (cameras.empty())
    throw Failure(FVV_ERROR_ARGUMENT,
                  "max_error: expected a length such as 1mm, because there are no cameras, found " +
                      *max_error);
  return out;
}

template <class T> py::object rows(const std::vector<T> &values, py::ssize_t columns) {
  if (values.empty() && columns != 3) return py::none();
  std::vector<T> copy = values;
  return owning(std::move(copy), {py::ssize_t(values.size()) / columns, columns});
}

py::dict decimated(const py::object &given, const std::optional<std::string> &max_error,
                   const std::optional<int64_t> &triangles,
                   const std::vector<std::shared_ptr<Camera>> &cameras, double scale,
                   const std::optional<double> &step, uint32_t min_piece) {
  const geometry::Mesh mesh = py::isinstance<Mesh>(given) ? mesh_of(given.cast<const Mesh &>())
                                                          : mesh_of(given.cast<py::tuple>(), "mesh");
  Wanted wanted = wanted_of(max_error, triangles, cameras, scale);
  wanted.budget.min_piece = min_piece;
  const decimate::Decimated made = [&] {
    const py::gil_scoped_release release;
    try {
      geometry::check(mesh, "mesh");
      // Without a lattice one whose rounding does not count.
      const double diagonal = geometry::typical_box(mesh).diagonal();
      wanted.budget.lattice.step = step ? *step : diagonal > 0 ? std::ldexp(diagonal, -24) : 1;
      const double target_error = wanted.budget.triangles
                                      ? INFINITY
                                      : decimate::find_target_error(mesh, wanted.footprint, wanted.budget);
      return decimate::decimate(mesh, wanted.footprint, wanted.budget, target_error);
    } catch (const Error &error) {
      refuse(error, FVV_ERROR_ARGUMENT);
    }
  }();
  const decimate::Report &report = made.report;
  py::dict out;
  out["positions"] = rows(made.mesh.positions, 3);
  out["indices"] = rows(made.mesh.faces, 3);
  out["normals"] = made.mesh.normals.empty() ? py::object(py::none()) : rows(made.mesh.normals, 3);
  out["uvs"] = rows(made.mesh.texture, 2);
  std::vector<uint32_t> vertices = made.vertices;
  const auto count = py::ssize_t(vertices.size());
  out["vertices"] = owning(std::move(vertices), {count});
  out["unchanged"] = report.kept;
  out["rms"] = report.error.rms;
  out["max"] = report.error.max;
  const bool pixels = !cameras.empty();
  out["rms_pixels"] = pixels ? py::object(py::float_(report.error.rms_pixels)) : py::object(py::none());
  out["max_pixels"] = pixels ? py::object(py::float_(report.error.max_pixels)) : py::object(py::none());
  return out;
}

} // namespace

void register_decimate(py::module_ &module) {
  module.def("decimate", &decimated, py::arg("mesh"), py::arg("max_error"), py::arg("triangles"),
             py::arg("cameras"), py::arg("scale"), py::arg("step"), py::arg("min_piece"));
}

} // namespace fvv::python
