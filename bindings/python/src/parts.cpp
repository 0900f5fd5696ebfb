#include "parts.h"

#include "fvv_mux/parts.h"
#include "options.h"
#include "source.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <pybind11/stl.h>
#include <stdexcept>

namespace fvv::python {

namespace {

// A file that is written without the GIL.
class OutputFile {
public:
  explicit OutputFile(const std::string &path) : name(path), file(std::fopen(path.c_str(), "wb")) {
    if (!file) fail();
  }
  ~OutputFile() {
    if (file) std::fclose(file);
  }
  OutputFile(const OutputFile &) = delete;

  mux::Sink sink() {
    return [this](const void *bytes, size_t size) {
      if (std::fwrite(bytes, 1, size, file) != size) fail();
    };
  }
  void close() {
    std::FILE *closing = file;
    file = nullptr;
    if (std::fclose(closing)) fail();
  }

private:
  [[noreturn]] void fail() const {
    throw Failure(FVV_ERROR_IO, name + ": cannot write: " + std::strerror(errno), name);
  }

  const std::string name;
  std::FILE *file;
};

// Errors of the library as those of Python.
template <class Work> auto guarded(const Work &work) {
  try {
    return work();
  } catch (const Error &error) {
    refuse(error, FVV_ERROR_DAMAGED);
  }
}

class PartPlan {
public:
  explicit PartPlan(mux::PartPlan &&planned) : plan(std::move(planned)) {}

  // Without the GIL, as encode() and merge() are.
  static PartPlan make(const std::string &capture, const std::vector<std::string> &cameras,
                       const py::dict &given, const std::string &first) {
    mux::Options options = options_of(given);
    options.capture = capture;
    options.cameras = cameras;
    const py::gil_scoped_release release;
    return guarded([&] {
      OutputFile file(first);
      PartPlan made(mux::PartPlan(options, {}, file.sink()));
      file.close();
      return made;
    });
  }

  static PartPlan load(const py::bytes &bytes, const std::string &name, const std::string &capture) {
    const std::string_view view = bytes;
    const py::gil_scoped_release release;
    return guarded([&] { return PartPlan(mux::PartPlan(view, name, capture)); });
  }

  py::bytes bytes() const { return plan.bytes(); }
  const std::string &first_report() const { return plan.first_report(); }
  size_t group_count() const { return plan.group_count(); }
  size_t frame_count() const { return plan.frame_count(); }
  size_t frames_of(size_t group) const { return plan.frames_of(checked(group)); }
  std::vector<std::string> files_of(size_t group) const {
    return guarded([&] { return plan.files_of(checked(group)); });
  }

  std::string encode(size_t group, uint32_t threads, const std::string &path) const {
    const py::gil_scoped_release release;
    return guarded([&] {
      OutputFile file(path);
      std::string report = plan.encode(group, threads, file.sink(), {});
      file.close();
      return report;
    });
  }

  void check_complete(const std::string &name, const std::vector<bool> &there) const {
    guarded([&] { plan.check_complete(name, there); });
  }

  // open_part: from the number of a group to the path of its part and its report.
  py::tuple merge(const py::object &open_part, const std::string &path) const {
    const mux::Merged merged = guarded([&] {
      const py::gil_scoped_release release;
      OutputFile file(path);
      mux::Merged written = plan.merge(
          [&](size_t group) {
            const py::gil_scoped_acquire acquire;
            const py::tuple part = open_part(group);
            return mux::Part{std::make_unique<InputFile>(part[0].cast<std::string>()),
                             part[1].cast<std::string>()};
          },
          file.sink(), {});
      file.close();
      return written;
    });
    std::vector<std::string> warnings;
    for (const std::string &text : merged.warnings) warnings.push_back(python_words(text));
    return py::make_tuple(merged.bytes, warnings);
  }

private:
  size_t checked(size_t group) const {
    if (group < plan.group_count()) return group;
    throw Failure(FVV_ERROR_ARGUMENT, "group " + std::to_string(group) + ": expected a number below " +
                                          std::to_string(plan.group_count()));
  }

  mux::PartPlan plan;
};

} // namespace

void register_parts(py::module_ &module) {
  py::class_<PartPlan>(module, "PartPlan")
      .def_static("make", &PartPlan::make, py::arg("capture"), py::arg("cameras"), py::arg("options"),
                  py::arg("first"))
      .def_static("load", &PartPlan::load, py::arg("data"), py::arg("name"), py::arg("capture"))
      .def_property_readonly("data", &PartPlan::bytes)
      .def_property_readonly("first_report", &PartPlan::first_report)
      .def_property_readonly("group_count", &PartPlan::group_count)
      .def_property_readonly("frame_count", &PartPlan::frame_count)
      .def("frames_of", &PartPlan::frames_of, py::arg("group"))
      .def("files_of", &PartPlan::files_of, py::arg("group"))
      .def("encode", &PartPlan::encode, py::arg("group"), py::arg("threads"), py::arg("path"))
      .def("check_complete", &PartPlan::check_complete, py::arg("name"), py::arg("there"))
      .def("merge", &PartPlan::merge, py::arg("open_part"), py::arg("path"));
}

} // namespace fvv::python
