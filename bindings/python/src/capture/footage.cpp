#include "capture/footage.h"

#include "arrays.h"
#include "fvv_media/sound.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/pictures.h"
#include "source.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <pybind11/stl.h>
#include <utility>

namespace fvv::python {

namespace {

template <class Work> auto without_gil(const Work &work) {
  const py::gil_scoped_release release;
  return work();
}

py::array array_of(media::Image &&image) {
  std::vector<py::ssize_t> shape = {py::ssize_t(image.height), py::ssize_t(image.width)};
  if (image.channels != 1) shape.push_back(image.channels);
  return owning(std::move(image.pixels), shape);
}

class Footage {
public:
  Footage(const std::string &text, const std::string &path)
      : capture(scene::parse_capture(text, path)), videos(1) {}

  std::vector<int64_t> frames() const { return capture.frames.numbers(); }

  std::pair<uint32_t, uint32_t> frame_duration() const {
    return {capture.frame_duration.numerator, capture.frame_duration.denominator};
  }

  std::vector<std::shared_ptr<Camera>> cameras() const {
    std::vector<std::shared_ptr<Camera>> out;
    for (const scene::Camera &camera : capture.cameras)
      out.push_back(std::make_shared<Camera>(camera.calibration));
    return out;
  }

  std::shared_ptr<Camera> camera(size_t index, int64_t frame) const {
    const scene::Camera &found = capture.cameras.at(index);
    if (!found.is_calibrated(frame)) return nullptr;
    return std::make_shared<Camera>(found.calibration_at(frame));
  }

  py::array picture(size_t index, int64_t frame) {
    return array_of(without_gil(
        [&] { return videos.read<uint8_t>(capture, *capture.cameras.at(index).pictures, frame, 3); }));
  }

  py::array mask(size_t index, int64_t frame) {
    return array_of(without_gil(
        [&] { return videos.read<uint8_t>(capture, *capture.cameras.at(index).masks, frame, 1); }));
  }

  // Problems and warnings of the files, as fvvmux finds them before it begins.
  std::pair<std::vector<std::string>, std::vector<std::string>> check() {
    const scene::Findings found = without_gil([&] {
      return scene::check_files(
          capture,
          [](const std::string &path) {
            const media::ImageInfo info = media::probe_image(path);
            return scene::PictureSize{info.width, info.height, info.orientation};
          },
          [&](const std::string &path, std::optional<uint32_t> stream) {
            return videos.facts(path, stream);
          });
    });
    const auto spelled = [](std::vector<std::string> sentences) {
      for (std::string &sentence : sentences) sentence = spell(sentence, Spelling::python);
      return sentences;
    };
    return {spelled(found.problems), spelled(found.warnings)};
  }

private:
  scene::Capture capture;
  scene::Videos videos;
};

py::dict video_facts(const std::string &path) {
  const scene::VideoFacts facts = without_gil([&] { return scene::Videos(1).facts(path, {}); });
  const auto count = py::ssize_t(facts.times.times.size());
  const bool turned = facts.rotation.value_or(0) % 180 != 0;
  py::dict out;
  out["width"] = turned ? facts.height : facts.width;
  out["height"] = turned ? facts.width : facts.height;
  out["tick"] = py::make_tuple(facts.times.tick.numerator, facts.times.tick.denominator);
  std::vector<int64_t> ticks = facts.times.times;
  out["ticks"] = owning(std::move(ticks), {count});
  out["warnings"] = facts.warnings;
  out["timecode"] = facts.timecode;
  return out;
}

py::tuple picture_size(const std::string &path) {
  const media::ImageInfo info = without_gil([&] { return media::probe_image(path); });
  return py::make_tuple(info.width, info.height);
}

// Whether a file has sound, and its samples.
bool has_sound(const std::string &path) {
  try {
    without_gil([&] { return media::sound_info(path); });
    return true;
  } catch (const Error &) {
    return false;
  }
}

py::tuple sound(const std::string &path) {
  std::vector<float> samples;
  const media::SoundPackets packets = without_gil([&] {
    media::SoundRequest request;
    request.max_channels = 1;
    media::SoundPackets found = media::load_sound(path, request);
    media::SoundDecoder decoder(found.format);
    for (const auto &packet : found.packets) decoder.decode(packet, samples);
    return found;
  });
  const auto channels = py::ssize_t(packets.format.channels);
  const auto count = py::ssize_t(samples.size()) / channels;
  return py::make_tuple(packets.format.rate, double(packets.start) / packets.format.rate,
                        owning(std::move(samples), {count, channels}));
}

} // namespace

void register_footage(py::module_ &module) {
  py::class_<Footage>(module, "Footage")
      .def(py::init<const std::string &, const std::string &>(), py::arg("text"), py::arg("path"))
      .def_property_readonly("frames", &Footage::frames)
      .def_property_readonly("frame_duration", &Footage::frame_duration)
      .def_property_readonly("cameras", &Footage::cameras)
      .def("camera", &Footage::camera, py::arg("index"), py::arg("frame"))
      .def("picture", &Footage::picture, py::arg("index"), py::arg("frame"))
      .def("mask", &Footage::mask, py::arg("index"), py::arg("frame"))
      .def("check", &Footage::check);
  module.def("video_facts", &video_facts, py::arg("path"));
  module.def("picture_size", &picture_size, py::arg("path"));
  module.def("has_sound", &has_sound, py::arg("path"));
  module.def("sound", &sound, py::arg("path"));
}

} // namespace fvv::python
