// The extension module fvv._core. What users see is in ../fvv.
#include "capture/cameras.h"
#include "capture/footage.h"
#include "capture/hull.h"
#include "compare.h"
#include "decimate.h"
#include "information.h"
#include "live/reader.h"
#include "options.h"
#include "parts.h"
#include "processes/pickles.h"
#include "render.h"
#include "source.h"
#include "stream.h"
#include "values.h"
#include "write.h"

#include <algorithm>
#include <memory>

namespace fvv::python {

namespace {

struct DestroyChecker {
  void operator()(fvv_checker *checker) const { fvv_checker_destroy(checker); }
};
using Checker = std::unique_ptr<fvv_checker, DestroyChecker>;

// All bytes of a source through the checker, once more where a repetition of a damaged configuration block
// came after groups that need it.
void read_all(const InputFile &file, fvv_checker *checker) {
  const fvv_input input = file.input();
  std::vector<uint8_t> block(size_t(1) << 18);
  for (int pass = 0; pass < 2; pass++) {
    fvv_status status = FVV_OK;
    for (uint64_t at = 0; status >= 0 && at < input.size; at += block.size()) {
      const size_t part = size_t(std::min<uint64_t>(block.size(), input.size - at));
      require(input.read_at(input.user, at, block.data(), part), {}, file.path());
      status = fvv_checker_push(checker, block.data(), part);
      // What follows the footer is counted alone.
      if (status >= 0 && fvv_checker_summary(checker)->has_footer && at + part < input.size) {
        status = fvv_checker_push(checker, nullptr, size_t(input.size - at - part));
        break;
      }
    }
    if (status >= 0) status = fvv_checker_finish(checker);
    if (status < 0 && status > FVV_ERROR_DAMAGED) require(status, {}, file.path());
    if (status < 0) return; // it is one of the problems
    if (status != FVV_NEED_DATA) return;
  }
}

py::dict check(const py::object &object, const std::string &name, bool decode, const py::dict &given) {
  const Limits limits(given);
  Source source(object, name);
  Checker checker;
  try {
    const py::gil_scoped_release release;
    fvv_check_options options;
    fvv_check_options_default(&options);
    options.decode = decode;
    fvv_checker *created = nullptr;
    require(fvv_checker_create(&options, &limits.core, nullptr, &created), {}, name);
    checker.reset(created);
    read_all(source.file(), created);
  } catch (...) {
    source.rethrow();
    throw;
  }
  const fvv_check_summary &summary = *fvv_checker_summary(checker.get());
  py::list problems;
  for (size_t i = 0; i < fvv_checker_problem_count(checker.get()); i++)
    problems.append(describe(*fvv_checker_problem(checker.get(), i), name));
  py::list whole;
  for (size_t i = 0; i < fvv_checker_run_count(checker.get()); i++) {
    const fvv_frame_run &run = *fvv_checker_run(checker.get(), i);
    whole.append(py::make_tuple(run.first_time, run.last_time));
  }
  py::dict out;
  out["problems"] = problems;
  out["whole"] = whole;
  out["problem_count"] = summary.problems;
  out["bytes"] = summary.bytes;
  out["chunks"] = summary.chunks;
  out["groups"] = summary.groups;
  out["frames"] = summary.frames;
  out["whole_frames"] = summary.whole_frames;
  out["complete"] = summary.has_footer && !summary.truncated;
  out["format"] = py::make_tuple(summary.written_major, summary.written_minor);
  return out;
}

} // namespace

} // namespace fvv::python

PYBIND11_MODULE(_core, module) {
  using namespace fvv::python;
  register_failures();
  register_values(module);
  register_pickles(module);
  register_stream(module);
  register_live(module);
  register_render(module);
  register_compare(module);
  register_options(module);
  register_write(module);
  register_parts(module);
  register_decimate(module);
  register_footage(module);
  register_information(module);
  register_hull(module);
  register_cameras(module);
  module.attr("library_version") = fvv_version();
  module.def("check", &check, py::arg("source"), py::arg("name"), py::arg("decode"), py::arg("limits"));
}
