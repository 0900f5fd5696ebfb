// Results as text and JSON.
#include "fvvimport/summary.h"

#include "fvv_cxx/format.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/capture_keywords.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace fvv::fvvimport {

namespace {

using import::Mistake;
using nlohmann::ordered_json;

std::string pixels(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g px", value);
  return text;
}

const char *lens_name(const fvv_camera &camera) {
  for (const scene::NamedLens &lens : scene::named_lenses)
    if (lens.lens == camera.lens) return lens.name;
  return "?";
}

ordered_json number(double value) {
  return std::isnan(value) ? ordered_json(nullptr) : ordered_json(value);
}

ordered_json diagnosis_json(const import::Diagnosis &diagnosis, const scene::Capture &capture) {
  ordered_json undone = ordered_json::object(), cameras = ordered_json::object();
  for (size_t i = 0; i < import::mistake_count; i++)
    undone[import::name_of(static_cast<Mistake>(i))] = number(diagnosis.undone[i]);
  for (size_t i = 0; i < capture.cameras.size(); i++)
    cameras[std::to_string(capture.cameras[i].calibration.id)] = number(diagnosis.rms_of_camera[i]);
  return {{"points", diagnosis.points},
          {"invisible", diagnosis.invisible},
          {"rms_px", diagnosis.rms},
          {"max_px", diagnosis.max},
          {"rms_px_of_camera", cameras},
          {"rms_px_undone", undone},
          {"suspected",
           diagnosis.suspected ? ordered_json(import::name_of(*diagnosis.suspected)) : ordered_json()}};
}

} // namespace

std::string text_summary(const Result &result) {
  std::string out;
  const scene::Capture &capture = *result.capture;
  if (!result.output.empty())
    out += result.output + ": " + std::to_string(capture.cameras.size()) + " cameras from " + result.format +
           (capture.scale_unknown ? ", units unknown\n" : ", metres\n");
  for (const scene::LensGap &gap : scene::lens_gaps(capture))
    out +=
        fvv::format("  lens      camera %u: %.1f %% of the picture lie beyond r_max %.4g and are not used\n",
                    unsigned(gap.camera), 100 * gap.share, gap.r_max);
  if (const auto &diagnosis = result.diagnosis) {
    out += std::to_string(diagnosis->points) + " points: rms " + pixels(diagnosis->rms) + ", max " +
           pixels(diagnosis->max) + ", " + std::to_string(diagnosis->invisible) + " not visible\n";
    for (size_t i = 0; i < capture.cameras.size(); i++)
      if (!std::isnan(diagnosis->rms_of_camera[i]))
        out += "  camera " + std::to_string(capture.cameras[i].calibration.id) + ": rms " +
               pixels(diagnosis->rms_of_camera[i]) + "\n";
    if (diagnosis->suspected)
      out += "suspected: " + std::string(import::description_of(*diagnosis->suspected)) + " (undone: rms " +
             pixels(diagnosis->undone[static_cast<size_t>(*diagnosis->suspected)]) + ")\n";
  }
  return out;
}

std::string json_summary(const Result &result) {
  ordered_json cameras = ordered_json::array();
  const std::vector<scene::LensGap> gaps = scene::lens_gaps(*result.capture);
  for (const scene::Camera &camera : result.capture->cameras) {
    const fvv_camera &c = camera.calibration;
    cameras.push_back({{"id", c.id},
                       {"name", *camera.name},
                       {"width", c.width},
                       {"height", c.height},
                       {"lens", lens_name(c)},
                       {"r_max", std::isfinite(c.r_max) ? ordered_json(c.r_max) : ordered_json()},
                       {"beyond_r_max", 0.0}});
    for (const scene::LensGap &gap : gaps)
      if (gap.camera == c.id) cameras.back()["beyond_r_max"] = gap.share;
  }
  ordered_json document = {{"fvvimport", 1}, {"format", result.format}};
  document["output"] = result.output.empty() ? ordered_json() : ordered_json(result.output);
  document["units"] = result.capture->scale_unknown ? "unknown" : "metres";
  document["cameras"] = cameras;
  document["check"] = result.diagnosis ? diagnosis_json(*result.diagnosis, *result.capture) : ordered_json();
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace);
}

} // namespace fvv::fvvimport
