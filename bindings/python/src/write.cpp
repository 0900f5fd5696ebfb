#include "write.h"

#include "arrays.h"
#include "fvv_media/sound.h"
#include "fvv_media/video.h"
#include "fvv_mux/encoder.h"
#include "fvv_mux/muxer.h"
#include "fvv_mux/realtime.h"
#include "fvv_mux/segments.h"
#include "fvv_scene/inputs.h"
#include "options.h"
#include "processes/process.h"
#include "source.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <pybind11/stl.h>
#include <thread>

namespace fvv::python {

namespace {

// What a run calls in Python, from any thread. An exception in there ends the run, and is raised again.
class Calls {
public:
  // sink(view): takes bytes, which are valid during the call. warn(text), progress(frames): None or a
  // function.
  Calls(py::object the_sink, py::object on_warning, py::object on_progress)
      : sink(std::move(the_sink)), warning(std::move(on_warning)), progress(std::move(on_progress)) {}

  // A run on this thread, without the GIL. Raises what was raised in Python meanwhile, else what broke the
  // run: as an error of usage, or with the status broken.
  template <class Work> void guard(fvv_status broken, const Work &work) {
    owner = std::this_thread::get_id();
    try {
      const py::gil_scoped_release release;
      work();
    } catch (const Error &error) {
      rethrow();
      refuse(error, broken);
    }
    rethrow();
  }

  mux::Sink bytes() {
    return [this](const void *data, size_t size) {
      // The run has no other way out of a sink.
      if (!run([&] { sink(py::memoryview::from_memory(data, py::ssize_t(size))); }))
        throw Error("cancelled", Error::cancelled);
    };
  }

  mux::Observer observer() {
    mux::Observer out;
    out.on_warning = [this](const std::string &text) { run([&] { warning(python_words(text)); }); };
    if (!progress.is_none()) out.on_progress = [this](size_t frames) { run([&] { progress(frames); }); };
    out.is_cancelled = [this] { return is_cancelled(); };
    return out;
  }

  // handler(kind, frame, age, text)
  std::function<void(const mux::RealtimeEvent &)> events(const py::object &handler) {
    return [this, handler = &handler](const mux::RealtimeEvent &event) {
      run([&] { (*handler)(mux::name_of(event.kind), event.frame, event.age, python_words(event.text)); });
    };
  }

private:
  // With the GIL: raises what was raised meanwhile.
  void rethrow() {
    if (!pending) return;
    py::error_already_set error = std::move(*pending);
    pending.reset();
    failed = false;
    throw error;
  }

  template <class Work> bool run(const Work &work) {
    if (failed) return false;
    const py::gil_scoped_acquire acquire;
    try {
      work();
      return true;
    } catch (py::error_already_set &error) {
      if (!pending) pending.emplace(std::move(error));
      failed = true;
      return false;
    }
  }

  // Signals are looked at some times a second, because that needs the GIL, and by the thread that began: in
  // others Python sees none.
  bool is_cancelled() {
    if (failed || std::this_thread::get_id() != owner) return failed;
    constexpr int64_t interval = 50'000'000; // nanoseconds
    const int64_t now = std::chrono::steady_clock::now().time_since_epoch().count();
    if (now - looked <= interval) return false;
    looked = now;
    run([] {
      if (PyErr_CheckSignals()) throw py::error_already_set();
    });
    return failed;
  }

  const py::object sink, warning, progress;
  std::optional<py::error_already_set> pending;
  std::atomic<bool> failed{false};
  std::thread::id owner;
  int64_t looked = 0; // by it
};

py::object parsed(const std::string &json) {
  return py::module_::import("json").attr("loads")(json);
}

// ---- captures ------------------------------------------------------------------------------------------

// The options of a capture on disk, or of what is in place of one.
mux::Options capture_options(const std::string &capture, const py::dict &given) {
  mux::Options options = options_of(given);
  options.capture = capture;
  return options;
}

// All files of a capture, so that none of them is replaced.
std::vector<std::string> files_of(const std::string &capture, const py::dict &given) {
  const mux::Options options = capture_options(capture, given);
  const py::gil_scoped_release release;
  std::vector<std::string> out;
  try {
    scene::visit_files(scene::load_capture(options.capture, options.inputs, mux::memory_limit_of(options)),
                       [&](const std::string &path) { out.push_back(path); });
  } catch (const Error &error) {
    refuse(error, FVV_ERROR_DAMAGED);
  }
  return out;
}

// The text of the capture.json at path that a folder and options stand for.
std::string describe_inputs(const std::string &capture, const py::dict &given, const std::string &path) {
  const mux::Options options = capture_options(capture, given);
  const py::gil_scoped_release release;
  try {
    return scene::describe_inputs(options.capture, options.inputs, path, nullptr,
                                  mux::memory_limit_of(options));
  } catch (const Error &error) {
    refuse(error, FVV_ERROR_DAMAGED);
  }
}

class CaptureMuxer {
public:
  // cameras: identifiers, ranges of them or names; none: all.
  CaptureMuxer(const std::string &capture, const std::vector<std::string> &cameras, const py::dict &options,
               const py::object &sink, const py::object &on_warning, const py::object &on_progress)
      : calls(sink, on_warning, on_progress) {
    mux::Options chosen = capture_options(capture, options);
    chosen.cameras = cameras;
    guarded([&] { muxer.emplace(chosen, calls.observer()); });
  }

  size_t frame_count() const { return muxer->frame_count(); }

  void run() {
    guarded([&] { report.emplace(muxer->run(calls.bytes())); });
  }

  // The stream, which is in a file now, against the capture.
  void verify(const std::string &path) {
    guarded([&] { report->verdict = muxer->verify(path, path); });
  }

  py::object result(const std::string &output) const {
    return parsed(mux::report_json(*report, output, Spelling::python));
  }

private:
  template <class Work> void guarded(const Work &work) { calls.guard(FVV_ERROR_DAMAGED, work); }

  Calls calls;
  std::optional<mux::Muxer> muxer;
  std::optional<mux::Report> report;
};

// Packs the frames that come from a pipe until it ends. Returns the summary.
py::object pack_pipe(int descriptor, const py::dict &options, double most_delay, double idle,
                     const std::string &output, const py::object &sink, const py::object &on_warning,
                     const py::object &on_event) {
  const mux::Options chosen = capture_options("the pipe", options);
  mux::RealtimeOptions realtime;
  realtime.pipe = descriptor;
  realtime.most_delay = most_delay;
  realtime.idle = idle;
  Calls calls(sink, on_warning, py::none());
  std::optional<mux::Report> report;
  calls.guard(FVV_ERROR_DAMAGED, [&] {
    report.emplace(mux::pack_arriving(chosen, realtime, calls.bytes(), calls.observer(),
                                      calls.events(on_event), [] { return false; }));
  });
  py::object out = parsed(mux::report_json(*report, output, Spelling::python));
  out["warned"] = report->warned;
  return out;
}

// Cuts a stream into files; write_file(name, chunks) is called for each of them with its bytes.
py::tuple write_segments(const std::string &stream, const py::object &write_file) {
  const mux::Segments sums = [&] {
    try {
      const py::gil_scoped_release release;
      return mux::write_segments(InputFile(stream), [&](const std::string &name, const auto &fill) {
        std::string content;
        fill([&](const void *bytes, size_t size) { content.append(static_cast<const char *>(bytes), size); });
        const py::gil_scoped_acquire acquire;
        write_file(name, py::bytes(content));
      });
    } catch (const Error &error) {
      refuse(error, FVV_ERROR_DAMAGED);
    }
  }();
  return py::make_tuple(sums.groups, sums.bytes, sums.rungs);
}

// ---- frames from arrays --------------------------------------------------------------------------------

// read: a Sound, whose packets are kept, or None; then samples: float32 (samples, channels) of 48 kHz, start:
// seconds of the first one, bit_rate: 0 for the default. positions: (3,), (frames, 3) or None. title,
// language.
mux::SoundInput sound_of(const py::dict &given, const std::string &where) {
  mux::SoundInput out;
  if (!given["read"].is_none()) {
    out.packets =
        std::make_shared<const media::SoundPackets>(given["read"].cast<const Sound &>().sound.packets);
  } else {
    const auto samples = given["samples"].cast<py::array_t<float, py::array::c_style>>();
    const std::vector<float> content(samples.data(), samples.data() + samples.size());
    const auto start = given["start"].cast<double>();
    const auto channels = uint32_t(samples.shape(1)), bit_rate = given["bit_rate"].cast<uint32_t>();
    try {
      const py::gil_scoped_release release;
      out = mux::sound_of_samples(content, channels, start, bit_rate);
    } catch (const Error &error) {
      throw Failure(FVV_ERROR_ARGUMENT, where + ": " + error.what());
    }
  }
  out.title = given["title"].cast<std::string>();
  out.language = given["language"].cast<std::string>();
  if (!given["positions"].is_none()) {
    const auto positions = given["positions"].cast<py::array_t<double, py::array::c_style>>();
    std::vector<std::array<double, 3>> places(size_t(positions.size()) / 3);
    for (size_t i = 0; i < places.size(); i++) std::copy_n(positions.data() + 3 * i, 3, places[i].begin());
    if (positions.ndim() == 1)
      out.position = places.at(0);
    else
      out.per_frame = std::move(places);
  }
  return out;
}

// For each camera an object, or None for all of them.
using PerCamera = std::optional<std::vector<py::object>>;

// Of one thread at a time: the caller sees to that.
class FrameWriter {
public:
  FrameWriter(const py::dict &options, const py::object &sink, const py::object &on_warning,
              const py::object &on_progress)
      : chosen(options_of(options)), calls(sink, on_warning, on_progress) {}

  // flags: of each camera: pictures, masks, moves, visibility. sounds: as sound_of has them.
  void configure(const std::string &name, int64_t numerator, int64_t denominator,
                 const std::vector<std::shared_ptr<Camera>> &cameras,
                 const std::vector<std::array<bool, 4>> &flags, const std::vector<py::dict> &sounds,
                 const std::string &up, bool scale_unknown) {
    mux::Configuration configuration;
    configuration.name = name;
    configuration.frame_duration = {uint32_t(numerator), uint32_t(denominator)};
    configuration.meshes = chosen.meshes;
    configuration.scale_unknown = scale_unknown;
    const char *axes[] = {"", "+x", "+y", "+z", "-x", "-y", "-z"};
    for (uint8_t i = 0; i < 7; i++)
      if (up == axes[i]) configuration.up = i;
    for (size_t i = 0; i < cameras.size(); i++) {
      mux::CameraInput input;
      input.calibration = plain(*cameras[i]);
      input.name = cameras[i]->name;
      input.pictures = flags[i][0];
      input.masks = flags[i][1];
      input.moves = flags[i][2];
      input.visibility = flags[i][3];
      configuration.cameras.push_back(std::move(input));
    }
    for (size_t i = 0; i < sounds.size(); i++)
      configuration.sounds.push_back(sound_of(sounds[i], "audio " + std::to_string(i)));
    guarded([&] { encoder.emplace(configuration, chosen, calls.bytes(), calls.observer()); });
  }

  // mesh: None, a Mesh, or a tuple of arrays. The others are of each camera, None where it has none.
  void add(const py::object &mesh, const PerCamera &pictures, const PerCamera &masks,
           const PerCamera &calibrations, const PerCamera &visibility) {
    const std::string where = "frame " + std::to_string(added);
    mux::Frame frame;
    if (py::isinstance<Mesh>(mesh))
      frame.mesh = mesh_of(mesh.cast<const Mesh &>());
    else if (!mesh.is_none())
      frame.mesh = mesh_of(mesh.cast<py::tuple>(), where + ": mesh");
    if (pictures) frame.pictures = each<media::AnyImage>(*pictures, where + ": picture", picture);
    if (masks) frame.masks = each<media::Image>(*masks, where + ": mask", mask_of);
    if (visibility)
      frame.visibility = each<std::vector<uint8_t>>(*visibility, where + ": visibility", weights_of);
    if (calibrations)
      for (const py::object &one : *calibrations)
        frame.calibrations.push_back(one.is_none() ? fvv_camera{} : plain(one.cast<const Camera &>()));
    check_samples(frame, where);
    guarded([&] { encoder->check_next(frame); });
    failed = true; // unless it goes well
    guarded([&] { encoder->add(std::move(frame)); });
    failed = false;
    added++;
  }

  py::object finish(const std::string &output) {
    failed = true;
    std::optional<mux::Report> report;
    guarded([&] { report.emplace(encoder->finish()); });
    const py::object out = parsed(mux::report_json(*report, output, Spelling::python));
    close();
    return out;
  }

  // Frees all frames. Nothing is written after it.
  void close() { encoder.reset(); }

  bool is_failed() const { return failed; }
  size_t frames() const { return added; }

private:
  static fvv_camera plain(const Camera &camera) {
    fvv_camera out = camera.calibration;
    out.flags = uint8_t(out.flags & ~FVV_CAMERA_MOVES);
    return out;
  }

  static media::AnyImage picture(const py::array &pixels, const std::string &where) {
    return picture_of(pixels, where);
  }

  template <class Value, class Convert>
  static std::vector<Value> each(const std::vector<py::object> &given, const std::string &where,
                                 const Convert &convert) {
    std::vector<Value> out;
    out.reserve(given.size());
    for (size_t i = 0; i < given.size(); i++)
      out.push_back(given[i].is_none()
                        ? Value()
                        : Value(convert(given[i].cast<py::array>(), where + " " + std::to_string(i))));
    return out;
  }

  void check_samples(const mux::Frame &frame, const std::string &where) const {
    static const char *const names[] = {"uint8", "uint16", "floats"};
    const auto wanted = media::with_sample_type(chosen.codec, chosen.bit_depth, [](auto sample) {
      return media::AnyImage(media::BasicImage<decltype(sample)>()).index();
    });
    for (size_t i = 0; i < frame.pictures.size(); i++) {
      const bool none = std::visit([](const auto &image) { return image.pixels.empty(); }, frame.pictures[i]);
      if (!none && frame.pictures[i].index() != wanted)
        throw Failure(FVV_ERROR_ARGUMENT, where + ": picture " + std::to_string(i) + ": expected " +
                                              names[wanted] + " for this codec and bit_depth, found " +
                                              names[frame.pictures[i].index()]);
    }
  }

  template <class Work> void guarded(const Work &work) { calls.guard(FVV_ERROR_ARGUMENT, work); }

  const mux::Options chosen;
  Calls calls;
  std::optional<mux::Encoder> encoder;
  size_t added = 0;
  bool failed = false;
};

} // namespace

void register_write(py::module_ &module) {
  py::class_<CaptureMuxer>(module, "CaptureMuxer", "A capture on disk that becomes a stream.")
      .def(py::init<const std::string &, const std::vector<std::string> &, const py::dict &,
                    const py::object &, const py::object &, const py::object &>(),
           py::arg("capture"), py::arg("cameras"), py::arg("options"), py::arg("sink"), py::arg("on_warning"),
           py::arg("on_progress"))
      .def_property_readonly("frame_count", &CaptureMuxer::frame_count)
      .def("run", &CaptureMuxer::run)
      .def("verify", &CaptureMuxer::verify, py::arg("path"))
      .def("result", &CaptureMuxer::result, py::arg("output"));
  py::class_<FrameWriter, std::shared_ptr<FrameWriter>>(module, "FrameWriter",
                                                        "Frames from arrays that become a stream.")
      .def(py::init(&make_for_this_process<FrameWriter, const py::dict &, const py::object &,
                                           const py::object &, const py::object &>),
           py::arg("options"), py::arg("sink"), py::arg("on_warning"), py::arg("on_progress"))
      .def_property_readonly("failed", &FrameWriter::is_failed)
      .def_property_readonly("frames", &FrameWriter::frames)
      .def("configure", &FrameWriter::configure, py::arg("name"), py::arg("numerator"),
           py::arg("denominator"), py::arg("cameras"), py::arg("flags"), py::arg("sounds"), py::arg("up"),
           py::arg("scale_unknown"))
      .def("add", &FrameWriter::add, py::arg("mesh"), py::arg("pictures"), py::arg("masks"),
           py::arg("calibrations"), py::arg("visibility"))
      .def("finish", &FrameWriter::finish, py::arg("output"))
      .def("close", &FrameWriter::close);
  module.def("files_of", &files_of, py::arg("capture"), py::arg("options") = py::dict());
  module.def("describe_inputs", &describe_inputs, py::arg("capture"), py::arg("options"), py::arg("path"));
  module.def("pack_pipe", &pack_pipe, py::arg("descriptor"), py::arg("options"), py::arg("most_delay"),
             py::arg("idle"), py::arg("output"), py::arg("sink"), py::arg("on_warning"), py::arg("on_event"));
  module.def("write_segments", &write_segments, py::arg("stream"), py::arg("write_file"));
}

} // namespace fvv::python
