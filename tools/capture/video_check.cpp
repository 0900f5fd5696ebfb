#include "capture/video_check.h"

#include "capture/video_match.h"

#include <cstdio>
#include <filesystem>
#include <utility>

namespace fvv::capture {

namespace {

std::string milliseconds(double seconds) {
  char text[40];
  std::snprintf(text, sizeof text, "%.2f ms", seconds * 1000);
  return text;
}

std::string fraction(const Seconds &seconds) {
  return std::to_string(seconds.numerator) +
         (seconds.denominator == 1 ? "" : "/" + std::to_string(seconds.denominator));
}

void report_times(const std::string &subject, const VideoReport &report, Findings &findings) {
  const int64_t unmet = report.frames - report.met;
  if (unmet)
    findings.warnings.push_back(
        subject + std::to_string(unmet) + " of " + std::to_string(report.frames) +
        " frames have no picture within half a frame and take the nearest: " + report.unmet_text);
  if (report.better_start)
    findings.warnings.push_back(subject + "the pictures are all about " + milliseconds(report.mean_offset) +
                                " off their frames: \"start\": \"" + fraction(*report.better_start) +
                                "\" would fit");
  if (report.before || report.behind)
    findings.unused.push_back(subject + std::to_string(report.before) +
                              " pictures before the first frame and " + std::to_string(report.behind) +
                              " behind the last one are not used");
}

} // namespace

void check_video(const Capture &capture, const Camera *camera, const std::string &kind,
                 const PictureSource &source, const VideoProbe &probe, Findings &findings) {
  const std::string id =
      camera ? "camera " + std::to_string(camera->calibration.id) + ": " : std::string("atlas: ");
  const std::string subject = id + kind + " " + source.video->file + ": ";
  const std::string path = capture.resolve(source.video->file);
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    findings.problems.push_back(subject + "is missing");
    return;
  }
  if (!probe) return;
  VideoFacts facts;
  try {
    facts = probe(path, source.video->stream);
  } catch (const std::exception &reason) {
    findings.problems.push_back(id + kind + ": " + reason.what());
    return;
  }
  for (const std::string &warning : facts.warnings) findings.warnings.push_back(subject + warning);
  if (!source.rotate && !facts.rotation) {
    findings.problems.push_back(subject + "its display matrix mirrors or turns by something else than "
                                          "quarters: expected \"rotate\" to be stated");
    return;
  }
  const int rotate = source.rotate.value_or(facts.rotation.value_or(0));
  if (rotate % 180) std::swap(facts.width, facts.height);
  if (camera && (facts.width != camera->calibration.width || facts.height != camera->calibration.height))
    findings.problems.push_back(
        subject + "is " + std::to_string(facts.width) + " x " + std::to_string(facts.height) +
        (rotate ? ", turned by " + std::to_string(rotate) + " degrees" : "") + ", the camera is " +
        std::to_string(camera->calibration.width) + " x " + std::to_string(camera->calibration.height));
  VideoReport report = match_video(capture, *source.video, facts.times);
  if (camera) report.camera = camera->calibration.id;
  report.masks = kind == "masks";
  report_times(subject, report, findings);
  findings.videos.push_back(std::move(report));
}

} // namespace fvv::capture
