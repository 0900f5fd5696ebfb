#include "render.h"

#include "arrays.h"
#include "fvv_cxx/stream_error.h"
#include "fvv_view/draw.h"
#include "stream.h"

#include <algorithm>
#include <pybind11/stl.h>
#include <thread>

namespace fvv::python {

namespace {

using Rgb = std::array<double, 3>;

std::string list_of(const std::vector<uint16_t> &ids) {
  std::string out;
  for (const uint16_t id : ids) out += (out.empty() ? "" : ",") + std::to_string(id);
  return out;
}

// What fvv.render takes, as plain values: its docstring has the units.
view::Options options_of(const py::object &target, const py::dict &given) {
  view::Options out;
  if (py::isinstance<Camera>(target))
    out.target.calibration = target.cast<const Camera &>().calibration;
  else if (py::isinstance<py::int_>(target))
    out.target.camera = target.cast<uint16_t>();
  else
    out.target.pose = target.cast<std::vector<double>>();
  const auto take = [&](const char *name, const auto &use) {
    const py::object value = given[name];
    if (!value.is_none()) use(value);
  };
  const auto colour = [](const py::object &value) {
    const auto [r, g, b] = value.cast<Rgb>();
    return render::Vec3{r, g, b};
  };
  take("size", [&](const py::object &v) {
    const auto [width, height] = v.cast<std::pair<uint32_t, uint32_t>>();
    out.target.size = view::Size{width, height};
  });
  take("focal", [&](const py::object &v) { out.target.focal = v.cast<double>(); });
  take("sources", [&](const py::object &v) {
    out.sources = demux::Selection::parse("sources", list_of(v.cast<std::vector<uint16_t>>()));
  });
  take("exclude", [&](const py::object &v) {
    out.excluded = demux::Selection::parse("exclude", list_of(v.cast<std::vector<uint16_t>>()));
  });
  take("blend", [&](const py::object &v) {
    out.blend = v.cast<std::string>() == "paper" ? render::Blend::paper : render::Blend::viewer;
  });
  take("threshold", [&](const py::object &v) { out.threshold = v.cast<double>(); });
  take("best", [&](const py::object &v) { out.best = v.cast<uint32_t>(); });
  take("inset", [&](const py::object &v) { out.inset = v.cast<double>(); });
  take("unseen", [&](const py::object &v) { out.unseen = colour(v); });
  take("background", [&](const py::object &v) { out.view.background = colour(v); });
  take("samples", [&](const py::object &v) { out.view.samples = v.cast<uint32_t>(); });
  take("pictures", [&](const py::object &v) { out.pictures = v.cast<bool>(); });
  take("environment", [&](const py::object &v) { out.environment = v.cast<bool>(); });
  take("visible_by", [&](const py::object &v) {
    const auto name = v.cast<std::string>();
    out.visible_by_default = false;
    out.view.visibility = name == "rays"    ? render::Visibility::rays
                          : name == "depth" ? render::Visibility::depth_map
                                            : render::Visibility::given;
  });
  out.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  take("threads", [&](const py::object &v) { out.threads = v.cast<uint32_t>(); });
  return out;
}

std::vector<float> weights_of(const render::ViewPicture &picture, size_t sources) {
  std::vector<float> out(size_t(picture.width) * picture.height * sources);
  for (size_t i = 0; i < picture.contributions.size(); i++) {
    const render::Contribution &one = picture.contributions[i];
    if (one.source != render::no_source) out[i / picture.best * sources + one.source] = one.weight;
  }
  return out;
}

// frame: the place in the clip.
py::dict render_frame(Stream &clip, size_t frame, const py::object &target, const py::dict &given) {
  const view::Options options = options_of(target, given);
  const int64_t number = clip.number(frame);
  if (options.pictures) clip.check_pictures(frame);
  view::Result result;
  render::ViewPicture picture;
  std::vector<uint8_t> pixels;
  try {
    const py::gil_scoped_release release;
    picture = view::draw(*clip.loaded(number, options.pictures), options, result);
    pixels = view::eight_bits(picture);
  } catch (const StreamError &error) {
    clip.check_reading();
    throw Failure(error.diagnostic, clip.name(), error.what());
  } catch (const Error &error) {
    clip.check_reading();
    if (error.kind == Error::usage) throw Failure(FVV_ERROR_ARGUMENT, error.in(Spelling::python));
    throw Failure(FVV_ERROR_DAMAGED, error.in(Spelling::python));
  }
  clip.check_reading();
  const py::ssize_t width = picture.width, height = picture.height,
                    sources = py::ssize_t(result.sources.size());
  py::dict out;
  if (given["layers"].cast<bool>()) {
    std::vector<float> weights = weights_of(picture, result.sources.size());
    out["weights"] = owning(std::move(weights), {height, width, sources});
    out["values"] = owning(std::move(picture.rgb), {height, width, 3});
    out["depth"] = owning(std::move(picture.depth), {height, width});
    out["coverage"] = owning(std::move(picture.coverage), {height, width});
    out["sources"] = py::tuple(py::cast(result.sources));
  }
  out["pixels"] = owning(std::move(pixels), {height, width, 3});
  out["losses"] = py::tuple(py::cast(result.losses));
  out["warnings"] = py::tuple(py::cast(result.warnings));
  return out;
}

} // namespace

void register_render(py::module_ &module) {
  module.def("render", render_frame, py::arg("clip"), py::arg("frame"), py::arg("target"),
             py::arg("options"));
}

} // namespace fvv::python
