#include "mux/src/encode/encode_job.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "mux/src/choices.h"
#include "mux/src/ladder/mesh_rungs.h"
#include "mux/src/meshes.h"
#include "mux/src/pictures.h"
#include "mux/src/summary_terms.h"
#include "mux/src/visibility.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <deque>
#include <future>
#include <mutex>

namespace fvv::mux {

namespace {

// Warns of what lost pieces or thin parts: a frame, by its report, or a track, by its sums. times: the error.
// Returns whether it did.
template <class Losses>
bool warn_of_losses(const Plan &plan, const std::string &name, double times, const Losses &losses) {
  if (losses.vanished.pieces)
    plan.observer.warn(name + ": " + std::to_string(losses.vanished.pieces) + " pieces of " +
                       area_text(plan, losses.vanished.area) + " together vanish in decimation");
  if (losses.thin_area > 0)
    plan.observer.warn(name + ": " + area_text(plan, losses.thin_area) +
                       " of the surface are further off than " +
                       budget_text(plan, decimate::max_over_rms * times) + " after decimation");
  return losses.vanished.pieces || losses.thin_area > 0;
}

// The same for what rounding to the lattice took away. frame: its number in file names.
bool warn_of_quantisation(const Plan &plan, const MeshTrack &track, int64_t frame,
                          const QuantisationLoss &loss) {
  const decimate::Lost &pieces = loss.pieces;
  if (!(loss.share > most_quantisation_loss) && !pieces.pieces) return false;
  const std::string what =
      loss.share > most_quantisation_loss
          ? fvv::format("faces with %.3g %% of the area vanish", 100 * loss.share)
          : std::to_string(pieces.pieces) + (pieces.pieces == 1 ? " piece of " : " pieces of ") +
                area_text(plan, pieces.area) + (pieces.pieces == 1 ? " vanishes" : " together vanish");
  plan.observer.warn(plan.capture.mesh_path(frame) + ": frame " + std::to_string(frame) + ": " +
                     (track.rung ? "rung " + std::to_string(track.rung) + ": " : "") + what +
                     " on the lattice, whose step is " + length_text(plan, plan.lattice.lattice.step) + ", " +
                     plan.lattice.reason + " (--max-error or --step asks for a finer one)");
  return true;
}

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

void warn_at_end(Summary &summary) {
  Plan &plan = summary.plan;
  if (warn_of_rates(summary)) plan.warned = true;
  for (size_t k = 1; k < plan.meshes.size(); k++) {
    const MeshTrack &track = plan.meshes[k];
    const std::string name = plan.capture.path + ": rung " + std::to_string(track.rung);
    if (warn_of_losses(plan, name, track.times, summary.meshes(k).decimation)) plan.warned = true;
  }
}

class EncodeJob::State {
public:
  State(Summary &sums, const Sink &out)
      : plan(sums.plan), sink(out), summary(sums), surfaces(plan), room(plan.options.threads),
        promises(plan.tracks.size()), unwanted(plan.meshes.size()) {
    if (plan.has_meshes()) summary.lower_meshes.resize(plan.meshes.size() - 1);
    summary.origins.resize(plan.meshes.size());
    summary.videos.resize(plan.tracks.size());
    summary.rates.resize(plan.tracks.size());
    for (std::promise<void> &promise : promises) chosen.push_back(promise.get_future());
    // The choice of each video is made on the way, beside the first meshes.
    for (size_t track = 0; track < plan.tracks.size(); track++)
      if (!plan.tracks[track].rung) add(Kind::choice, 0, track, 0, 0);
  }

  // Everything is chosen, and begin() has been called in another job.
  void join(const NominalRates &nominal, size_t group) {
    tasks.clear();
    group_of.clear();
    for (std::promise<void> &promise : promises) promise.set_value();
    for (size_t track = 0; track < plan.meshes.size(); track++) unwanted[track] = !plan.meshes[track].sent;
    writer.emplace(plan, sink, nominal);
    writer->join(group);
    first_written = group;
  }

  const NominalRates &nominal() const { return writer->nominal_values(); }

  // Encodes and writes all groups of the plan.
  void run() {
    // The first video has to wait for the choice: meshes of two groups fill the other threads' time.
    list_meshes(0);
    list_meshes(1);
    list_lower_meshes(0);
    list_rungs();
    list_video(0);
    list_video(1);
    list_lower_meshes(1);
    for (size_t group = 2; group < plan.group_count(); group++) {
      list_video(group);
      list_meshes(group);
      list_lower_meshes(group);
    }
    run_listed(0);
  }

  // Encodes and writes one group, the next one.
  void run_group(size_t group) {
    list_meshes(group);
    list_lower_meshes(group);
    if (!writer) list_rungs();
    list_video(group);
    for (size_t &listed : group_of) listed = 0;
    run_listed(group);
  }

  // Writes index and footer and completes the summary. start: of the whole run.
  void finish(std::chrono::steady_clock::time_point start) {
    summary.bytes = writer->finish();
    summary.sounds = writer->sounds();
    warn_at_end(summary);
    if (plan.capture.mesh_cache) summary.mesh_reads = scene::mesh_reads(*plan.capture.mesh_cache);
    summary.picture_reads = plan.videos->reads();
    summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

private:
  // Work for one thread. choice: finding the quality of the video; mesh, video: frames that are
  // encoded together.
  enum class Kind { choice, mesh, video };
  struct Task {
    Kind kind;
    size_t track;        // of the plan's video tracks or mesh tracks
    size_t first, count; // frames
  };

  // What a group waits for. Each thread fills its own items.
  struct TrackGroup {
    std::vector<media::Sample> samples;
    double quality = 0;
    bool over_rate = false;
  };
  struct MeshGroup {
    std::vector<MeshFrame> frames;
    SurfaceFrames surfaces;
  };
  struct Group {
    std::vector<MeshGroup> meshes;  // of each mesh track
    std::vector<TrackGroup> videos; // of each video track
  };

  // first: the group that is listed as 0.
  void run_listed(size_t first) {
    groups.resize(plan.group_count());
    run_ordered(
        plan.options.threads, group_of, [this](size_t task) { work(tasks[task]); },
        [&](size_t listed) {
          const size_t group = first + listed;
          if (!writer) begin(groups[group]);
          write(group);
          plan.observer.progress(plan.frames_of(group));
        },
        [this] { room.help(); });
    tasks.clear();
    group_of.clear();
  }

  void add(Kind kind, size_t group, size_t track, size_t first, size_t count) {
    tasks.push_back({kind, track, first, count});
    group_of.push_back(group);
  }

  // The choices of lower rungs wait for those of the first.
  void list_rungs() {
    for (size_t track = 0; track < plan.tracks.size(); track++)
      if (plan.tracks[track].rung) add(Kind::choice, 0, track, 0, 0);
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

  void list_lower_meshes(size_t group) {
    for (size_t track = 1; track < plan.meshes.size(); track++)
      if (!unwanted[track]) list_meshes(group, track);
  }

  void list_meshes(size_t group, size_t track = 0) {
    if (!plan.has_meshes() || group >= plan.group_count()) return;
    const size_t first = plan.first_of(group), count = plan.frames_of(group);
    const size_t together = plan.has_constant_topology ? count : 1; // delta frames know those before them
    for (size_t i = 0; i < count; i += together) add(Kind::mesh, group, track, first + i, together);
  }

  // Rooms for results are made before a thread looks for its own.
  Group &group_for(size_t frame) {
    const std::lock_guard<std::mutex> lock(mutex);
    const size_t index = plan.group_of(frame);
    Group &group = groups[index];
    group.meshes.resize(plan.meshes.size());
    for (MeshGroup &meshes : group.meshes) {
      meshes.frames.resize(plan.frames_of(index));
      meshes.surfaces.visibility.resize(plan.frames_of(index));
      meshes.surfaces.colours.resize(plan.frames_of(index));
    }
    group.videos.resize(plan.tracks.size());
    for (TrackGroup &video : group.videos) video.samples.resize(plan.frames_of(index));
    return group;
  }

  void work(const Task &task) {
    plan.observer.check_cancelled();
    switch (task.kind) {
    case Kind::choice:
      return choose(task.track);
    case Kind::mesh:
      return encode_mesh(task);
    case Kind::video:
      return encode_video(task);
    }
  }

  void encode_mesh(const Task &task) {
    if (unwanted[task.track]) return;
    const MeshTrack &track = plan.meshes[task.track];
    std::vector<MeshFrame> frames = encode_meshes(plan, track, task.first, task.count);
    SurfaceFrames seen = surfaces.encode(track, task.first, frames);
    MeshGroup &group = group_for(task.first).meshes[task.track];
    const auto at = std::ptrdiff_t(task.first - plan.first_of(plan.group_of(task.first)));
    std::move(frames.begin(), frames.end(), group.frames.begin() + at);
    std::move(seen.visibility.begin(), seen.visibility.end(), group.surfaces.visibility.begin() + at);
    std::move(seen.colours.begin(), seen.colours.end(), group.surfaces.colours.begin() + at);
  }

  void choose(size_t track) {
    try {
      if (const size_t best = plan.tracks[track].best; best != track)
        std::shared_future<void>(chosen[best]).get();
      plan.tracks[track].choice = choose_video(plan, plan.tracks[track], room);
      promises[track].set_value();
    } catch (...) {
      promises[track].set_exception(std::current_exception());
      throw;
    }
  }

  void encode_video(const Task &task) {
    std::shared_future<void>(chosen[task.track]).get(); // a copy for each thread
    const VideoTrack &track = plan.tracks[task.track];
    media::EncodedGroup encoded = encode_pictures(plan, track, task.first, task.count, room);
    if (encoded.record != track.choice.record)
      throw Error(plan.capture.path + ": group " + std::to_string(plan.group_of(task.first)) +
                  ": the encoder's configuration record differs from the first group's");
    TrackGroup &video = group_for(task.first).videos[task.track];
    const size_t at = task.first - plan.first_of(plan.group_of(task.first));
    std::move(encoded.samples.begin(), encoded.samples.end(), video.samples.begin() + std::ptrdiff_t(at));
    if (!plan.options.bit_rate) return; // several tasks may have one quality and one group
    video.quality = encoded.quality;
    video.over_rate = encoded.over_rate;
  }

  // The configuration tells of all tracks: with the first group it is known which there are.
  void begin(const Group &first) {
    uint64_t bytes = 0, pictures = 0;
    if (plan.has_meshes())
      for (const VisibilityFrame &frame : first.meshes[0].surfaces.visibility) bytes += frame.payload.size();
    for (size_t track = 0; track < plan.tracks.size(); track++)
      for (const media::Sample &sample : first.videos[track].samples)
        if (!plan.tracks[track].is_atlas() && !plan.tracks[track].rung) pictures += sample.bytes.size();
    settle_visibility(plan.visibility, bytes, pictures);
    if (!plan.visibility.on) surfaces.stop_visibility();
    std::vector<uint64_t> meshes, rungs(plan.rung_count());
    for (const MeshGroup &group : first.meshes) meshes.push_back(bytes_of(group));
    for (size_t track = 0; track < plan.tracks.size(); track++)
      for (size_t rung = 0; rung < rungs.size(); rung++)
        for (const media::Sample &sample : first.videos[track].samples)
          if (plan.tracks[track].is_in(rung)) rungs[rung] += sample.bytes.size();
    settle_mesh_rungs(plan, meshes, rungs);
    for (size_t track = 0; track < plan.meshes.size(); track++) unwanted[track] = !plan.meshes[track].sent;
    writer.emplace(plan, sink, nominal_of(first));
  }

  // Of a track with its visibility and colours, as far as these are sent.
  uint64_t bytes_of(const MeshGroup &group) const {
    uint64_t bytes = 0;
    for (const MeshFrame &mesh : group.frames) bytes += mesh.payload.size();
    for (const VisibilityFrame &frame : group.surfaces.visibility)
      bytes += plan.visibility.on ? frame.payload.size() : 0;
    for (const ColourFrame &frame : group.surfaces.colours) bytes += frame.payload.size();
    return bytes;
  }

  // Of a ladder, so that a reader can tell what a rung takes: what pictures were to take, or took when their
  // quality was chosen, and what all else takes in the first group.
  NominalRates nominal_of(const Group &first) const {
    NominalRates nominal;
    if (plan.options.ladder.empty()) return nominal;
    const fvv_rational &duration = plan.capture.frame_duration;
    const double per_second = double(duration.denominator) / duration.numerator / double(plan.groups[0].end);
    const auto add = [&](uint16_t track, uint64_t bytes) {
      if (bytes) nominal.rates[track] += 8 * double(bytes) * per_second;
    };
    for (size_t k = 0; k < plan.meshes.size(); k++) {
      const MeshTrack &track = plan.meshes[k];
      double meshes = 0, faces = 0;
      for (const MeshFrame &mesh : first.meshes[k].frames) {
        add(track.id, mesh.payload.size());
        meshes += !mesh.payload.empty();
        faces += mesh.faces;
      }
      if (meshes) nominal.sizes[track.id] = faces / meshes;
      for (const VisibilityFrame &frame : first.meshes[k].surfaces.visibility)
        if (plan.visibility.on) add(track.visibility, frame.payload.size());
      for (const ColourFrame &frame : first.meshes[k].surfaces.colours)
        if (plan.colours.on) add(track.colours, frame.payload.size());
    }
    for (size_t k = 0; k < plan.tracks.size(); k++) {
      const VideoTrack &track = plan.tracks[k];
      const VideoChoice &choice = track.choice;
      if (track.encoded)
        for (const media::Sample &sample : first.videos[k].samples) add(track.id, sample.bytes.size());
      else
        nominal.rates[track.id] =
            choice.settings.bit_rate ? double(choice.settings.bit_rate) : choice.sample_rate;
    }
    return nominal;
  }

  // Of one frame.
  void write_mesh(size_t track, size_t frame, MeshFrame &mesh) {
    const MeshTrack &of = plan.meshes[track];
    MeshSums &sums = summary.meshes(track);
    writer->mesh(of, frame, mesh.payload, mesh.key);
    sums.mesh.add(mesh.payload.size());
    if (!mesh.key) sums.delta.add(mesh.payload.size());
    sums.faces += mesh.faces;
    sums.changes.add(mesh.source, mesh.report);
    if (plan.options.verify)
      summary.origins[track].push_back({std::move(mesh.origins), mesh.report.flipped_faces});
    const int64_t number = plan.capture.frames.number(int64_t(frame));
    if (warn_of_quantisation(plan, of, number, mesh.loss)) plan.warned = true;
    if (!mesh.decimation) return;
    sums.decimation.add(*mesh.decimation);
    if (of.rung) return; // more is lost there: one warning for all frames
    const std::string name = plan.capture.mesh_path(number) + ": frame " + std::to_string(number);
    if (warn_of_losses(plan, name, 1, *mesh.decimation)) plan.warned = true;
  }

  void write_surfaces(size_t track, size_t frame, const VisibilityFrame &seen, const ColourFrame &colours) {
    const MeshTrack &of = plan.meshes[track];
    MeshSums &sums = summary.meshes(track);
    if (plan.visibility.on) {
      if (!seen.payload.empty()) writer->visibility(of, frame, seen.payload, seen.key);
      sums.visibility.add(seen);
    }
    if (plan.colours.on) {
      if (!colours.payload.empty()) writer->colours(of, frame, colours.payload);
      sums.colours.add(colours);
    }
  }

  void write(size_t index) {
    Group group = std::move(groups[index]);
    groups[index] = {};
    const size_t first = plan.first_of(index), count = plan.frames_of(index);
    const std::vector<SoundChunk> sounds = sound_chunks(plan, plan.groups[index]);
    auto sound = sounds.begin();
    const auto write_sound_before = [&](int64_t tick) {
      for (; sound != sounds.end() && sound->time < tick; ++sound) writer->sound(*sound);
    };
    if (index != first_written && plan.options.repeat_configuration) writer->repeat_configuration();
    writer->begin_group(index);
    for (size_t i = 0; i < count; i++) {
      write_sound_before(plan.tick_of(first + i)); // that of a frame after its pictures
      bool own_layout = false;                     // of any track
      const MeshTrack *written = nullptr;
      for (size_t rung = plan.rung_count(); rung-- > 0;) { // a low rung ends before the better ones begin
        const MeshTrack *mesh = plan.has_meshes() ? &plan.mesh_of(rung) : nullptr;
        const size_t k = mesh ? size_t(mesh - plan.meshes.data()) : 0;
        const bool next = mesh != written;
        if (next && plan.has_mesh(first + i))
          write_mesh(k, first + i, group.meshes[k].frames[i]);
        else if (next && plan.options.verify)
          summary.origins[k].emplace_back();
        if (rung + 1 == plan.rung_count())
          if (const uint64_t calibration = writer->calibration(first + i, i == 0))
            summary.calibration.add(calibration);
        if (next) {
          const SurfaceFrames &surfaces_of = group.meshes[k].surfaces;
          write_surfaces(k, first + i, surfaces_of.visibility[i], surfaces_of.colours[i]);
        }
        written = mesh;
        for (size_t track = 0; track < plan.tracks.size(); track++) {
          if (plan.tracks[track].rung != rung) continue;
          if (i == 0) own_layout = writer->layout(plan.tracks[track], index) || own_layout;
          const media::Sample &sample = group.videos[track].samples[i];
          writer->sample(plan.tracks[track], first + i, sample);
          summary.videos[track].add(sample.bytes.size());
        }
      }
      summary.layouts += own_layout;
      // Behind the second frame: the first is known to be whole by then (fvv.md clause 18.5).
      const bool first_or_repeated = !index || plan.options.repeat_configuration;
      if (plan.background && first_or_repeated && i == std::min<size_t>(1, count - 1))
        summary.background.add(writer->background(first + i));
    }
    write_sound_before(plan.groups[index].end);
    writer->end_group();
    for (const MeshTrack &track : plan.meshes)
      if (!plan.options.verify || !track.sent) track.loader->forget(index);
    const media::VideoCodec &codec = *media::find_video_codec(plan.options.codec);
    for (size_t track = 0; track < plan.tracks.size(); track++)
      if (!plan.tracks[track].encoded)
        summary.rates[track].add(codec, group.videos[track].quality, group.videos[track].over_rate);
  }

  Plan &plan;
  const Sink &sink;
  Summary &summary;
  SurfaceCoder surfaces;
  EncoderRoom room;
  size_t first_written = 0;           // group; the configuration is before it anyway
  std::optional<StreamWriter> writer; // once the choices of video are known
  std::vector<Task> tasks;
  std::vector<size_t> group_of;
  std::mutex mutex; // of groups
  std::vector<Group> groups;
  std::vector<std::promise<void>> promises; // of each video track: its choice is made
  std::vector<std::shared_future<void>> chosen;
  std::deque<std::atomic<bool>> unwanted; // mesh tracks of which no more is encoded
};

EncodeJob::EncodeJob(Summary &summary, const Sink &sink) : state(std::make_unique<State>(summary, sink)) {}

EncodeJob::EncodeJob(Summary &summary, const Sink &sink, const NominalRates &nominal, size_t group)
    : EncodeJob(summary, sink) {
  state->join(nominal, group);
}

EncodeJob::~EncodeJob() = default;

void EncodeJob::run() {
  state->run();
}

void EncodeJob::run_group(size_t group) {
  state->run_group(group);
}

const NominalRates &EncodeJob::nominal() const {
  return state->nominal();
}

void EncodeJob::finish(std::chrono::steady_clock::time_point start) {
  state->finish(start);
}

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
  return double(videos[track].payload) * 8 * duration.denominator / duration.numerator / double(plan.end());
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

} // namespace fvv::mux
