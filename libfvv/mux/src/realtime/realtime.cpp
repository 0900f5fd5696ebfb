#include "fvv_mux/realtime.h"
#include "fvv_cxx/format.h"
#include "fvv_mux/encoder.h"
#include "fvv_scene/inputs.h"
#include "mux/src/options/effort_steps.h"
#include "mux/src/options/option_values.h"
#include "mux/src/planner.h"
#include "mux/src/realtime/folder_source.h"
#include "mux/src/realtime/intake.h"
#include "mux/src/realtime/pace.h"
#include "mux/src/realtime/pipe_source.h"

#include <algorithm>
#include <atomic>

namespace fvv::mux {

namespace {

[[noreturn]] void refuse(const scene::Capture &capture, const std::string &what) {
  throw Error(capture.path + ": frames that arrive " + what, Error::usage);
}

// What the files of single frames cannot bring.
void check_arriving(const scene::Capture &capture) {
  if (capture.animation) refuse(capture, "need a mesh file each, and one animated file has all meshes");
  if (capture.atlas) refuse(capture, "have no atlas yet");
  if (!capture.sounds.empty())
    refuse(capture, "have no sound yet (" + option_name("no-sound") + " leaves it out)");
  if (capture.environment)
    refuse(capture, "have no environment yet (" + option_name("no-environment") + " leaves it out)");
  for (const scene::Camera &camera : capture.cameras)
    if ((camera.pictures && camera.pictures->video) || (camera.masks && camera.masks->video))
      refuse(capture, "need picture files, and " + scene::describe(camera) + " has a video");
}

Configuration configuration_of(const scene::Capture &capture) {
  Configuration out;
  out.name = capture.name;
  out.frame_duration = capture.frame_duration;
  out.meshes = capture.meshes.has_value();
  out.up = capture.up;
  out.scale_unknown = capture.scale_unknown;
  for (const scene::Camera &camera : capture.cameras) {
    CameraInput input;
    input.calibration = camera.calibration;
    input.name = camera.name ? *camera.name : "";
    input.pictures = camera.pictures.has_value();
    input.masks = camera.masks.has_value();
    input.moves = camera.moves();
    out.cameras.push_back(std::move(input));
  }
  return out;
}

// Of the frames of a stream, as they are written.
class Delays {
public:
  void add(double delay) { all.push_back(std::max(0.0, delay)); }

  void report(RealtimeReport &out) {
    if (all.empty()) return;
    out.start = all[0];
    std::sort(all.begin(), all.end());
    out.median_delay = at(0.5);
    out.p95_delay = at(0.95);
    out.largest_delay = all.back();
  }

private:
  double at(double share) const { return all[size_t(share * double(all.size() - 1) + 0.5)]; }
  std::vector<double> all;
};

} // namespace

const char *name_of(RealtimeEvent::Kind kind) {
  switch (kind) {
  case RealtimeEvent::lost:
    return "lost";
  case RealtimeEvent::dropped:
    return "dropped";
  case RealtimeEvent::lowered:
    return "lowered";
  case RealtimeEvent::raised:
    return "raised";
  case RealtimeEvent::ended:
    return "ended";
  }
  return "";
}

uint32_t realtime_group_size(const fvv_rational &frame_duration) {
  const double rate = double(frame_duration.denominator) / frame_duration.numerator;
  return uint32_t(std::clamp(rate / 2, 1.0, 500.0));
}

Report pack_arriving(const Options &given, const RealtimeOptions &realtime, const Sink &sink,
                     const Observer &observer, const std::function<void(const RealtimeEvent &)> &on_event,
                     const std::function<bool()> &is_stopped) {
  Options options = given;
  std::unique_ptr<OpenPipe> pipe;
  if (realtime.pipe >= 0)
    pipe = std::make_unique<OpenPipe>(options.capture, realtime, is_stopped, memory_limit_of(options));
  scene::Capture capture =
      pipe ? pipe->frames.capture()
           : scene::load_capture(options.capture, options.inputs, memory_limit_of(options));
  bool warned = select(capture, options, observer);
  check_arriving(capture);
  if (!options.group) options.group = realtime_group_size(capture.frame_duration);
  fill_in(options);
  if (pipe && options.codec == FVV_CODEC_OEXR)
    refuse(capture, "from a pipe have 8 bits a sample, and OpenEXR is for light beyond white");
  const double duration = capture.frame_seconds(), group = options.group * duration;
  // A group fills, and is encoded, after its first frame is read. The first group may take longer: that is
  // when the stream is planned.
  const double oldest = std::max(realtime.most_delay - 2 * group, realtime.most_delay / 4);
  std::atomic<bool> begun{false};
  const auto age_of = [](Clock::time_point arrival) { return seconds_of(Clock::now() - arrival); };
  bool wrote = false;
  Encoder encoder(
      configuration_of(capture), options,
      [&](const void *bytes, size_t size) {
        sink(bytes, size);
        wrote = begun = true; // nothing is written before the stream is planned
      },
      observer);
  RealtimeReport out;
  Delays delays;
  std::vector<Clock::time_point> waiting; // frames of the group that is not written
  size_t missing = 0;                     // frames, after the last one that the encoder knows of
  uint64_t placed = 0;                    // frames that it knows of
  bool added = false, gave_up = false, begun_before = false;
  Pace pace(effort_steps);
  {
    const auto is_too_late = [&](Clock::time_point arrival) { return begun && age_of(arrival) > oldest; };
    std::unique_ptr<FrameSource> source;
    if (pipe)
      source = std::make_unique<PipeSource>(std::move(pipe), capture, options, is_too_late);
    else
      source = std::make_unique<FolderSource>(capture, options, realtime, is_stopped, is_too_late);
    Intake intake(std::move(source), options.group);
    for (Intake::Item item = intake.next();; item = intake.next()) {
      observer.check_cancelled();
      const auto tell = [&](RealtimeEvent::Kind kind, const std::string &text) {
        if (on_event) on_event({kind, item.number, std::max(0.0, age_of(item.arrival)), text});
      };
      if (item.is_last()) {
        out.end = item.reason;
        gave_up = item.kind == Intake::Item::given_up;
        if (gave_up && added) tell(RealtimeEvent::ended, item.reason);
        break;
      }
      wrote = false;
      const Clock::time_point before = Clock::now();
      const auto pass_missing = [&] {
        for (; missing; missing--, placed++) encoder.skip();
      };
      if (item.kind != Intake::Item::frame) {
        missing++;
        out.lost += item.kind == Intake::Item::lost;
        out.dropped += item.kind == Intake::Item::dropped;
        if (item.kind == Intake::Item::lost) tell(RealtimeEvent::lost, item.reason);
        if (item.kind == Intake::Item::dropped) tell(RealtimeEvent::dropped, "it was too old to be packed");
        // Frames do not wait for the next one that comes when the last ones of their group do not.
        if (waiting.empty() || (placed + missing) % options.group) continue;
        pass_missing();
      } else {
        pass_missing();
        waiting.push_back(item.arrival);
        encoder.add(std::move(item.content));
        added = true;
        placed++;
      }
      if (!wrote) continue;
      observer.progress(waiting.size());
      for (const Clock::time_point &arrival : waiting) delays.add(age_of(arrival));
      const size_t former = pace.step();
      // The first group planned the stream: it says nothing about the next ones.
      if (begun_before)
        pace.add(seconds_of(Clock::now() - before), double(waiting.size()) * duration,
                 seconds_of(before - item.arrival));
      begun_before = true;
      waiting.clear();
      if (pace.step() == former) continue;
      encoder.set_effort(pace.step());
      const EffortStep &step = effort_step(pace.step());
      item.number += capture.frames.step;
      out.steps.push_back({item.number, pace.step(), step.text});
      item.arrival = Clock::now(); // of no frame
      tell(pace.step() > former ? RealtimeEvent::lowered : RealtimeEvent::raised,
           fvv::format("step %zu: %s, as the last group took %.2f of its time", pace.step(), step.text,
                       pace.load()));
    }
  }
  if (!added) throw Error(capture.path + ": no frame was packed: " + out.end);
  Report report = encoder.finish();
  for (const Clock::time_point &arrival : waiting) delays.add(age_of(arrival));
  delays.report(out);
  report.warned = report.warned || warned || out.lost || out.dropped || gave_up;
  report.realtime = out;
  return report;
}

} // namespace fvv::mux
