#include "mux/src/encode/encode_job.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "mux/src/choose/choices.h"
#include "mux/src/ladder/mesh_rungs.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/pictures.h"
#include "mux/src/report/report_names.h"
#include "mux/src/terms.h"
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

// What of the pieces that vanish is a loss to warn of. Where views decide how coarse meshes are, pieces of a
// frame, on average, that are together less than a pixel of the camera that sees them sharpest are none.
decimate::Lost seen_loss(const Plan &plan, const decimate::Lost &vanished, uint64_t frames) {
  const DecimationChoice &decimation = plan.meshes[0].decimation;
  const double area = vanished.area / double(std::max<uint64_t>(1, frames));
  const bool is_unseen =
      plan.view.on() && !decimation.is_length && area <= decimation.pixel * decimation.pixel;
  return is_unseen ? decimate::Lost{} : vanished;
}

// Warns of what lost pieces or thin parts: a frame, by its report, or a track, by its sums. times: the error.
// Returns whether it did.
bool warn_of_losses(const Plan &plan, const std::string &name, double times, const decimate::Lost &vanished,
                    double thin_area) {
  if (vanished.pieces)
    plan.observer.warn(name + ": " + std::to_string(vanished.pieces) + " pieces of " +
                       area_text(plan, vanished.area) + " together vanish in decimation");
  if (thin_area > 0)
    plan.observer.warn(name + ": " + area_text(plan, thin_area) + " of the surface are further off than " +
                       budget_text(plan, plan.meshes[0].decimation.budget.most_over_rms() * times) +
                       " after decimation");
  return vanished.pieces || thin_area > 0;
}

// The same for what rounding to the lattice took away. frame: its number in file names.
bool warn_of_quantisation(const Plan &plan, const MeshTrack &track, int64_t frame,
                          const QuantisationLoss &loss) {
  const auto pieces = [&](const decimate::Lost &lost, const char *one, const char *many) {
    return std::to_string(lost.pieces) + (lost.pieces == 1 ? " piece of " : " pieces of ") +
           area_text(plan, lost.area) + " " + (lost.pieces == 1 ? one : many);
  };
  std::string what;
  if (loss.flat.pieces)
    what = pieces(loss.flat, "loses its thickness", "together lose their thickness");
  else if (loss.share > most_quantisation_loss)
    what = fvv::format("faces with %.3g %% of the area vanish", 100 * loss.share);
  else if (loss.pieces.pieces)
    what = pieces(loss.pieces, "vanishes", "together vanish");
  else
    return false;
  plan.observer.warn(plan.capture.mesh_path(frame) + ": frame " + std::to_string(frame) + ": " +
                     (track.rung ? "rung " + std::to_string(track.rung) + ": " : "") + what +
                     " on the lattice, whose step is " + length_text(plan, plan.lattice.lattice.step) + ", " +
                     plan.lattice.reason + " (" + option_name("max-error") + " or " + option_name("step") +
                     " asks for a finer one)");
  return true;
}

// Of vertices that bring colours: where others have some and these have none, and where too many of them
// share a cell.
bool warn_of_colours(const Plan &plan, size_t frame, const ColourFrame &colours) {
  constexpr double poor = 30; // dB
  if (!colours.vertices || (!colours.payload.empty() && colours.psnr() >= poor)) return false;
  const int64_t number = plan.capture.frames.number(int64_t(frame));
  plan.observer.warn(
      plan.capture.mesh_path(number) + ": frame " + std::to_string(number) + ": " +
      (colours.payload.empty()
           ? std::string("has no colours of vertices, as other frames have: it is grey")
           : fvv::format("%u vertices have %u cells of colour, %.1f dB: a finer mesh's colours belong into a "
                         "picture",
                         colours.vertices, colours.cells, colours.psnr()) +
                 " (" + option_name("atlas") + ")"));
  return true;
}

std::string name_of(const Plan &plan, const VideoTrack &track) {
  std::string out = track.is_atlas()                   ? "the atlas"
                    : track.tiling.cameras.size() == 1 ? "camera "
                                                       : "cameras ";
  if (!track.is_atlas())
    for (const size_t &camera : track.tiling.cameras)
      out += (&camera == track.tiling.cameras.data() ? "" : ", ") +
             std::to_string(plan.capture.cameras[camera].calibration.id);
  return out + (track.rung ? " in rung " + std::to_string(track.rung) : "");
}

// A quality that is too high even for the best picture is no failure either.
bool warn_of_qualities(const Plan &plan, const Decisions &decisions) {
  bool warned = false;
  for (size_t k = 0; k < plan.tracks.size(); k++) {
    const VideoDecision &video = decisions.videos[k];
    if (video.sample_psnr >= video.target_psnr) continue;
    const media::VideoCodec &codec = *media::find_video_codec(video.settings.codec);
    plan.observer.warn(plan.capture.path + ": " + option_name("quality") + ": " +
                       name_of(plan, plan.tracks[k]) +
                       fvv::format(": %.4g dB were to be reached, and no %s reaches more than about %.4g dB: "
                                   "sent with %s %g",
                                   video.target_psnr, codec.scale, video.sample_psnr, codec.scale,
                                   video.settings.quality + video.settings.parts));
    warned = true;
  }
  return warned;
}

// A rate that is too low even for the worst picture is no failure: the stream is whole.
bool warn_of_rates(const Plan &plan, const Report &report) {
  bool warned = false;
  for (const VideoTrackReport &video : report.videos) {
    if (!video.rate.over) continue;
    const media::VideoCodec &codec = *media::find_video_codec(video.codec);
    plan.observer.warn(
        plan.capture.path + ": " + option_name("bitrate") +
        fvv::format(": %zu of %zu groups of the %s take more than %.4g kbit/s even at %s %d; in all "
                    "it is %.4g kbit/s",
                    video.rate.over, video.rate.groups, name_of(report, video).c_str(),
                    double(video.target_rate) / 1000, codec.scale, codec.coarsest, video.bit_rate / 1000));
    warned = true;
  }
  return warned;
}

} // namespace

bool warn_at_end(const Plan &plan, const Report &report) {
  bool warned = warn_of_rates(plan, report);
  if (const Change &crossing = report.changes.self_crossing; crossing.count) {
    plan.observer.warn(plan.capture.path + ": polygons that cross themselves: " +
                       std::to_string(crossing.count) + " in " + std::to_string(crossing.frames) +
                       " frames; triangles around the first corner cover more than they do: write triangles");
    warned = true;
  }
  if (const Change &bare = report.changes.untextured; bare.count) {
    plan.observer.warn(plan.capture.path + ": triangles without texture coordinates, whose material has a " +
                       "picture: " + std::to_string(bare.count) + " in " + std::to_string(bare.frames) +
                       " frames; they have the material's colour alone");
    warned = true;
  }
  for (size_t k = 0; k < report.lower_meshes.size(); k++) {
    const MeshTrack &track = plan.meshes[k + 1];
    const DecimationSums &sums = report.lower_meshes[k].decimation;
    const decimate::Lost vanished = seen_loss(plan, {sums.vanished_pieces, sums.vanished_area}, sums.frames);
    warned = warn_of_losses(plan, plan.capture.path + ": rung " + std::to_string(track.rung), track.times,
                            vanished, sums.thin_area) ||
             warned;
  }
  return warned;
}

class EncodeJob::State {
public:
  State(const Plan &chosen, const Sink &out)
      : plan(chosen), sink(out), sums(plan), surfaces(plan), room(plan.options.threads),
        promises(plan.tracks.size()), unwanted(plan.meshes.size()) {
    for (std::promise<VideoChoice> &promise : promises) chosen_videos.push_back(promise.get_future());
    // The choice of each video is made on the way, beside the first meshes.
    for (size_t track = 0; track < plan.tracks.size(); track++)
      if (!plan.tracks[track].rung) add(Kind::choice, 0, track, 0, 0);
  }

  // Everything is decided, by the first group in another job.
  void join(const Decisions &known, size_t group) {
    tasks.clear();
    group_of.clear();
    for (size_t track = 0; track < promises.size(); track++)
      promises[track].set_value({known.videos[track], nullptr});
    begin(known);
    writer->join(group);
    first_written = group;
  }

  const Decisions &decisions() const { return *decided; }
  const StreamSums &all_sums() const { return sums; }

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

  Report finish(std::chrono::steady_clock::time_point start) {
    sums.bytes = writer->finish();
    sums.sounds = writer->sounds();
    Report report = make_report(plan, *decided, sums);
    report.warned = warn_at_end(plan, report) || report.warned;
    if (plan.capture.mesh_cache) report.mesh_reads = scene::mesh_reads(*plan.capture.mesh_cache);
    const scene::PictureReads reads = plan.videos->reads();
    report.picture_reads = reads.pictures;
    report.mask_reads = reads.masks;
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
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
          if (!writer) {
            begin(decide(plan, videos(), bytes_of(groups[group])));
            sums.warned = warn_of_qualities(plan, *decided) || sums.warned;
          }
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
      const size_t best = plan.tracks[track].best;
      const VideoDecision *of_best = best == track ? nullptr : &video(best).decision;
      promises[track].set_value(choose_video(plan, plan.tracks[track], of_best, room));
    } catch (...) {
      promises[track].set_exception(std::current_exception());
      throw;
    }
  }

  // Waits for the choice. It lives as long as this object.
  const VideoChoice &video(size_t track) const {
    return std::shared_future<VideoChoice>(chosen_videos[track]).get(); // a copy for each thread
  }

  void encode_video(const Task &task) {
    const VideoChoice &choice = video(task.track);
    const VideoTrack &track = plan.tracks[task.track];
    media::EncodedGroup encoded = encode_pictures(plan, track, choice, task.first, task.count, room);
    if (encoded.record != choice.decision.record)
      throw Error(plan.capture.path + ": group " + std::to_string(plan.group_of(task.first)) +
                  ": the encoder's configuration record differs from the first group's");
    TrackGroup &samples = group_for(task.first).videos[task.track];
    const size_t at = task.first - plan.first_of(plan.group_of(task.first));
    std::move(encoded.samples.begin(), encoded.samples.end(), samples.samples.begin() + std::ptrdiff_t(at));
    if (!plan.options.bit_rate) return; // several tasks may have one quality and one group
    samples.quality = encoded.quality;
    samples.over_rate = encoded.over_rate;
  }

  // Those that are chosen by now.
  std::vector<VideoDecision> videos() const {
    std::vector<VideoDecision> out;
    for (size_t track = 0; track < plan.tracks.size(); track++) out.push_back(video(track).decision);
    return out;
  }

  FirstGroup bytes_of(const Group &group) const {
    FirstGroup out;
    for (const MeshGroup &track : group.meshes) {
      FirstGroup::Meshes &meshes = out.meshes.emplace_back();
      for (const MeshFrame &mesh : track.frames) {
        meshes.mesh += mesh.payload.size();
        meshes.frames += !mesh.payload.empty();
        meshes.faces += mesh.faces;
      }
      for (const VisibilityFrame &frame : track.surfaces.visibility)
        meshes.visibility += frame.payload.size();
      for (const ColourFrame &frame : track.surfaces.colours) meshes.colours += frame.payload.size();
    }
    for (const TrackGroup &track : group.videos) {
      uint64_t &bytes = out.videos.emplace_back();
      for (const media::Sample &sample : track.samples) bytes += sample.bytes.size();
    }
    return out;
  }

  // The configuration lists all tracks: the decisions say which there are.
  void begin(Decisions known) {
    decided.emplace(std::move(known));
    if (!decided->visibility.on) surfaces.stop_visibility();
    for (size_t track = 0; track < plan.meshes.size(); track++)
      unwanted[track] = !decided->meshes[track].sent;
    writer.emplace(plan, *decided, sink);
  }

  // Of one frame.
  void write_mesh(size_t track, size_t frame, MeshFrame &mesh) {
    const MeshTrack &of = plan.meshes[track];
    MeshSums &of_track = sums.meshes[track];
    writer->mesh(of, frame, mesh.payload, mesh.key);
    of_track.mesh.add(mesh.payload.size());
    if (!mesh.key) of_track.delta.add(mesh.payload.size());
    if (mesh.patched) of_track.patched.add(mesh.payload.size());
    of_track.faces += mesh.faces;
    mux::add(of_track.changes, mesh.source, mesh.report);
    if (plan.options.verify)
      sums.origins[track].push_back({std::move(mesh.origins), mesh.report.flipped_faces});
    const int64_t number = plan.capture.frames.number(int64_t(frame));
    if (warn_of_quantisation(plan, of, number, mesh.loss)) sums.warned = true;
    if (!mesh.decimation) return;
    mux::add(of_track.decimation, *mesh.decimation, plan.group_of(frame));
    if (of.rung) return; // more is lost there: one warning for all frames
    const std::string name = plan.capture.mesh_path(number) + ": frame " + std::to_string(number);
    const decimate::Lost vanished = seen_loss(plan, mesh.decimation->vanished, 1);
    if (warn_of_losses(plan, name, 1, vanished, mesh.decimation->thin_area)) sums.warned = true;
  }

  void write_surfaces(size_t track, size_t frame, const VisibilityFrame &seen, const ColourFrame &colours) {
    const MeshTrack &of = plan.meshes[track];
    MeshSums &of_track = sums.meshes[track];
    if (decided->visibility.on) {
      if (!seen.payload.empty()) writer->visibility(of, frame, seen.payload, seen.key);
      mux::add(of_track.visibility, seen);
    }
    if (plan.colours.on) {
      if (!colours.payload.empty()) writer->colours(of, frame, colours.payload);
      mux::add(of_track.colours, colours);
      if (!of.rung && plan.colours.of_vertices && warn_of_colours(plan, frame, colours)) sums.warned = true;
    }
  }

  void write(size_t index) {
    Group group = std::move(groups[index]);
    groups[index] = {};
    const size_t first = plan.first_of(index), count = plan.frames_of(index);
    const std::vector<SoundChunk> sounds = sound_chunks(plan, plan.groups[index]);
    auto sound = sounds.begin();
    const std::vector<DataChunk> datas = data_chunks(plan, index);
    auto data = datas.begin();
    const auto write_others_before = [&](int64_t tick) { // sound first, of one time
      while ((sound != sounds.end() && sound->time < tick) || (data != datas.end() && data->time < tick))
        if (sound != sounds.end() && (data == datas.end() || sound->time <= data->time))
          writer->sound(*sound++);
        else
          writer->data(*data++);
    };
    if (index != first_written && plan.options.repeat_configuration) writer->repeat_configuration();
    writer->begin_group(index);
    for (size_t i = 0; i < count; i++) {
      write_others_before(plan.tick_of(first + i));        // those of a frame after its pictures
      bool own_layout = false;                             // of any track
      size_t written = SIZE_MAX;                           // mesh track
      for (size_t rung = plan.rung_count(); rung-- > 0;) { // a low rung ends before the better ones begin
        const size_t k = plan.has_meshes() ? decided->mesh_of(plan, rung) : SIZE_MAX;
        const bool next = k != written;
        if (next && plan.has_mesh(first + i))
          write_mesh(k, first + i, group.meshes[k].frames[i]);
        else if (next && plan.options.verify)
          sums.origins[k].emplace_back();
        if (rung + 1 == plan.rung_count())
          if (const uint64_t calibration = writer->calibration(first + i, i == 0))
            sums.calibration.add(calibration);
        if (next) {
          const SurfaceFrames &surfaces_of = group.meshes[k].surfaces;
          write_surfaces(k, first + i, surfaces_of.visibility[i], surfaces_of.colours[i]);
        }
        written = k;
        for (size_t track = 0; track < plan.tracks.size(); track++) {
          if (plan.tracks[track].rung != rung) continue;
          if (i == 0) own_layout = writer->layout(plan.tracks[track], index) || own_layout;
          const media::Sample &sample = group.videos[track].samples[i];
          writer->sample(plan.tracks[track], first + i, sample);
          sums.videos[track].add(sample.bytes.size());
        }
      }
      sums.layouts += own_layout;
      // Behind the second frame: the first is known to be whole by then (fvv.md clause 18.5).
      const bool first_or_repeated = !index || plan.options.repeat_configuration;
      if (plan.environment && first_or_repeated && i == std::min<size_t>(1, count - 1))
        sums.environment.add(writer->environment(first + i));
    }
    write_others_before(plan.groups[index].end);
    writer->end_group();
    for (const MeshTrack &track : plan.meshes)
      if (!plan.options.verify || !decided->meshes[size_t(&track - plan.meshes.data())].sent)
        track.loader->forget(index);
    const media::VideoCodec &codec = *media::find_video_codec(plan.options.codec);
    for (size_t track = 0; track < plan.tracks.size(); track++)
      if (!plan.tracks[track].encoded)
        mux::add(sums.rates[track], codec, group.videos[track].quality, group.videos[track].over_rate);
  }

  const Plan &plan;
  const Sink &sink;
  StreamSums sums;
  SurfaceCoder surfaces;
  EncoderRoom room;
  size_t first_written = 0;           // group; the configuration is before it anyway
  std::optional<Decisions> decided;   // by the first group
  std::optional<StreamWriter> writer; // likewise
  std::vector<Task> tasks;
  std::vector<size_t> group_of;
  std::mutex mutex; // of groups
  std::vector<Group> groups;
  std::vector<std::promise<VideoChoice>> promises; // of each video track
  std::vector<std::shared_future<VideoChoice>> chosen_videos;
  std::deque<std::atomic<bool>> unwanted; // mesh tracks of which no more is encoded
};

EncodeJob::EncodeJob(const Plan &plan, const Sink &sink) : state(std::make_unique<State>(plan, sink)) {}

EncodeJob::EncodeJob(const Plan &plan, const Sink &sink, const Decisions &decisions, size_t group)
    : EncodeJob(plan, sink) {
  state->join(decisions, group);
}

EncodeJob::~EncodeJob() = default;

void EncodeJob::run() {
  state->run();
}

void EncodeJob::run_group(size_t group) {
  state->run_group(group);
}

const Decisions &EncodeJob::decisions() const {
  return state->decisions();
}

const StreamSums &EncodeJob::sums() const {
  return state->all_sums();
}

Report EncodeJob::finish(std::chrono::steady_clock::time_point start) {
  return state->finish(start);
}

} // namespace fvv::mux
