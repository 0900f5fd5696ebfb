#include "capture/hull.h"

#include "arrays.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/parallel.h"
#include "fvv_geometry/hull.h"
#include "fvv_geometry/outline.h"
#include "source.h"

#include <algorithm>
#include <cmath>
#include <pybind11/stl.h>
#include <thread>

namespace fvv::python {

namespace {

using Cameras = std::vector<std::shared_ptr<Camera>>;
using Corners = std::pair<std::array<double, 3>, std::array<double, 3>>;

unsigned threads() {
  return std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
}

// A mask and the camera that it is of.
struct Masked {
  fvv_camera camera;
  std::vector<uint8_t> mask;
};

// None for a camera without a mask.
std::vector<std::optional<Masked>> masked(const Cameras &cameras, const std::vector<py::object> &masks) {
  if (cameras.size() != masks.size())
    throw Failure(FVV_ERROR_ARGUMENT, "masks: expected one for each of " + std::to_string(cameras.size()) +
                                          " cameras, found " + std::to_string(masks.size()));
  std::vector<std::optional<Masked>> out(cameras.size());
  for (size_t i = 0; i < cameras.size(); i++) {
    if (masks[i].is_none()) continue;
    const fvv_camera &camera = cameras[i]->calibration;
    const std::string where = "masks[" + std::to_string(i) + "]";
    media::Image mask = mask_of(masks[i].cast<py::array>(), where);
    if (mask.width != camera.width || mask.height != camera.height)
      throw Failure(FVV_ERROR_ARGUMENT, where + ": expected " + std::to_string(camera.width) + " x " +
                                            std::to_string(camera.height) + " pixels as camera " +
                                            std::to_string(camera.id) + " has, found " +
                                            std::to_string(mask.width) + " x " + std::to_string(mask.height));
    out[i] = Masked{camera, std::move(mask.pixels)};
  }
  return out;
}

std::vector<hull::Silhouette> silhouettes_of(std::vector<std::optional<Masked>> &views) {
  std::vector<std::optional<hull::Silhouette>> made(views.size());
  fvv::parallel(threads(), views.size(), [&](size_t i) {
    if (!views[i]) return;
    made[i].emplace(views[i]->camera, views[i]->mask);
    views[i].reset();
  });
  std::vector<hull::Silhouette> out;
  for (auto &one : made)
    if (one) out.push_back(std::move(*one));
  return out;
}

hull::Options options_from(const py::dict &given) {
  hull::Options options;
  options.threads = threads();
  options.missed = given["missed"].cast<size_t>();
  options.least_views = given["least_views"].cast<size_t>();
  options.min_share = given["min_share"].cast<double>();
  options.smoothing = given["smoothing"].cast<size_t>();
  options.tolerance = given["tolerance"].cast<double>();
  if (!given["floor"].is_none()) {
    const auto [up, height] = given["floor"].cast<std::pair<std::array<double, 3>, double>>();
    options.floor = hull::Floor{{up[0], up[1], up[2]}, height};
  }
  return options;
}

std::array<double, 3> triple(render::Vec3 v) {
  return {v.x, v.y, v.z};
}

hull::Box found_bounds(const std::vector<hull::Silhouette> &silhouettes, const hull::Options &options) {
  const std::optional<hull::Box> box = hull::bounds(silhouettes, options);
  if (!box)
    throw Error("bounds: expected something in the silhouettes of " + std::to_string(options.least_views) +
                    " cameras or more, found nothing in the masks of " + std::to_string(silhouettes.size()),
                Error::failed);
  return *box;
}

py::tuple bounds(const Cameras &cameras, const std::vector<py::object> &masks, const py::dict &given) {
  std::vector<std::optional<Masked>> views = masked(cameras, masks);
  const hull::Options options = options_from(given);
  const hull::Box box = [&] {
    const py::gil_scoped_release release;
    return found_bounds(silhouettes_of(views), options);
  }();
  return py::make_tuple(triple(box.low), triple(box.high));
}

py::dict carve(const Cameras &cameras, const std::vector<py::object> &masks,
               const std::optional<Corners> &corners, const std::optional<double> &cell,
               const std::optional<double> &max_error, const py::dict &given) {
  std::vector<std::optional<Masked>> views = masked(cameras, masks);
  const hull::Options options = options_from(given);
  hull::Hull made = [&] {
    const py::gil_scoped_release release;
    const std::vector<hull::Silhouette> silhouettes = silhouettes_of(views);
    hull::Box box;
    if (corners)
      box = {{corners->first[0], corners->first[1], corners->first[2]},
             {corners->second[0], corners->second[1], corners->second[2]}};
    else
      box = found_bounds(silhouettes, options);
    const double side = cell ? *cell : hull::cell_for(silhouettes, box, *max_error);
    if (!(side > 0) || !std::isfinite(side))
      throw Error("max_error: expected cameras outside the bounds, found one inside: pass cell",
                  Error::usage);
    // A point of the grid on each side of the bounds, because its border is outside.
    const render::Vec3 margin = render::Vec3{1, 1, 1} * side;
    const render::Vec3 extent = box.high - box.low;
    if (!(extent.x / side < 1e6 && extent.y / side < 1e6 && extent.z / side < 1e6))
      throw Error("cell: expected at most 1000000 cells along each side of the bounds, found more",
                  Error::usage);
    return hull::carve(hull::grid_over(box.low - margin, box.high + margin, side), silhouettes, options);
  }();
  py::dict out;
  const auto vertices = py::ssize_t(made.surface.vertices.size());
  std::vector<double> positions;
  std::vector<uint64_t> edges;
  std::vector<float> offsets;
  positions.reserve(3 * size_t(vertices));
  for (const render::Vec3 p : made.surface.vertices) positions.insert(positions.end(), {p.x, p.y, p.z});
  for (const hull::Crossed &crossed : made.surface.crossings) {
    edges.push_back(crossed.edge);
    offsets.push_back(crossed.offset);
  }
  out["positions"] = owning(std::move(positions), {vertices, 3});
  const auto faces = py::ssize_t(made.surface.faces.size() / 3);
  out["indices"] = owning(std::move(made.surface.faces), {faces, 3});
  out["origin"] = triple(made.grid.origin);
  out["cell"] = made.grid.cell;
  out["counts"] = py::make_tuple(made.grid.count[0], made.grid.count[1], made.grid.count[2]);
  const auto bytes = py::ssize_t(made.occupancy.size());
  out["occupancy"] = owning(std::move(made.occupancy), {bytes});
  out["edges"] = owning(std::move(edges), {vertices});
  out["offsets"] = owning(std::move(offsets), {vertices});
  out["components"] = made.components;
  out["dropped"] = made.dropped;
  return out;
}

geometry::ViewedSurface surface_of(const py::tuple &mesh) {
  geometry::Mesh arrays = mesh_of(mesh, "mesh");
  const py::gil_scoped_release release;
  if (arrays.faces.empty()) return {};
  try {
    geometry::check(arrays, "mesh");
  } catch (const Error &error) {
    throw Error(error.what(), Error::usage);
  }
  return {arrays.positions, std::move(arrays.faces)};
}

std::vector<uint8_t> covered(const geometry::ViewedSurface &surface, const fvv_camera &camera) {
  if (surface.empty()) return std::vector<uint8_t>(size_t(camera.width) * camera.height);
  return surface.cover(camera);
}

py::array coverage(const py::tuple &mesh, const std::shared_ptr<Camera> &camera) {
  const geometry::ViewedSurface surface = surface_of(mesh);
  const fvv_camera &calibration = camera->calibration;
  std::vector<uint8_t> pixels = [&] {
    const py::gil_scoped_release release;
    return covered(surface, calibration);
  }();
  return owning(std::move(pixels), {py::ssize_t(calibration.height), py::ssize_t(calibration.width)});
}

std::vector<std::optional<double>> silhouette_iou(const py::tuple &mesh, const Cameras &cameras,
                                                  const std::vector<py::object> &masks) {
  const std::vector<std::optional<Masked>> views = masked(cameras, masks);
  const geometry::ViewedSurface surface = surface_of(mesh);
  std::vector<std::optional<double>> out(views.size());
  const py::gil_scoped_release release;
  fvv::parallel(threads(), views.size(), [&](size_t i) {
    if (!views[i]) return;
    const fvv_camera &camera = views[i]->camera;
    out[i] = geometry::silhouette_iou(covered(surface, camera), views[i]->mask);
  });
  return out;
}

} // namespace

void register_hull(py::module_ &module) {
  module.def("hull_bounds", &bounds, py::arg("cameras"), py::arg("masks"), py::arg("options"));
  module.def("hull_carve", &carve, py::arg("cameras"), py::arg("masks"), py::arg("bounds"), py::arg("cell"),
             py::arg("max_error"), py::arg("options"));
  module.def("coverage", &coverage, py::arg("mesh"), py::arg("camera"));
  module.def("silhouette_iou", &silhouette_iou, py::arg("mesh"), py::arg("cameras"), py::arg("masks"));
}

} // namespace fvv::python
