#include "processes/pickles.h"

#include "arrays.h"
#include "source.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <new>
#include <optional>
#include <pybind11/stl.h>

namespace fvv::python {

namespace {

// Arrays in a state are views, so that protocol 5 can pass their memory on without a copy.
template <class T>
py::array array_over(const T *data, const std::vector<py::ssize_t> &shape, const py::handle &owner) {
  return py::array_t<T>(shape, data, owner);
}

template <class T>
py::object array_over_or_none(const T *data, py::ssize_t rows, py::ssize_t columns, const py::handle &owner) {
  if (!data) return py::none();
  return array_over(data, {rows, columns}, owner);
}

void expect_state(bool right, const char *what) {
  if (!right) throw Failure(FVV_ERROR_ARGUMENT, std::string("unpickling: expected ") + what);
}

// ---- meshes --------------------------------------------------------------------------------------------

using LatticeRows = py::array_t<int32_t, py::array::c_style>;
using NumberRows = py::array_t<uint32_t, py::array::c_style>;
using ByteRows = py::array_t<uint8_t, py::array::c_style>;

void *mesh_resize(void *, void *pointer, size_t, size_t size) {
  if (size) return std::realloc(pointer, size);
  std::free(pointer);
  return nullptr;
}

// The rows of an array in memory that the mesh frees; NULL: there are none, or no array.
template <class T, class Array>
T *taken(const std::optional<Array> &values, size_t rows, py::ssize_t columns, const char *what) {
  if (!values) return nullptr;
  expect_state(values->ndim() == 2 && values->shape(1) == columns && size_t(values->shape(0)) == rows, what);
  if (!rows) return nullptr;
  auto *out = static_cast<T *>(std::malloc(rows * size_t(columns) * sizeof(T)));
  if (!out) throw std::bad_alloc();
  std::copy(values->data(), values->data() + values->size(), out);
  return out;
}

py::tuple mesh_state(const py::object &self) {
  const auto &one = self.cast<const Mesh &>();
  const fvv_mesh &mesh = one.mesh;
  const auto vertices = py::ssize_t(mesh.vertex_count), faces = py::ssize_t(mesh.face_count);
  return py::make_tuple(
      one.track, std::array<double, 3>{one.origin[0], one.origin[1], one.origin[2]}, one.step,
      array_over(mesh.lattice, {vertices, 3}, self), array_over(mesh.faces, {faces, 3}, self),
      mesh.texture_bits, array_over_or_none(mesh.texture, vertices, 2, self), mesh.normal_bits,
      array_over_or_none(mesh.normals, vertices, 2, self),
      array_over_or_none(one.colours.empty() ? nullptr : one.colours.data(), vertices, 3, self));
}

std::shared_ptr<Mesh> mesh_of_state(const py::tuple &state) {
  expect_state(state.size() == 10, "the state of a mesh");
  auto out = std::make_shared<Mesh>();
  out->track = state[0].cast<uint16_t>();
  const auto origin = state[1].cast<std::array<double, 3>>();
  std::copy(origin.begin(), origin.end(), out->origin);
  out->step = state[2].cast<double>();
  const auto lattice = state[3].cast<LatticeRows>();
  const auto faces = state[4].cast<NumberRows>();
  expect_state(lattice.ndim() == 2 && lattice.shape(0) <= UINT32_MAX && faces.ndim() == 2 &&
                   faces.shape(0) <= UINT32_MAX,
               "rows of lattice points and faces");
  OwnedMesh &mesh = out->mesh;
  mesh.allocator = {mesh_resize, nullptr};
  mesh.vertex_count = uint32_t(lattice.shape(0));
  mesh.face_count = uint32_t(faces.shape(0));
  const size_t vertices = mesh.vertex_count;
  mesh.lattice = taken<int32_t>(std::optional(lattice), vertices, 3, "lattice points (vertices, 3)");
  mesh.faces = taken<uint32_t>(std::optional(faces), mesh.face_count, 3, "faces (faces, 3)");
  mesh.texture_bits = state[5].cast<uint8_t>();
  mesh.texture =
      taken<uint32_t>(state[6].cast<std::optional<NumberRows>>(), vertices, 2, "texture (vertices, 2)");
  mesh.normal_bits = state[7].cast<uint8_t>();
  mesh.normals =
      taken<uint32_t>(state[8].cast<std::optional<NumberRows>>(), vertices, 2, "normals (vertices, 2)");
  if (const auto colours = state[9].cast<std::optional<ByteRows>>()) {
    expect_state(colours->ndim() == 2 && size_t(colours->shape(0)) == vertices && colours->shape(1) == 3,
                 "colours (vertices, 3)");
    out->colours.assign(colours->data(), colours->data() + colours->size());
  }
  // Checks every rule of a mesh, so that no other use of it has to.
  if (vertices) {
    std::vector<float> normals(3 * vertices);
    fvv_diagnostic diagnostic = {};
    require(fvv_mesh_normals(&mesh, nullptr, normals.data(), &diagnostic), diagnostic, "unpickling");
    out->normals = std::move(normals);
  }
  expect_state(vertices || !mesh.face_count, "no faces without vertices");
  return out;
}

// ---- cameras -------------------------------------------------------------------------------------------

constexpr size_t camera_numbers = 5 + 8 + 1 + 9 + 3;

py::tuple camera_state(const Camera &camera) {
  const fvv_camera &c = camera.calibration;
  std::array<double, camera_numbers> numbers = {c.fx, c.fy, c.cx, c.cy, c.skew};
  auto *out = std::copy(c.distortion, c.distortion + 8, numbers.begin() + 5);
  *out++ = c.r_max;
  out = std::copy(c.rotation, c.rotation + 9, out);
  std::copy(c.translation, c.translation + 3, out);
  return py::make_tuple(c.id, c.lens, c.flags, c.width, c.height, numbers, py::bytes(camera.name));
}

std::shared_ptr<Camera> camera_of_state(const py::tuple &state) {
  expect_state(state.size() == 7, "the state of a camera");
  fvv_camera c = {};
  c.id = state[0].cast<uint16_t>();
  c.lens = state[1].cast<uint8_t>();
  c.flags = state[2].cast<uint8_t>();
  c.width = state[3].cast<uint32_t>();
  c.height = state[4].cast<uint32_t>();
  const auto numbers = state[5].cast<std::array<double, camera_numbers>>();
  const double *from = numbers.data();
  for (double *field : {&c.fx, &c.fy, &c.cx, &c.cy, &c.skew}) *field = *from++;
  for (double &field : c.distortion) field = *from++;
  c.r_max = *from++;
  for (double &field : c.rotation) field = *from++;
  for (double &field : c.translation) field = *from++;
  const auto name = state[6].cast<std::string>();
  c.name = name.data();
  c.name_size = name.size();
  fvv_diagnostic diagnostic = {};
  require(fvv_camera_validate(&c, &diagnostic), diagnostic, "unpickling");
  return std::make_shared<Camera>(c);
}

// ---- pictures ------------------------------------------------------------------------------------------

using TileState = std::array<uint16_t, 9>;

TileState tile_state(const fvv_tile &tile) {
  const fvv_rect &s = tile.source, &d = tile.destination;
  return {tile.camera_id, s.x, s.y, s.width, s.height, d.x, d.y, d.width, d.height};
}

fvv_tile tile_of_state(const TileState &state) {
  return {state[0], {state[1], state[2], state[3], state[4]}, {state[5], state[6], state[7], state[8]}};
}

// Of the video frame the pixels of this picture alone: those of the other cameras are not needed.
py::tuple picture_state(const py::object &self) {
  const auto &picture = self.cast<const Picture &>();
  const fvv_rect &at = picture.tile.destination;
  const py::array pixels = std::visit(
      [&](const auto &frame) -> py::array {
        using Sample = std::decay_t<decltype(frame.pixels[0])>;
        const auto channels = py::ssize_t(frame.channels);
        const py::ssize_t pixel = channels * py::ssize_t(sizeof(Sample)),
                          row = pixel * py::ssize_t(frame.width);
        return py::array_t<Sample>(
            {py::ssize_t(at.height), py::ssize_t(at.width), channels},
            {row, pixel, py::ssize_t(sizeof(Sample))},
            frame.pixels.data() + (size_t(at.y) * frame.width + at.x) * size_t(channels), self);
      },
      *picture.frame);
  fvv_tile tile = picture.tile;
  tile.destination.x = tile.destination.y = 0;
  return py::make_tuple(py::module_::import("numpy").attr("ascontiguousarray")(pixels), tile_state(tile),
                        tile_state(picture.whole), picture.camera);
}

std::shared_ptr<Picture> picture_of_state(const py::tuple &state) {
  expect_state(state.size() == 4, "the state of a picture");
  auto out = std::make_shared<Picture>();
  const auto pixels = state[0].cast<py::array>();
  out->frame = std::make_shared<const demux::VideoFrame>(picture_of(pixels, "unpickling: pixels"));
  out->tile = tile_of_state(state[1].cast<TileState>());
  out->whole = tile_of_state(state[2].cast<TileState>());
  const fvv_rect &at = out->tile.destination;
  expect_state(!at.x && !at.y && py::ssize_t(at.width) == pixels.shape(1) &&
                   py::ssize_t(at.height) == pixels.shape(0),
               "pixels of the tile's size");
  for (const fvv_rect *rect : {&out->tile.source, &out->whole.source, &out->whole.destination})
    expect_state(rect->width && rect->height && rect->width <= media::max_dimension &&
                     rect->height <= media::max_dimension && rect->x <= media::max_dimension &&
                     rect->y <= media::max_dimension,
                 "rectangles within a picture");
  out->camera = state[3].cast<std::shared_ptr<Camera>>();
  return out;
}

} // namespace

void register_pickles(const py::module_ &module) {
  py::class_<Mesh, std::shared_ptr<Mesh>>(module.attr("Mesh")).def(py::pickle(&mesh_state, &mesh_of_state));
  py::class_<Camera, std::shared_ptr<Camera>>(module.attr("Camera"))
      .def(py::pickle(&camera_state, &camera_of_state));
  py::class_<Picture, std::shared_ptr<Picture>>(module.attr("Picture"))
      .def(py::pickle(&picture_state, &picture_of_state));
}

} // namespace fvv::python
