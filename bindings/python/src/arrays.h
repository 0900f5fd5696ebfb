// Arrays of numpy that own what C++ made.
#pragma once

#include "values.h"

#include <vector>

namespace fvv::python {

// The array takes the vector's memory.
template <class T> py::array owning(std::vector<T> &&values, const std::vector<py::ssize_t> &shape) {
  auto *kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept, [](void *p) { delete static_cast<std::vector<T> *>(p); });
  return py::array_t<T>(shape, kept->data(), owner);
}

} // namespace fvv::python
