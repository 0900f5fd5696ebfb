#include "compare.h"

#include "arrays.h"
#include "fvv_compare/compare.h"
#include "fvv_cxx/stream_error.h"
#include "stream.h"

#include <algorithm>
#include <pybind11/stl.h>
#include <thread>

namespace fvv::python {

namespace {

// A Mesh, or a tuple of arrays.
geometry::Mesh compared_mesh(const py::handle &given, const std::string &name) {
  if (py::isinstance<Mesh>(given)) return mesh_of(given.cast<const Mesh &>());
  geometry::Mesh out = mesh_of(given.cast<py::tuple>(), name);
  try {
    geometry::check(out, name);
  } catch (const Error &error) {
    throw Failure(FVV_ERROR_ARGUMENT, error.in(Spelling::python));
  }
  return out;
}

// One of the two: a clip, a path, or a list of meshes.
class Side {
public:
  Side(const py::object &given, const std::string &name) {
    if (py::isinstance<Stream>(given)) {
      clip = given.cast<Stream *>();
      source = clip->reading();
    } else if (py::isinstance<py::str>(given)) {
      path = py::reinterpret_steal<py::bytes>(PyUnicode_EncodeFSDefault(given.ptr()));
    } else {
      for (const py::handle &mesh : given) meshes.push_back(compared_mesh(mesh, name));
      path = name;
    }
  }
  // Without the GIL.
  void open() {
    if (clip)
      sequence.emplace(source, clip->name(), clip->chosen_rung(), &clip->core_limits());
    else if (!meshes.empty())
      sequence.emplace(path, std::move(meshes));
    else
      sequence.emplace(path);
  }
  const compare::Sequence &opened() const { return *sequence; }
  // With the GIL.
  void check_reading() const {
    if (clip) clip->check_reading();
  }

private:
  Stream *clip = nullptr;
  fvv_input source = {}; // of clip
  std::string path;
  std::vector<geometry::Mesh> meshes;
  std::optional<compare::Sequence> sequence;
};

py::dict describe(const compare::Figures &f) {
  py::dict out;
  out["rms"] = f.rms;
  out["mean"] = f.mean;
  out["p99"] = f.p99;
  out["max"] = f.max;
  return out;
}

// A dict for each kind, with the names of fvvcompare's JSON; PSNR of equal sets is infinite.
void describe(const compare::Errors &e, double peak, py::dict &out) {
  py::dict distance, d1, d2, normals, turned;
  const char *const names[compare::direction_count] = {"a_to_b", "b_to_a", "symmetric"};
  for (size_t w = 0; w < compare::direction_count; w++) {
    distance[names[w]] = describe(e.distance[w]);
    d1[names[w]] = py::dict(py::arg("mse") = e.d1[w], py::arg("psnr") = compare::psnr(peak, e.d1[w]));
    d2[names[w]] = py::dict(py::arg("mse") = e.d2[w], py::arg("psnr") = compare::psnr(peak, e.d2[w]));
    normals[names[w]] = describe(e.angle[w]);
    turned[names[w]] = e.turned[w];
  }
  out["distance"] = distance;
  out["d1"] = d1;
  out["d2"] = d2;
  out["normals"] = normals;
  out["turned"] = turned;
}

py::dict describe(const compare::FrameResult &frame, double peak) {
  py::dict out;
  out["a"] = py::dict(py::arg("frame") = frame.number_a, py::arg("vertices") = frame.vertices_a,
                      py::arg("faces") = frame.faces_a);
  out["b"] = py::dict(py::arg("frame") = frame.number_b, py::arg("vertices") = frame.vertices_b,
                      py::arg("faces") = frame.faces_b);
  describe(frame.errors, peak, out);
  out["temporal"] = py::none();
  if (frame.motion)
    out["temporal"] = py::dict(py::arg("rms") = frame.motion->rms, py::arg("max") = frame.motion->max,
                               py::arg("motion") = frame.motion->motion);
  return out;
}

py::dict describe(const compare::Result &result) {
  py::dict out;
  out["frames_a"] = result.frames_a;
  out["frames_b"] = result.frames_b;
  out["scale_unknown"] = result.scale_unknown;
  out["peak"] = result.peak;
  describe(result.errors, result.peak, out);
  out["temporal"] = py::none();
  if (const auto &t = result.temporal)
    out["temporal"] = py::dict(py::arg("pairs") = t->pairs, py::arg("by_order") = t->by_order,
                               py::arg("rms") = t->rms, py::arg("max") = t->max,
                               py::arg("motion") = t->motion, py::arg("furthest_match") = t->furthest);
  py::list frames;
  for (const compare::FrameResult &frame : result.frames) frames.append(describe(frame, result.peak));
  out["frames"] = frames;
  out["losses"] = py::tuple(py::cast(result.losses));
  out["warnings"] = py::tuple(py::cast(result.warnings));
  return out;
}

py::dict compare_sequences(const py::object &given_a, const py::object &given_b,
                           const std::optional<std::pair<int64_t, int64_t>> &frames,
                           std::optional<int64_t> start, size_t samples, bool points_of_samples,
                           std::optional<double> peak, uint32_t threads, const py::object &progress) {
  compare::Options options;
  if (frames) options.frames = Range{frames->first, frames->second};
  options.start = start;
  options.samples = samples;
  options.points = points_of_samples ? compare::Points::samples : compare::Points::vertices;
  options.peak = peak;
  options.threads = threads ? threads : std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  options.progress = [&](size_t done, size_t pairs) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals()) throw py::error_already_set();
    if (!progress.is_none()) progress(done, pairs);
  };
  Side a(given_a, "a"), b(given_b, "b");
  compare::Result result;
  try {
    const py::gil_scoped_release release;
    a.open();
    b.open();
    compare::compare(a.opened(), b.opened(), options, result);
  } catch (const Error &error) {
    a.check_reading();
    b.check_reading();
    if (error.kind == Error::usage) throw Failure(FVV_ERROR_ARGUMENT, error.in(Spelling::python));
    throw;
  }
  // A read that failed is a loss of a frame, unless the source is the reason.
  a.check_reading();
  b.check_reading();
  return describe(result);
}

} // namespace

void register_compare(py::module_ &module) {
  module.def("compare", compare_sequences, py::arg("a"), py::arg("b"), py::arg("frames"), py::arg("start"),
             py::arg("samples"), py::arg("points_of_samples"), py::arg("peak"), py::arg("threads"),
             py::arg("progress"));
}

} // namespace fvv::python
