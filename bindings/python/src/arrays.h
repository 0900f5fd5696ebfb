// Arrays of numpy as what the libraries encode: each is checked, and copied once.
#pragma once

#include "fvv_geometry/mesh.h"
#include "fvv_scene/memory_frames.h"
#include "values.h"

#include <string>
#include <vector>

namespace fvv::python {

// Contiguous arrays of any of these types are read as they are, others are converted by the caller. where
// begins messages. All throw Failure that names the array, the shape or type that was expected, and the one
// found.

// positions: float32 or float64 (vertices, 3) metres. faces: int32, int64, uint32 or uint64 (faces, 3).
// normals: None, or like positions; uvs: None, or (vertices, 2). Indices are checked for the type alone.
geometry::Mesh mesh_of(const py::tuple &arrays, const std::string &where);
// The same of a mesh that was read; exact: lattice points in double precision.
geometry::Mesh mesh_of(const Mesh &mesh);

// uint8, uint16 or float32 (height, width, 3), rows at any distance.
media::AnyImage picture_of(const py::array &pixels, const std::string &where);
// uint8 or bool (height, width). True is 255.
media::Image mask_of(const py::array &pixels, const std::string &where);
// uint8 (vertices,).
std::vector<uint8_t> weights_of(const py::array &weights, const std::string &where);

// The array takes the vector's memory.
template <class T> py::array owning(std::vector<T> &&values, const std::vector<py::ssize_t> &shape) {
  auto *kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept, [](void *p) { delete static_cast<std::vector<T> *>(p); });
  return py::array_t<T>(shape, kept->data(), owner);
}

} // namespace fvv::python
