#include "arrays.h"

#include "source.h"

#include <cstring>
#include <limits>

namespace fvv::python {

namespace {

std::string shape_text(const py::array &array) {
  std::string out = "(";
  for (py::ssize_t i = 0; i < array.ndim(); i++) out += (i ? ", " : "") + std::to_string(array.shape(i));
  return out + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void refuse(const std::string &where, const std::string &expected, const py::array &found) {
  throw Failure(FVV_ERROR_ARGUMENT, where + ": expected " + expected + ", found " +
                                        py::str(found.dtype()).cast<std::string>() + " " + shape_text(found));
}

template <class T> bool has_type(const py::array &array) {
  return py::isinstance<py::array_t<T>>(array);
}

bool has_columns(const py::array &array, py::ssize_t columns) {
  return array.ndim() == 2 && array.shape(1) == columns && (array.flags() & py::array::c_style);
}

std::vector<double> doubles_of(const py::array &array, py::ssize_t columns, const std::string &where) {
  const auto copy = [&](const auto *data) { return std::vector<double>(data, data + array.size()); };
  if (has_columns(array, columns)) {
    if (has_type<float>(array)) return copy(static_cast<const float *>(array.data()));
    if (has_type<double>(array)) return copy(static_cast<const double *>(array.data()));
  }
  refuse(where, "float32 or float64 (vertices, " + std::to_string(columns) + ")", array);
}

template <class T> std::vector<uint32_t> indices_of(const py::array &array, const std::string &where) {
  const auto *data = static_cast<const T *>(array.data());
  std::vector<uint32_t> out;
  out.resize(size_t(array.size()));
  for (size_t i = 0; i < out.size(); i++) {
    if (std::is_signed_v<T> ? data[i] < 0 : false)
      throw Failure(FVV_ERROR_ARGUMENT, where + ": face " + std::to_string(i / 3) +
                                            ": expected vertices from 0 on, found " +
                                            std::to_string(data[i]));
    if (uint64_t(data[i]) > std::numeric_limits<uint32_t>::max())
      throw Failure(FVV_ERROR_ARGUMENT, where + ": face " + std::to_string(i / 3) +
                                            ": expected vertices below 4294967296, found " +
                                            std::to_string(data[i]));
    out[i] = uint32_t(data[i]);
  }
  return out;
}

std::vector<uint32_t> faces_of(const py::array &array, const std::string &where) {
  if (has_columns(array, 3)) {
    if (has_type<uint32_t>(array)) return indices_of<uint32_t>(array, where);
    if (has_type<int32_t>(array)) return indices_of<int32_t>(array, where);
    if (has_type<int64_t>(array)) return indices_of<int64_t>(array, where);
    if (has_type<uint64_t>(array)) return indices_of<uint64_t>(array, where);
  }
  refuse(where, "integers of 32 or 64 bits (faces, 3)", array);
}

// Rows of pixels that follow each other without a gap, at any distance from row to row.
template <class Sample>
media::BasicImage<Sample> image_of(const py::array &array, int channels, const std::string &where) {
  media::BasicImage<Sample> image;
  if (array.shape(0) < 1 || array.shape(1) < 1 || array.shape(0) > media::max_dimension ||
      array.shape(1) > media::max_dimension)
    refuse(where, "sides from 1 to " + std::to_string(media::max_dimension), array);
  image.height = uint32_t(array.shape(0));
  image.width = uint32_t(array.shape(1));
  image.channels = channels;
  const size_t row = size_t(image.width) * size_t(channels);
  const auto *data = static_cast<const uint8_t *>(array.data());
  image.pixels.reserve(row * image.height);
  for (uint32_t y = 0; y < image.height; y++) {
    const auto *from = reinterpret_cast<const Sample *>(data + py::ssize_t(y) * array.strides(0));
    image.pixels.insert(image.pixels.end(), from, from + row);
  }
  return image;
}

// Whether pixels of a row follow each other.
bool has_dense_rows(const py::array &array, py::ssize_t channels) {
  const py::ssize_t sample = array.itemsize();
  return array.strides(1) == channels * sample && (array.ndim() == 2 || array.strides(2) == sample);
}

} // namespace

geometry::Mesh mesh_of(const py::tuple &arrays, const std::string &where) {
  const py::object positions = arrays[0], faces = arrays[1], normals = arrays[2], uvs = arrays[3];
  geometry::Mesh mesh;
  mesh.positions = doubles_of(positions.cast<py::array>(), 3, where + ": positions");
  mesh.faces = faces_of(faces.cast<py::array>(), where + ": indices");
  const auto check_count = [&](const std::vector<double> &values, size_t columns, const char *name) {
    if (values.size() / columns != mesh.vertex_count())
      throw Failure(FVV_ERROR_ARGUMENT, where + ": " + name + ": expected one for each of " +
                                            std::to_string(mesh.vertex_count()) + " vertices, found " +
                                            std::to_string(values.size() / columns));
  };
  if (!normals.is_none()) {
    mesh.normals = doubles_of(normals.cast<py::array>(), 3, where + ": normals");
    check_count(mesh.normals, 3, "normals");
  }
  if (!uvs.is_none()) {
    mesh.texture = doubles_of(uvs.cast<py::array>(), 2, where + ": uvs");
    check_count(mesh.texture, 2, "uvs");
  }
  return mesh;
}

geometry::Mesh mesh_of(const Mesh &one) {
  const fvv_mesh &mesh = one.mesh;
  geometry::Mesh out;
  out.positions.resize(3 * size_t(mesh.vertex_count));
  for (size_t i = 0; i < out.positions.size(); i++)
    out.positions[i] = one.origin[i % 3] + one.step * mesh.lattice[i];
  out.faces.assign(mesh.faces, mesh.faces + 3 * size_t(mesh.face_count));
  if (mesh.normals) {
    std::vector<float> normals(out.positions.size());
    fvv_diagnostic diagnostic = {};
    require(fvv_mesh_normals(&mesh, nullptr, normals.data(), &diagnostic), diagnostic, "");
    out.normals.assign(normals.begin(), normals.end());
  }
  if (mesh.texture) {
    std::vector<float> uvs(2 * size_t(mesh.vertex_count));
    fvv_texture_to_floats(mesh.texture_bits, mesh.texture, mesh.vertex_count, uvs.data());
    out.texture.assign(uvs.begin(), uvs.end());
  }
  return out;
}

media::AnyImage picture_of(const py::array &pixels, const std::string &where) {
  if (pixels.ndim() == 3 && pixels.shape(2) == 3 && has_dense_rows(pixels, 3)) {
    if (has_type<uint8_t>(pixels)) return image_of<uint8_t>(pixels, 3, where);
    if (has_type<uint16_t>(pixels)) return image_of<uint16_t>(pixels, 3, where);
    if (has_type<float>(pixels)) return image_of<float>(pixels, 3, where);
  }
  refuse(where, "uint8, uint16 or floats (height, width, 3)", pixels);
}

media::Image mask_of(const py::array &pixels, const std::string &where) {
  const bool is_bool = has_type<bool>(pixels);
  if (pixels.ndim() != 2 || !has_dense_rows(pixels, 1) || !(is_bool || has_type<uint8_t>(pixels)))
    refuse(where, "uint8 or bool (height, width)", pixels);
  media::Image mask = image_of<uint8_t>(pixels, 1, where);
  if (is_bool)
    for (uint8_t &value : mask.pixels) value = value ? 255 : 0;
  return mask;
}

std::vector<uint8_t> weights_of(const py::array &weights, const std::string &where) {
  if (weights.ndim() != 1 || !has_type<uint8_t>(weights) || !(weights.flags() & py::array::c_style))
    refuse(where, "uint8 (vertices,)", weights);
  const auto *data = static_cast<const uint8_t *>(weights.data());
  return {data, data + weights.size()};
}

} // namespace fvv::python
