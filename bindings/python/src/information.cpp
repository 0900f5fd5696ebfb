#include "information.h"

#include "source.h"

#include "fvv_info/report.h"

#include <algorithm>

namespace fvv::python {

namespace {

// The document of fvvinfo --json. Names are UTF-8 there, or replaced.
py::str inspect(const py::object &object, const std::string &name, bool decode, bool chunks) {
  Source source(object, name);
  const fvv_input bytes = source.file().input();
  uint64_t at = 0;
  info::Input input;
  input.name = source.name();
  input.seekable = true;
  input.size = bytes.size;
  input.read = [&](uint8_t *out, size_t most) {
    const size_t n = size_t(std::min<uint64_t>(most, bytes.size - at));
    if (n) require(bytes.read_at(bytes.user, at, out, n), {}, source.name());
    at += n;
    return n;
  };
  input.rewind = [&] {
    at = 0;
    return true;
  };
  info::Options options;
  options.check = decode;
  options.chunks = chunks;
  try {
    std::string json;
    {
      const py::gil_scoped_release release;
      json = info::document({info::json(info::inspect(input, options))});
    }
    return py::str(json);
  } catch (...) {
    source.rethrow();
    throw;
  }
}

} // namespace

void register_information(py::module_ &module) {
  module.def("inspect", &inspect, py::arg("source"), py::arg("name"), py::arg("decode"), py::arg("chunks"));
}

} // namespace fvv::python
