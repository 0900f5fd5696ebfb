#include "fvv_mux/mux.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "mux/src/meshes.h"
#include "mux/src/pictures.h"
#include "mux/src/stream_writer.h"
#include "mux/src/summary_terms.h"
#include "mux/src/visibility.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <future>
#include <mutex>

namespace fvv::mux {

namespace {

// A piece of work for one thread. choice: finding the quality of the video; mesh, video: frames that are
// encoded together.
enum class Kind { choice, mesh, video };
struct Piece {
  Kind kind;
  size_t track;        // of the plan's video tracks
  size_t first, count; // frames
};

// What a group waits for. Each thread fills its own items.
struct TrackGroup {
  std::vector<media::Sample> samples;
  double quality = 0;
  bool over_rate = false;
};
struct Group {
  std::vector<MeshFrame> meshes;
  std::vector<VisibilityFrame> visibility; // if there is to be some
  std::vector<TrackGroup> videos;          // of each video track
};

// Warns of a frame that lost pieces or thin parts. frame: its number in file names. Returns whether it did.
bool warn_of_losses(const Plan &plan, int64_t frame, const decimate::Report &report) {
  const std::string name = plan.capture.mesh_path(frame) + ": frame " + std::to_string(frame) + ": ";
  if (report.vanished.pieces)
    plan.observer.warn(name + std::to_string(report.vanished.pieces) + " pieces of " +
                       area_text(plan, report.vanished.area) + " together vanish in decimation");
  if (report.thin_area > 0)
    plan.observer.warn(name + area_text(plan, report.thin_area) + " of the surface are further off than " +
                       fvv::format("%g px", decimate::max_over_rms * plan.decimation.budget.pixels) +
                       " after decimation");
  return report.vanished.pieces || report.thin_area > 0;
}

class Job {
public:
  // The choice of each video is made on the way, beside the first meshes.
  Job(Summary &sums, const Sink &out)
      : plan(sums.plan), sink(out), summary(sums), visibility(plan), groups(plan.group_count()),
        promises(plan.tracks.size()) {
    summary.videos.resize(plan.tracks.size());
    summary.rates.resize(plan.tracks.size());
    for (std::promise<void> &promise : promises) chosen.push_back(promise.get_future());
    for (size_t track = 0; track < plan.tracks.size(); track++) add(Kind::choice, 0, track, 0, 0);
    // The first video has to wait for the choice: meshes of two groups fill the other threads' time.
    list_meshes(0);
    list_meshes(1);
    list_video(0);
    list_video(1);
    for (size_t group = 2; group < plan.group_count(); group++) {
      list_video(group);
      list_meshes(group);
    }
  }

  // Answers the number of bytes written.
  uint64_t run() {
    run_ordered(
        plan.options.threads, group_of, [this](size_t piece) { work(pieces[piece]); },
        [&](size_t group) {
          if (!writer) begin(groups[group]);
          write(group);
          plan.observer.progress(plan.frames_of(group));
        });
    return writer->finish();
  }

private:
  void add(Kind kind, size_t group, size_t track, size_t first, size_t count) {
    pieces.push_back({kind, track, first, count});
    group_of.push_back(group);
  }

  void list_video(size_t group) {
    if (group >= plan.group_count()) return;
    const size_t first = plan.first_of(group), count = plan.frames_of(group);
    // Stills do not know each other, but they share a bit rate.
    const bool apart = media::find_video_codec(plan.options.codec)->is_stills() && !plan.options.bit_rate;
    const size_t together = apart ? 1 : count;
    for (size_t track = 0; track < plan.tracks.size(); track++)
      for (size_t i = 0; i < count; i += together) add(Kind::video, group, track, first + i, together);
  }

  void list_meshes(size_t group) {
    if (!plan.has_meshes() || group >= plan.group_count()) return;
    const size_t first = plan.first_of(group), count = plan.frames_of(group);
    const size_t together = plan.tracked ? count : 1; // delta frames know those before them
    for (size_t i = 0; i < count; i += together) add(Kind::mesh, group, 0, first + i, together);
  }

  // Rooms for results are made before a thread looks for its own.
  Group &group_for(size_t frame) {
    const std::lock_guard<std::mutex> lock(mutex);
    const size_t index = frame / plan.group_size;
    Group &group = groups[index];
    if (plan.has_meshes()) {
      group.meshes.resize(plan.frames_of(index));
      group.visibility.resize(plan.frames_of(index));
    }
    group.videos.resize(plan.tracks.size());
    for (TrackGroup &video : group.videos) video.samples.resize(plan.frames_of(index));
    return group;
  }

  void work(const Piece &piece) {
    plan.observer.check_cancelled();
    switch (piece.kind) {
    case Kind::choice:
      return choose(piece.track);
    case Kind::mesh:
      return encode_mesh_piece(piece);
    case Kind::video:
      return encode_video(piece);
    }
  }

  void encode_mesh_piece(const Piece &piece) {
    std::vector<MeshFrame> frames = encode_meshes(plan, piece.first, piece.count);
    std::vector<VisibilityFrame> seen = visibility.encode(piece.first, frames);
    Group &group = group_for(piece.first);
    const auto at = std::ptrdiff_t(piece.first % plan.group_size);
    std::move(frames.begin(), frames.end(), group.meshes.begin() + at);
    std::move(seen.begin(), seen.end(), group.visibility.begin() + at);
  }

  void choose(size_t track) {
    try {
      plan.tracks[track].choice = choose_video(plan, plan.tracks[track]);
      promises[track].set_value();
    } catch (...) {
      promises[track].set_exception(std::current_exception());
      throw;
    }
  }

  void encode_video(const Piece &piece) {
    std::shared_future<void>(chosen[piece.track]).get(); // a copy for each thread
    const VideoTrack &track = plan.tracks[piece.track];
    media::EncodedGroup encoded = encode_pictures(plan, track, piece.first, piece.count);
    if (encoded.record != track.choice.record)
      throw Error(plan.capture.path + ": group " + std::to_string(piece.first / plan.group_size) +
                  ": the encoder's configuration record differs from the first group's");
    TrackGroup &video = group_for(piece.first).videos[piece.track];
    std::move(encoded.samples.begin(), encoded.samples.end(),
              video.samples.begin() + std::ptrdiff_t(piece.first % plan.group_size));
    if (!plan.options.bit_rate) return; // several pieces may have one quality and one group
    video.quality = encoded.quality;
    video.over_rate = encoded.over_rate;
  }

  // The configuration tells of all tracks: with the first group it is known which there are.
  void begin(const Group &first) {
    uint64_t bytes = 0, pictures = 0;
    for (const VisibilityFrame &frame : first.visibility) bytes += frame.payload.size();
    for (size_t track = 0; track < plan.tracks.size(); track++)
      for (const media::Sample &sample : first.videos[track].samples)
        if (!plan.tracks[track].is_atlas()) pictures += sample.bytes.size();
    settle_visibility(plan.visibility, bytes, pictures);
    if (!plan.visibility.on) visibility.stop();
    writer.emplace(plan, sink);
  }

  void write(size_t index) {
    Group group = std::move(groups[index]);
    groups[index] = {};
    const size_t first = plan.first_of(index), count = plan.frames_of(index);
    if (index && plan.options.repeat_configuration) writer->repeat_configuration();
    writer->begin_group(first, count);
    for (size_t i = 0; i < count; i++) {
      if (plan.has_meshes()) {
        MeshFrame &mesh = group.meshes[i];
        writer->mesh(first + i, mesh.payload, mesh.key);
        summary.mesh.add(mesh.payload.size());
        if (!mesh.key) summary.delta.add(mesh.payload.size());
        summary.changes.add(mesh.source, mesh.report);
        if (plan.options.verify)
          summary.origins.push_back({std::move(mesh.origins), mesh.report.flipped_faces});
        if (mesh.decimation) {
          summary.decimation.add(*mesh.decimation);
          const int64_t number = plan.capture.frames.number(int64_t(first + i));
          if (warn_of_losses(plan, number, *mesh.decimation)) plan.warned = true;
        }
      }
      const uint64_t calibration = writer->calibration(first + i, i == 0);
      if (calibration) summary.calibration.add(calibration);
      if (plan.has_meshes() && plan.visibility.on) {
        const VisibilityFrame &frame = group.visibility[i];
        if (!frame.payload.empty()) writer->visibility(first + i, frame.payload, frame.key);
        summary.visibility.add(frame);
      }
      bool own_layout = false; // of any track
      for (size_t track = 0; track < plan.tracks.size(); track++) {
        if (i == 0) own_layout = writer->layout(plan.tracks[track], index) || own_layout;
        const media::Sample &sample = group.videos[track].samples[i];
        writer->sample(plan.tracks[track], first + i, sample);
        summary.videos[track].add(sample.bytes.size());
      }
      summary.layouts += own_layout;
      // Behind the second frame: the first is known to be whole by then (fvv.md clause 18.5).
      const bool first_or_repeated = !index || plan.options.repeat_configuration;
      if (plan.background && first_or_repeated && i == std::min<size_t>(1, count - 1))
        summary.background.add(writer->background(first + i));
    }
    writer->end_group();
    const media::VideoCodec &codec = *media::find_video_codec(plan.options.codec);
    for (size_t track = 0; track < plan.tracks.size(); track++)
      summary.rates[track].add(codec, group.videos[track].quality, group.videos[track].over_rate);
  }

  Plan &plan;
  const Sink &sink;
  Summary &summary;
  VisibilityCoder visibility;
  std::optional<StreamWriter> writer; // once the choices of video are known
  std::vector<Piece> pieces;
  std::vector<size_t> group_of;
  std::mutex mutex; // of groups
  std::vector<Group> groups;
  std::vector<std::promise<void>> promises; // of each video track: its choice is made
  std::vector<std::shared_future<void>> chosen;
};

} // namespace

void TrackBytes::add(uint64_t bytes) {
  chunks++;
  payload += bytes;
  smallest = std::min(smallest, bytes);
  largest = std::max(largest, bytes);
}

void RateResult::add(const media::VideoCodec &codec, double quality, bool is_over) {
  const auto finer = [&](double a, double b) { return codec.finest < codec.coarsest ? a < b : a > b; };
  if (!groups || finer(quality, finest)) finest = quality;
  if (!groups || finer(coarsest, quality)) coarsest = quality;
  groups++;
  over += is_over;
}

double Summary::bit_rate(size_t track) const {
  const fvv_rational &duration = plan.capture.frame_duration;
  return double(videos[track].payload) * 8 * duration.denominator / duration.numerator /
         double(plan.frame_count());
}

void MeshChanges::add(const scene::MeshReport &source, const fvv_mesh_report &report) {
  split_polygons.add(source.polygons);
  left_out.add(source.lines_and_points);
  welded.add(report.welded_vertices);
  degenerate.add(report.degenerate_faces);
  duplicate.add(report.duplicate_faces);
  unreferenced.add(report.unreferenced_vertices);
  flipped.add(report.flipped_faces);
  dropped_components.add(report.dropped_components);
  dropped_faces.add(report.dropped_component_faces);
  nonmanifold_edges.add(report.nonmanifold_edges);
  boundary_edges.add(report.boundary_edges);
  changed_frames += source.polygons || source.lines_and_points || report.welded_vertices ||
                    report.degenerate_faces || report.duplicate_faces || report.unreferenced_vertices ||
                    report.flipped_faces || report.dropped_components;
  max_error = std::max(max_error, report.max_error);
}

namespace {

// A rate that is too low even for the worst picture is no failure: the stream is whole.
bool warn_of_rates(const Summary &summary) {
  bool warned = false;
  for (size_t track = 0; track < summary.rates.size(); track++) {
    const RateResult &rate = summary.rates[track];
    if (!rate.over) continue;
    const VideoTrack &video = summary.plan.tracks[track];
    const media::VideoCodec &codec = *media::find_video_codec(video.choice.settings.codec);
    char text[200];
    std::snprintf(
        text, sizeof text,
        "--bitrate: %zu of %zu groups of the %s take more than %.4g kbit/s even at %s %d; in all it "
        "is %.4g kbit/s",
        rate.over, rate.groups, name_of(summary, video).c_str(),
        double(video.choice.settings.bit_rate) / 1000, codec.scale, codec.coarsest,
        summary.bit_rate(track) / 1000);
    summary.plan.observer.warn(summary.plan.capture.path + ": " + text);
    warned = true;
  }
  return warned;
}

} // namespace

Muxer::Muxer(const Options &options, const Observer &observer) : start(std::chrono::steady_clock::now()) {
  summary.plan = make_plan(options, observer);
}

Summary Muxer::run(const Sink &sink) {
  summary.bytes = Job(summary, sink).run();
  if (warn_of_rates(summary)) summary.plan.warned = true;
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return std::move(summary);
}

void verify(Summary &summary, const InputFile &file) {
  summary.verdict = verify(summary.plan, summary.origins, file);
}

} // namespace fvv::mux
