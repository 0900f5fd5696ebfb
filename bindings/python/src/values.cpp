#include "values.h"

#include "arrays.h"
#include "fvv_demux/views.h"
#include "fvv_render/local_origin.h"
#include "source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <pybind11/stl.h>

namespace fvv::python {

namespace {

using Shape = std::vector<py::ssize_t>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

void freeze(py::array &array) {
  array.attr("flags").attr("writeable") = false;
}

// A read-only view; owner keeps data alive.
template <class T> py::array view(const T *data, const Shape &shape, const py::handle &owner) {
  py::array_t<T> out(shape, data, owner);
  freeze(out);
  return out;
}

template <class T> py::array copied(const T *data, const Shape &shape) {
  py::array_t<T> out(shape, data);
  freeze(out);
  return out;
}

// ---- meshes --------------------------------------------------------------------------------------------

// fill(values) without the GIL, once; a second thread that comes meanwhile does the same work.
template <class T, class Fill> void fill_once(std::vector<T> &values, size_t count, const Fill &fill) {
  if (!values.empty() || !count) return;
  std::vector<T> filled(count);
  {
    const py::gil_scoped_release release;
    fill(filled.data());
  }
  if (values.empty()) values = std::move(filled);
}

py::array positions_of(const py::object &self) {
  auto &one = self.cast<Mesh &>();
  const size_t count = one.mesh.vertex_count;
  const render::Vec3 local = render::local_origin(one.origin, one.step);
  if (local.x != 0 || local.y != 0 || local.z != 0) {
    fill_once(one.far_positions, 3 * count, [&](double *out) {
      for (size_t i = 0; i < count; i++)
        fvv_lattice_to_metres(one.origin, one.step, one.mesh.lattice + 3 * i, out + 3 * i);
    });
    return view(one.far_positions.data(), {py::ssize_t(count), 3}, self);
  }
  fill_once(one.positions, 3 * count,
            [&](float *out) { fvv_lattice_to_floats(one.origin, one.step, one.mesh.lattice, count, out); });
  return view(one.positions.data(), {py::ssize_t(count), 3}, self);
}

py::array normals_of(const py::object &self) {
  auto &one = self.cast<Mesh &>();
  const size_t count = one.mesh.vertex_count;
  fill_once(one.normals, 3 * count, [&](float *out) {
    fvv_diagnostic diagnostic = {};
    require(fvv_mesh_normals(&one.mesh, nullptr, out, &diagnostic), diagnostic, "");
  });
  return view(one.normals.data(), {py::ssize_t(count), 3}, self);
}

py::object uvs_of(const py::object &self) {
  auto &one = self.cast<Mesh &>();
  if (!one.mesh.texture) return py::none();
  const size_t count = one.mesh.vertex_count;
  fill_once(one.uvs, 2 * count,
            [&](float *out) { fvv_texture_to_floats(one.mesh.texture_bits, one.mesh.texture, count, out); });
  return view(one.uvs.data(), {py::ssize_t(count), 2}, self);
}

void register_mesh(py::module_ &module) {
  py::class_<Mesh, std::shared_ptr<Mesh>>(module, "Mesh",
                                          "A triangle mesh. Arrays are read-only views of its memory and "
                                          "keep it alive: positions, indices, normals, uvs, colours.")
      .def_readonly("track", &Mesh::track)
      .def_property_readonly("vertex_count", [](const Mesh &m) { return m.mesh.vertex_count; })
      .def_property_readonly("face_count", [](const Mesh &m) { return m.mesh.face_count; })
      .def_property_readonly("positions", positions_of)
      .def_property_readonly("lattice",
                             [](const py::object &self) {
                               const auto &m = self.cast<const Mesh &>().mesh;
                               return view(m.lattice, {py::ssize_t(m.vertex_count), 3}, self);
                             })
      .def_property_readonly("origin", [](const Mesh &m) { return copied(m.origin, {3}); })
      .def_readonly("step", &Mesh::step)
      .def_property_readonly("indices",
                             [](const py::object &self) {
                               const auto &m = self.cast<const Mesh &>().mesh;
                               return view(m.faces, {py::ssize_t(m.face_count), 3}, self);
                             })
      .def_property_readonly("normals", normals_of)
      .def_property_readonly("has_normals", [](const Mesh &m) { return m.mesh.normals != nullptr; })
      .def_property_readonly("uvs", uvs_of)
      .def_property_readonly("colours",
                             [](const py::object &self) -> py::object {
                               const auto &one = self.cast<const Mesh &>();
                               if (one.colours.empty()) return py::none();
                               return view(one.colours.data(), {py::ssize_t(one.mesh.vertex_count), 3}, self);
                             })
      .def("__repr__", [](const Mesh &m) {
        return "<fvv.Mesh: " + std::to_string(m.mesh.vertex_count) + " vertices, " +
               std::to_string(m.mesh.face_count) + " faces>";
      });
}

// ---- cameras -------------------------------------------------------------------------------------------

// Points as rows: an array of shape (..., width).
struct Rows {
  Rows(const Doubles &array, py::ssize_t width, const char *name) : data(array.data()), shape() {
    shape.assign(array.shape(), array.shape() + array.ndim());
    if (shape.empty() || shape.back() != width) {
      std::string found;
      for (const py::ssize_t side : shape) found += (found.empty() ? "" : ", ") + std::to_string(side);
      throw Failure(FVV_ERROR_ARGUMENT, std::string(name) + ": expected an array of shape (..., " +
                                            std::to_string(width) + "), found (" + found + ")");
    }
    shape.pop_back();
    count = 1;
    for (const py::ssize_t side : shape) count *= size_t(side);
  }
  Shape with(py::ssize_t last) const {
    Shape out = shape;
    out.push_back(last);
    return out;
  }
  const double *data;
  Shape shape; // without the last axis
  size_t count;
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

py::tuple project(const Camera &camera, const Doubles &points) {
  const Rows rows(points, 3, "points");
  py::array_t<double> pixels(rows.with(2)), depths(rows.shape);
  double *pixel = pixels.mutable_data(), *depth = depths.mutable_data();
  {
    const py::gil_scoped_release release;
    for (size_t i = 0; i < rows.count; i++)
      fvv_camera_project(&camera.calibration, rows.data + 3 * i, pixel + 2 * i, depth + i);
  }
  return py::make_tuple(pixels, depths);
}

// The way of each pixel in the world, with z 1 in the camera's frame; NaN beyond the lens.
void ways(const Camera &camera, const double *pixels, size_t count, double *out) {
  const double *r = camera.calibration.rotation;
  for (size_t i = 0; i < count; i++) {
    double ray[3];
    const bool good = fvv_camera_unproject(&camera.calibration, pixels + 2 * i, ray) != 0;
    for (size_t k = 0; k < 3; k++)
      out[3 * i + k] = good ? r[k] * ray[0] + r[3 + k] * ray[1] + r[6 + k] * ray[2] : nan;
  }
}

py::array unproject(const Camera &camera, const Doubles &pixels, const Doubles &depth) {
  const Rows rows(pixels, 2, "pixels");
  const bool single = depth.ndim() == 0;
  if (!single && (size_t(depth.ndim()) != rows.shape.size() ||
                  !std::equal(rows.shape.begin(), rows.shape.end(), depth.shape())))
    throw Failure(FVV_ERROR_ARGUMENT, "depth: expected a number, or one for each pixel");
  py::array_t<double> points(rows.with(3));
  double *point = points.mutable_data();
  const double *depths = depth.data();
  {
    const py::gil_scoped_release release;
    double centre[3];
    fvv_camera_centre(&camera.calibration, centre);
    ways(camera, rows.data, rows.count, point);
    for (size_t i = 0; i < 3 * rows.count; i++)
      point[i] = centre[i % 3] + depths[single ? 0 : i / 3] * point[i];
  }
  return std::move(points);
}

py::tuple ray(const Camera &camera, const Doubles &pixels) {
  const Rows rows(pixels, 2, "pixels");
  py::array_t<double> directions(rows.with(3)), origin(Shape{3});
  double *out = directions.mutable_data();
  fvv_camera_centre(&camera.calibration, origin.mutable_data());
  {
    const py::gil_scoped_release release;
    ways(camera, rows.data, rows.count, out);
    for (size_t i = 0; i < rows.count; i++, out += 3) {
      const double length = std::sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
      for (size_t k = 0; k < 3; k++) out[k] /= length;
    }
  }
  return py::make_tuple(origin, directions);
}

uint8_t lens_of(const std::string &name) {
  if (name == "none") return FVV_LENS_NONE;
  if (name == "radtan") return FVV_LENS_RADTAN;
  if (name == "fisheye") return FVV_LENS_FISHEYE;
  throw Failure(FVV_ERROR_ARGUMENT, "camera: lens: expected none, radtan or fisheye, found " + name);
}

void take(const Doubles &array, const Shape &shape, const char *name, double *out) {
  if (size_t(array.ndim()) != shape.size() || !std::equal(shape.begin(), shape.end(), array.shape()))
    throw Failure(FVV_ERROR_ARGUMENT, std::string("camera: ") + name + ": expected " +
                                          (shape.size() == 2 ? "a 3 x 3 matrix" : "3 numbers") +
                                          ", found another shape");
  std::copy(array.data(), array.data() + array.size(), out);
}

std::shared_ptr<Camera> make_camera(int64_t id, const Doubles &k, const Doubles &r, const Doubles &t,
                                    const std::array<int64_t, 2> &size, const Doubles &distortion,
                                    const std::string &lens, const std::string &name,
                                    const std::optional<double> &r_max) {
  fvv_camera camera = {};
  if (id < 0 || id >= FVV_NO_CAMERA)
    throw Failure(FVV_ERROR_ARGUMENT, "camera: id: expected 0 to 65534, found " + std::to_string(id));
  camera.id = uint16_t(id);
  for (const int64_t side : size)
    if (side < 1 || side > media::max_dimension)
      throw Failure(FVV_ERROR_ARGUMENT,
                    "camera " + std::to_string(id) + ": size: expected a width and a height from 1 to " +
                        std::to_string(media::max_dimension) + ", found " + std::to_string(side));
  camera.width = uint32_t(size[0]);
  camera.height = uint32_t(size[1]);
  double matrix[9];
  take(k, {3, 3}, "K", matrix);
  take(r, {3, 3}, "R", camera.rotation);
  take(t, {3}, "t", camera.translation);
  if (matrix[3] != 0 || matrix[6] != 0 || matrix[7] != 0 || matrix[8] != 1)
    throw Failure(FVV_ERROR_ARGUMENT, "camera: K: expected fx skew cx, 0 fy cy, 0 0 1");
  camera.fx = matrix[0];
  camera.skew = matrix[1];
  camera.cx = matrix[2];
  camera.fy = matrix[4];
  camera.cy = matrix[5];
  camera.lens = lens_of(lens);
  if (distortion.ndim() != 1 || distortion.size() > 8)
    throw Failure(FVV_ERROR_ARGUMENT, "camera: distortion: expected at most 8 numbers, found " +
                                          std::to_string(distortion.size()));
  std::copy(distortion.data(), distortion.data() + distortion.size(), camera.distortion);
  camera.name = name.data();
  camera.name_size = name.size();
  camera.r_max = r_max ? *r_max : fvv_camera_r_max(&camera);
  fvv_diagnostic diagnostic = {};
  if (fvv_camera_validate(&camera, &diagnostic) < 0)
    throw Failure(FVV_ERROR_ARGUMENT, "camera " + std::to_string(id) + ": " + diagnostic.message);
  return std::make_shared<Camera>(camera);
}

void register_camera(py::module_ &module) {
  const auto lens = [](const Camera &camera) {
    return camera.calibration.lens == FVV_LENS_NONE     ? "none"
           : camera.calibration.lens == FVV_LENS_RADTAN ? "radtan"
                                                        : "fisheye";
  };
  py::class_<Camera, std::shared_ptr<Camera>>(
      module, "Camera",
      "A calibrated camera: x_camera = R x_world + t, x right, y down, z forward, pixel centres at .5.")
      .def(py::init(&make_camera), py::arg("id"), py::arg("K"), py::arg("R"), py::arg("t"), py::arg("size"),
           py::arg("distortion") = py::array_t<double>(0), py::arg("lens") = "none", py::arg("name") = "",
           py::arg("r_max") = py::none())
      .def_property_readonly("id", [](const Camera &c) { return c.calibration.id; })
      .def_property_readonly("name", [](const Camera &c) { return py::str(c.name); })
      .def_property_readonly("width", [](const Camera &c) { return c.calibration.width; })
      .def_property_readonly("height", [](const Camera &c) { return c.calibration.height; })
      .def_property_readonly("K",
                             [](const Camera &c) {
                               const fvv_camera &k = c.calibration;
                               const double values[9] = {k.fx, k.skew, k.cx, 0, k.fy, k.cy, 0, 0, 1};
                               return copied(values, {3, 3});
                             })
      .def_property_readonly("R",
                             [](const Camera &c) {
                               return copied(c.calibration.rotation, {3, 3});
                             })
      .def_property_readonly("t", [](const Camera &c) { return copied(c.calibration.translation, {3}); })
      .def_property_readonly("centre",
                             [](const Camera &c) {
                               double centre[3];
                               fvv_camera_centre(&c.calibration, centre);
                               return copied(centre, {3});
                             })
      .def_property_readonly("lens", lens)
      .def_property_readonly("distortion",
                             [](const Camera &c) { return copied(c.calibration.distortion, {8}); })
      .def_property_readonly("r_max", [](const Camera &c) { return c.calibration.r_max; })
      .def_property_readonly("moves",
                             [](const Camera &c) { return (c.calibration.flags & FVV_CAMERA_MOVES) != 0; })
      .def(
          "project",
          [](const Camera &c, const Doubles &points) -> py::object { return project(c, points)[0]; },
          py::arg("points"))
      .def(
          "depth", [](const Camera &c, const Doubles &points) -> py::object { return project(c, points)[1]; },
          py::arg("points"))
      .def("unproject", unproject, py::arg("pixels"), py::arg("depth"))
      .def("ray", ray, py::arg("pixels"))
      .def("__repr__", [](const Camera &c) {
        return "<fvv.Camera " + std::to_string(c.calibration.id) + ": " +
               std::to_string(c.calibration.width) + " x " + std::to_string(c.calibration.height) + ">";
      });
}

// ---- pictures ------------------------------------------------------------------------------------------

template <class Sample>
py::array tile_view(const media::BasicImage<Sample> &frame, const fvv_rect &at, const py::handle &owner) {
  const auto channels = py::ssize_t(frame.channels);
  const py::ssize_t pixel = channels * py::ssize_t(sizeof(Sample)), row = pixel * py::ssize_t(frame.width);
  py::array_t<Sample> out(Shape{at.height, at.width, channels}, Shape{row, pixel, sizeof(Sample)},
                          frame.pixels.data() + (size_t(at.y) * frame.width + at.x) * size_t(channels),
                          owner);
  freeze(out);
  return out;
}

py::object half_of(const py::object &floats) {
  return floats.attr("astype")(py::dtype("float16"));
}

py::object pixels_of(const py::object &self) {
  auto &picture = self.cast<Picture &>();
  const fvv_rect &at = picture.tile.destination;
  return std::visit(
      [&](const auto &frame) -> py::object {
        py::array out = tile_view(frame, at, self);
        if (sizeof(frame.pixels[0]) != 4) return std::move(out);
        if (!picture.half) {
          py::array half = half_of(out);
          freeze(half);
          picture.half = half;
        }
        return picture.half;
      },
      *picture.frame);
}

py::object whole_of(const Picture &picture) {
  return std::visit(
      [&](const auto &frame) -> py::object {
        auto image = [&] {
          const py::gil_scoped_release release;
          return demux::whole_picture(frame, &picture.tile, picture.whole);
        }();
        const Shape shape = {py::ssize_t(image.height), py::ssize_t(image.width),
                             py::ssize_t(image.channels)};
        py::array out = owning(std::move(image.pixels), shape);
        return sizeof(frame.pixels[0]) == 4 ? half_of(out) : py::object(out);
      },
      *picture.frame);
}

py::tuple rectangle(const fvv_rect &r) {
  return py::make_tuple(r.x, r.y, r.width, r.height);
}

void register_picture(py::module_ &module) {
  py::class_<Picture, std::shared_ptr<Picture>>(
      module, "Picture",
      "What the video shows of a camera's picture: pixels, and the rectangle of the picture that they are.")
      .def_property_readonly("pixels", pixels_of)
      .def_property_readonly("source", [](const Picture &p) { return rectangle(p.tile.source); })
      .def_property_readonly("camera", [](const Picture &p) { return p.camera; })
      .def("whole", whole_of)
      .def(
          "__array__",
          [](const py::object &self, const py::object &dtype, const py::object &copy) {
            const py::object pixels = pixels_of(self);
            if (!dtype.is_none()) return pixels.attr("astype")(dtype);
            return !copy.is_none() && copy.cast<bool>() ? pixels.attr("copy")() : pixels;
          },
          py::arg("dtype") = py::none(), py::arg("copy") = py::none())
      .def("__repr__", [](const Picture &p) {
        return "<fvv.Picture: " + std::to_string(p.tile.destination.width) + " x " +
               std::to_string(p.tile.destination.height) + " pixels>";
      });
}

// ---- sound ---------------------------------------------------------------------------------------------

py::array samples_of(const Sound &one) {
  const media::SoundPackets &packets = one.sound.packets;
  const size_t channels = packets.format.channels;
  std::vector<float> samples;
  {
    const py::gil_scoped_release release;
    media::SoundDecoder decoder(packets.format);
    for (const auto &packet : packets.packets) decoder.decode(packet, samples);
    const size_t dropped = std::min(samples.size(), size_t(one.first - packets.start) * channels);
    samples.erase(samples.begin(), samples.begin() + std::ptrdiff_t(dropped));
  }
  const Shape shape = {py::ssize_t(samples.size() / channels), py::ssize_t(channels)};
  return owning(std::move(samples), shape);
}

void register_sound(py::module_ &module) {
  py::class_<Sound, std::shared_ptr<Sound>>(
      module, "Sound",
      "Packets of an audio track that follow each other without a gap; samples() decodes them.")
      .def_property_readonly("track", [](const Sound &s) { return s.sound.track; })
      .def_property_readonly("title", [](const Sound &s) { return py::str(s.sound.title); })
      .def_property_readonly("language", [](const Sound &s) { return py::str(s.sound.language); })
      .def_property_readonly("codec",
                             [](const Sound &s) {
                               return s.sound.packets.format.codec == media::SoundCodec::opus ? "opus"
                                                                                              : "aac";
                             })
      .def_property_readonly("rate", [](const Sound &s) { return s.sound.packets.format.rate; })
      .def_property_readonly("channels", [](const Sound &s) { return s.sound.packets.format.channels; })
      .def_property_readonly("packet_duration",
                             [](const Sound &s) { return s.sound.packets.format.packet_duration; })
      .def_property_readonly("record",
                             [](const Sound &s) {
                               const auto &record = s.sound.packets.format.record;
                               return py::bytes(reinterpret_cast<const char *>(record.data()), record.size());
                             })
      .def_property_readonly("packets_start", [](const Sound &s) { return s.sound.packets.start; })
      .def_property_readonly("start",
                             [](const Sound &s) { return double(s.first) / s.sound.packets.format.rate; })
      .def_property_readonly("duration",
                             [](const Sound &s) {
                               return double(s.sound.packets.end() - s.first) / s.sound.packets.format.rate;
                             })
      .def_property_readonly("packets",
                             [](const Sound &s) {
                               py::list out;
                               for (const auto &packet : s.sound.packets.packets)
                                 out.append(
                                     py::bytes(reinterpret_cast<const char *>(packet.data()), packet.size()));
                               return py::tuple(out);
                             })
      .def_property_readonly("position",
                             [](const Sound &s) -> py::object {
                               if (!s.sound.position) return py::none();
                               return copied(s.sound.position->data(), {3});
                             })
      .def_property_readonly("moves", [](const Sound &s) { return !s.sound.places.empty(); })
      .def(
          "position_at",
          [](const Sound &s, double seconds) -> py::object {
            if (!std::isfinite(seconds))
              throw Failure(FVV_ERROR_ARGUMENT, "seconds: expected a finite number");
            if (!s.sound.position && s.sound.places.empty()) return py::none();
            // Between ticks as between places: in a straight line.
            const double ticks =
                std::clamp(seconds * s.time_base.denominator / s.time_base.numerator, -9e15, 9e15);
            const double tick = std::floor(ticks);
            const scene::Place before = s.sound.position_at(int64_t(tick)),
                               after = s.sound.position_at(int64_t(tick) + 1);
            double place[3];
            for (size_t k = 0; k < 3; k++) place[k] = before[k] + (ticks - tick) * (after[k] - before[k]);
            return copied(place, {3});
          },
          py::arg("seconds"))
      .def("samples", samples_of)
      .def("__repr__", [](const Sound &s) {
        const auto &format = s.sound.packets.format;
        return "<fvv.Sound: " + std::to_string(format.channels) + " channels at " +
               std::to_string(format.rate) + " Hz>";
      });
}

} // namespace

Camera::Camera(const fvv_camera &source)
    : calibration(source), name(source.name ? std::string(source.name, source.name_size) : "") {
  calibration.name = nullptr;
  calibration.name_size = 0;
}

void register_values(py::module_ &module) {
  register_mesh(module);
  register_camera(module);
  register_picture(module);
  register_sound(module);
}

} // namespace fvv::python
