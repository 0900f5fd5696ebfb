#include "mux/src/planner.h"
#include "fvv/mesh.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/owned.h"
#include "fvv_cxx/parallel.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/inputs.h"
#include "mux/src/choose/choices.h"
#include "mux/src/choose/sampled_scene.h"
#include "mux/src/choose/view_loss.h"
#include "mux/src/crop.h"
#include "mux/src/data/data_tracks.h"
#include "mux/src/environment.h"
#include "mux/src/ladder/mesh_rungs.h"
#include "mux/src/ladder/view_rungs.h"
#include "mux/src/layout.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/options/option_values.h"
#include "mux/src/pictures.h"
#include "mux/src/sound/sound.h"
#include "mux/src/stream_writer.h"
#include "mux/src/visibility.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>

namespace fvv::mux {

namespace {

// A camera of a stream has one lens model (fvv.md clause 9.4).
bool changes_lens(const scene::Camera &camera) {
  return std::any_of(camera.per_frame.begin(), camera.per_frame.end(),
                     [&](const auto &entry) { return entry.second.lens != camera.calibration.lens; });
}

bool leave_out_changing(scene::Capture &capture, const Observer &observer) {
  std::string names;
  for (const scene::Camera &camera : capture.cameras)
    if (changes_lens(camera)) names += (names.empty() ? "" : ", ") + scene::describe(camera);
  if (names.empty()) return false;
  observer.warn(capture.path + ": left out, because their lens models change from frame to frame: " + names);
  std::vector<scene::Camera> &cameras = capture.cameras;
  cameras.erase(std::remove_if(cameras.begin(), cameras.end(), changes_lens), cameras.end());
  return true;
}

} // namespace

bool select(scene::Capture &capture, const Options &options, const Observer &observer) {
  if (options.frames) scene::restrict_frames(capture, *options.frames);
  scene::restrict_cameras(capture, options.cameras);
  const bool left_out = leave_out_changing(capture, observer);
  if (!options.meshes) capture.meshes.reset();
  if (!options.meshes || !options.pictures) capture.atlas.reset();
  if (!options.environment) capture.environment.reset();
  if (!options.sound) capture.sounds.clear();
  bool pictures = false;
  for (scene::Camera &camera : capture.cameras) {
    if (!options.pictures || !camera.texture) {
      camera.pictures.reset();
      camera.masks.reset();
    }
    pictures = pictures || camera.pictures;
    const bool fills = options.tile_fill == TileFill::flat || options.tile_fill == TileFill::smooth;
    if (fills && camera.pictures && !camera.masks)
      throw Error(option_name("tile-fill", options.tile_fill == TileFill::flat ? "flat" : "smooth") + ": " +
                      scene::describe(camera) + " has no masks",
                  Error::usage);
  }
  if (!pictures && !capture.meshes)
    throw Error(capture.path + ": nothing is left to write" +
                    (!options.meshes && !options.pictures ? " without meshes and pictures"
                     : !options.meshes                    ? " without meshes"
                     : !options.pictures                  ? " without pictures"
                                                          : ""),
                Error::usage);
  std::sort(capture.cameras.begin(), capture.cameras.end(),
            [](const auto &a, const auto &b) { return a.calibration.id < b.calibration.id; });
  return left_out;
}

namespace {

// Frames without a mesh are frames where there are pictures; else nothing is left of them.
void leave_out_empty(scene::Capture &capture) {
  if (!capture.meshes || capture.empty.empty()) return;
  if (capture.mesh_frames().empty())
    throw Error(capture.path + ": no frame has a mesh (" + option_name("no-meshes") +
                " sends pictures alone)");
  const bool shows = capture.memory || capture.atlas ||
                     std::any_of(capture.cameras.begin(), capture.cameras.end(),
                                 [](const scene::Camera &camera) { return camera.pictures.has_value(); });
  if (!shows) capture.frames.leave_out(capture.empty);
}

// Reads everything that a frame has, from its files on each call. Throws Error.
void read_frame(const Plan &plan, int64_t number) {
  const scene::Capture &capture = plan.capture;
  if (capture.has_mesh(number)) geometry::check(frame_mesh(plan.capture, number), capture.mesh_path(number));
  const auto check = [](const auto &image, const fvv_camera &camera, const std::string &path) {
    if (image.width != camera.width || image.height != camera.height)
      throw Error(path + ": expected " + std::to_string(camera.width) + " x " +
                  std::to_string(camera.height) + " pixels, found " + std::to_string(image.width) + " x " +
                  std::to_string(image.height));
  };
  media::with_sample_type(plan.options.codec, plan.options.bit_depth, [&](auto sample) {
    using Sample = decltype(sample);
    for (const scene::Camera &camera : capture.cameras) {
      if (camera.pictures)
        check(plan.videos->read<Sample>(capture, *camera.pictures, number, 3), camera.calibration,
              capture.picture_path(camera, number));
      if (camera.masks)
        check(plan.videos->read(capture, *camera.masks, number, 1), camera.calibration,
              capture.mask_path(camera, number));
    }
    if (capture.atlas) load_atlas<Sample>(plan, number);
    return 0;
  });
}

// Brings the mesh of frame i onto the lattice of the plan. Throws Error.
void place_frame(const Plan &plan, size_t i) {
  if (!plan.has_mesh(i)) return;
  const int64_t number = plan.capture.frames.number(int64_t(i));
  PreparedMesh source;
  source.mesh = frame_mesh(plan.capture, number, nullptr, plan.normals.bits != 0);
  check_normals(plan, i, source.mesh);
  OwnedMesh holder;
  fvv_mesh_report unused = {};
  canonicalise(plan, i, source, holder, unused);
}

// The frames for which work throws Error.
std::vector<BadFrame> failing(const Plan &plan, const std::function<void(size_t)> &work) {
  std::vector<BadFrame> bad;
  std::mutex mutex;
  fvv::parallel(plan.options.threads, plan.frame_count(), [&](size_t i) {
    plan.observer.check_cancelled();
    try {
      work(i);
    } catch (const Error &error) {
      const auto *known = dynamic_cast<const FrameError *>(&error);
      const std::lock_guard<std::mutex> lock(mutex);
      bad.push_back({plan.capture.frames.number(int64_t(i)), known ? known->reason : error.line()});
    }
  });
  std::sort(bad.begin(), bad.end(), [](const auto &a, const auto &b) { return a.number < b.number; });
  return bad;
}

// Error if nothing is left.
void leave_out(Plan &plan, const std::vector<BadFrame> &bad) {
  if (bad.empty()) return;
  std::set<int64_t> numbers;
  for (const BadFrame &frame : bad) numbers.insert(frame.number);
  plan.capture.frames.leave_out(numbers);
  if (!plan.frame_count() || (plan.has_meshes() && plan.capture.mesh_frames().empty()))
    throw Error(plan.capture.path + ": " + option_name("skip-bad-frames") + " leaves nothing; frame " +
                std::to_string(bad[0].number) + ": " + bad[0].reason);
}

// True when there was a warning.
bool look_at_files(Plan &plan, bool sub_range) {
  const scene::Capture &capture = plan.capture;
  const scene::Findings findings = scene::check_files(
      capture,
      [&](const std::string &path) {
        media::check_image_memory(path, capture.memory_limit);
        const media::ImageInfo info = media::probe_image(path);
        return scene::PictureSize{info.width, info.height, info.orientation};
      },
      [&](const std::string &path, std::optional<uint32_t> stream) {
        return plan.videos->facts(path, stream);
      });
  plan.sources = findings.videos;
  if (!findings.problems.empty()) {
    std::string lines;
    for (const std::string &problem : findings.problems)
      lines += (lines.empty() ? "" : "\n") + capture.path + ": " + problem;
    if (findings.of_frames) lines += "\n" + capture.path + ": " + skip_advice();
    if (findings.missing_meshes)
      lines += "\n" + capture.path + ": \"meshes\": {\"empty\": ...} says at which frames the stage is empty";
    throw Error(lines);
  }
  std::vector<std::string> warnings = findings.warnings;
  // With a sub-range, unused frames are intended.
  if (!sub_range) warnings.insert(warnings.end(), findings.unused.begin(), findings.unused.end());
  for (const std::string &warning : warnings) plan.observer.warn(capture.path + ": " + warning);
  return !warnings.empty();
}

uint32_t frames_per_second(const fvv_rational &duration) {
  const double rate = double(duration.denominator) / duration.numerator;
  return uint32_t(std::clamp(std::round(rate), 1.0, 1000.0));
}

// An atlas cannot be divided over tracks as cameras can. Some decoders support more than they have to, so it
// is sent.
bool warn_of_atlas(const Plan &plan, const Tiling &tiling) {
  const FrameLimit limit = decoder_limit(plan.options, plan.capture.frame_duration);
  if (fits(tiling.width, tiling.height, limit)) return false;
  const fvv_rect &whole = tiling.tiles[0].source;
  int percent = 99;
  while (percent && !fits(scaled(whole.width, percent / 100.0), scaled(whole.height, percent / 100.0), limit))
    percent--;
  const std::string advice =
      percent ? " (" + option_name("atlas-scale", fvv::format("%g", percent / 100.0)) + " keeps it)"
              : std::string();
  plan.observer.warn(plan.capture.path + ": the atlas is sent with " + std::to_string(tiling.width) + "x" +
                     std::to_string(tiling.height) + " pixels, and not all players can show more than " +
                     limit_text(limit) + advice);
  return true;
}

// As many tracks as there are, with the cameras that their tiles name.
std::vector<VideoTrack> encoded_tracks(const scene::Capture &capture,
                                       const std::vector<EncodedTrack> &encoded) {
  std::vector<VideoTrack> tracks;
  for (const EncodedTrack &one : encoded) {
    VideoTrack track = {FVV_SHOWS_TILES, {{}, one.tiles, one.config.width, one.config.height}, {}};
    for (const fvv_tile &tile : one.tiles)
      for (size_t i = 0; i < capture.cameras.size(); i++)
        if (capture.cameras[i].calibration.id == tile.camera_id) track.tiling.cameras.push_back(i);
    track.encoded = std::make_shared<const EncodedTrack>(one);
    track.sample = tracks.size();
    tracks.push_back(std::move(track));
  }
  return tracks;
}

// The error that geometry may have, lattice, decimation, and the meshes of the first rung.
void plan_meshes(Plan &plan, const SampledScene &scene, const Tiling &cameras, double delta_frames) {
  const Options &options = plan.options;
  plan.error = choose_budget(options, scene);
  look_for_hulls(plan, scene, cameras);
  plan.lattice = choose_lattice(options, scene, plan.error, plan.has_constant_topology, delta_frames);
  plan.meshes.clear();
  if (!plan.has_meshes()) return;
  MeshTrack track;
  track.lattice = plan.lattice;
  track.decimation = choose_decimation(options, scene, plan.error, plan.lattice, plan.normals);
  if (plan.tracking.on && !track.decimation.on)
    plan.tracking = {false, "meshes are not decimated: " + track.decimation.reason};
  track.loader = std::make_shared<MeshLoader>(plan, track.decimation, cameras);
  track.id = mesh_track;
  track.visibility = visibility_track;
  track.colours = colour_track;
  plan.meshes.push_back(std::move(track));
}

// What was chosen is as if options had set it.
void apply_view_choice(Plan &plan, const SampledScene &scene, const Tiling &cameras, double delta_frames) {
  const ViewReport &view = plan.view.report;
  Options &options = plan.options;
  if (options.quality.by_default) options.quality = {true, view.psnr};
  fvv_texturing usual;
  fvv_texturing_default(&usual);
  const fvv_texturing &chosen = plan.view.texturing;
  if (chosen.threshold != fvv_texturing_threshold(chosen.blend)) options.texture_threshold = chosen.threshold;
  if (chosen.best != usual.best) options.texture_best = chosen.best;
  const double error = plan.error.value, step = plan.lattice.lattice.step;
  if (view.max_error == error && view.step == step) return;
  if (view.max_error != error) options.max_error = {view.max_error, MaxError::pixels};
  plan_meshes(plan, scene, cameras, delta_frames);
  if (view.step == plan.lattice.lattice.step) return;
  options.step = {view.step, !plan.capture.scale_unknown};
  plan_meshes(plan, scene, cameras, delta_frames);
  plan.lattice.reason = "as views between the cameras allow";
}

// bad: frames that are known to be unusable.
Plan plan_frames(scene::Capture given, const std::vector<BadFrame> &bad,
                 const std::vector<EncodedTrack> &encoded, const Options &options, const Observer &observer) {
  Plan plan;
  check_ladder(options);
  check_view_rungs(options);
  plan.observer = observer;
  plan.options = options;
  if (!options.ladder.empty() && options.ladder[0].bit_rate)
    plan.options.bit_rate = options.ladder[0].bit_rate;
  if (!options.ladder.empty() && options.ladder[0].psnr)
    plan.options.quality = {true, options.ladder[0].psnr};
  plan.videos = std::make_shared<scene::Videos>(options.threads, given.memory_limit);
  plan.capture = std::move(given);
  if (options.track != Track::never && !plan.capture.memory)
    plan.outline_cameras = outline_cameras(plan.capture.cameras, {});
  plan.warned = select(plan.capture, options, plan.observer);
  scene::find_empty_meshes(plan.capture);
  plan.bad = bad;
  leave_out(plan, bad);
  if (options.skip_bad_frames && bad.empty()) {
    plan.bad = failing(plan, [&](size_t i) { read_frame(plan, plan.capture.frames.number(int64_t(i))); });
    leave_out(plan, plan.bad);
  }
  leave_out_empty(plan.capture);
  plan.data = load_data(plan);
  if (!plan.capture.memory) plan.warned = look_at_files(plan, options.frames.has_value()) || plan.warned;
  plan.group_size = group_size_of(options, plan.capture.frame_duration);
  plan.groups = groups_of(plan.capture, plan.group_size);
  if (options.undistort)
    plan.undistortion = std::make_shared<scene::Undistortion>(plan.capture, options.undistort_alpha);
  std::vector<SampledMesh> sampled = sample_meshes(plan.capture);
  if (plan.has_meshes()) {
    plan.winding = choose_winding(options, plan.capture, sampled);
    plan.capture.flip_faces = plan.winding.flip;
    // Faces of a mesh that does not fit the cameras show their backs by chance.
    plan.warned = warn_of_coordinates(plan, sampled) || warn_of_winding(plan) || plan.warned;
    plan.warned = warn_of_blind_cameras(plan, sampled) || plan.warned;
  }
  plan.warned = warn_of_masks(plan, sampled) || plan.warned;
  Tiling cameras = whole_pictures(plan.capture, options);
  if (!cameras.tiles.empty()) plan.crop = choose_crop(plan, cameras);
  if (plan.capture.memory) leave_room(plan, cameras);
  plan.frame_limit = frame_limit(options, plan.capture.frame_duration);
  bound(plan, cameras);
  plan.whole = cameras;
  const std::vector<VideoTrack> sent = encoded_tracks(plan.capture, encoded);
  for (const VideoTrack &track : sent) {
    const auto append = [](auto &to, const auto &from) { to.insert(to.end(), from.begin(), from.end()); };
    append(cameras.cameras, track.tiling.cameras);
    append(cameras.tiles, track.tiling.tiles);
  }
  const SampledScene scene(plan.capture, std::move(sampled), cameras);
  const double shared = options.delta && plan.has_meshes() ? scene.constant_topology_fraction() : 0;
  plan.first_view = choose_first_view(plan, scene);
  plan.normals = choose_normals(options, scene);
  plan.tracking = choose_tracking(options, scene, plan.normals, shared);
  plan.has_constant_topology = shared > 0 || plan.tracking.on;
  // How long runs of tracked frames become is not known here; a finer lattice must not cost keys bytes
  // where nothing can be followed.
  const double followed = plan.tracking.on && options.track == Track::always ? 0.5 : 0,
               in_runs = std::max(shared, followed),
               delta_frames = std::min(in_runs / (1 - in_runs), plan.group_size - 1.0);
  plan_meshes(plan, scene, cameras, delta_frames);
  plan.match = choose_match(plan, scene, !encoded.empty());
  if (plan.match.on) plan.match.tables = gain_tables(plan.match, plan.capture.cameras.size());
  plan.inset = choose_inset(plan, scene, !encoded.empty());
  plan.tracks = tile_tracks(plan, plan.whole);
  for (const VideoTrack &track : sent) {
    plan.tracks.push_back(track);
    plan.tracks.back().part = plan.tracks.size() - 1;
  }
  plan.view = choose_by_view_loss(plan, scene, cameras, delta_frames);
  if (plan.view.on()) apply_view_choice(plan, scene, cameras, delta_frames);
  if (options.ladder_by_views) {
    plan.options.ladder_by_views = false;
    plan.options.ladder =
        plan.view.ladder.empty() ? usual_rungs(plan.options.quality.value) : plan.view.ladder;
    plan.options.quality = {true, plan.options.ladder[0].psnr};
  }
  plan.warned = warn_of_lattice(plan) || plan.warned;
  plan.warned = warn_of_tracking(plan) || plan.warned;
  plan.visibility = choose_visibility(plan.options, plan.capture, cameras);
  plan.visibility.by_views = plan.view.on();
  plan.colours = choose_colours(plan, scene);
  if (plan.capture.atlas) {
    const scene::AtlasSize size = find_atlas_size(plan);
    plan.tracks.push_back({FVV_SHOWS_ATLAS, arrange_atlas(plan, 0, size.width, size.height), {}});
    plan.warned = warn_of_atlas(plan, plan.tracks.back().tiling) || plan.warned;
    fvv_mesh_options defaults;
    fvv_mesh_options_default(&defaults);
    plan.texture_bits = options.texture_bits
                            ? options.texture_bits
                            : plan.capture.atlas->texture_bits.value_or(defaults.texture_bits);
  }
  plan.objects = find_objects(plan);
  add_rungs(plan);
  add_mesh_rungs(plan, scene, cameras);
  if (plan.capture.environment) {
    plan.environment = pack_environment(plan.capture);
    for (const std::string &warning : plan.environment->warnings) plan.observer.warn(warning);
    plan.warned = plan.warned || !plan.environment->warnings.empty();
  }
  plan.warned = load_sounds(plan) || plan.warned;
  return plan;
}

} // namespace

Plan make_plan(const Options &options, const Observer &observer) {
  scene::Capture capture = scene::load_capture(options.capture, options.inputs, memory_limit_of(options));
  capture.mesh_cache = scene::make_mesh_cache();
  return make_plan(std::move(capture), {}, options, observer);
}

Plan make_plan(scene::Capture capture, const std::vector<EncodedTrack> &encoded, const Options &given,
               const Observer &observer) {
  Options options = given;
  fill_in(options);
  if (!options.skip_bad_frames || capture.memory)
    return plan_frames(std::move(capture), {}, encoded, options, observer);
  // Whether a mesh fits the lattice is known when that is chosen: without such a frame the plan is another
  // one.
  std::vector<std::string> warnings;
  Observer quiet = observer;
  quiet.on_warning = [&](const std::string &text) { warnings.push_back(text); };
  Plan plan = plan_frames(capture, {}, encoded, options, quiet);
  for (std::vector<BadFrame> bad; plan.has_meshes();) {
    bad = failing(plan, [&](size_t i) { place_frame(plan, i); });
    if (bad.empty()) break;
    bad.insert(bad.end(), plan.bad.begin(), plan.bad.end());
    std::sort(bad.begin(), bad.end(), [](const auto &a, const auto &b) { return a.number < b.number; });
    warnings.clear();
    plan = plan_frames(capture, bad, encoded, options, quiet);
  }
  plan.observer = observer;
  for (const std::string &text : warnings) observer.warn(text);
  for (const BadFrame &frame : plan.bad)
    observer.warn(plan.capture.path + ": frame " + std::to_string(frame.number) +
                  " is left out: " + frame.reason);
  plan.warned = plan.warned || !plan.bad.empty();
  return plan;
}
std::vector<GroupSpan> groups_of(const scene::Capture &capture, uint32_t group_size) {
  std::vector<GroupSpan> groups;
  const scene::Frames &frames = capture.frames;
  auto left_out = frames.left_out.begin();
  int64_t emptied = -1, last = -1; // where the stage became empty since the last frame; place of that
  bool had_mesh = false;
  for (int64_t place = 0; place < frames.places(); place++) {
    const bool is_empty = capture.meshes && !capture.has_mesh(frames.number_at(place));
    if (is_empty && had_mesh) {
      emptied = place;
      had_mesh = false;
    }
    if (left_out != frames.left_out.end() && *left_out == place) {
      ++left_out;
      continue;
    }
    if (groups.empty() || emptied >= 0 || place / group_size != last / group_size) {
      const int64_t start = groups.empty() ? 0 : emptied >= 0 ? emptied : place;
      const size_t first = groups.empty() ? 0 : groups.back().first + groups.back().count;
      if (!groups.empty()) groups.back().end = start;
      groups.push_back({first, 0, start, start});
    }
    groups.back().count++;
    last = place;
    emptied = -1;
    had_mesh = !is_empty;
  }
  if (!groups.empty()) groups.back().end = emptied >= 0 ? emptied : frames.places();
  return groups;
}

uint32_t group_size_of(const Options &options, const fvv_rational &frame_duration) {
  return options.group ? options.group : frames_per_second(frame_duration);
}

void extend_plan(Plan &plan, const GroupSpan &group) {
  plan.capture.frames.count += int64_t(group.count);
  plan.groups.push_back(group);
  for (const MeshTrack &track : plan.meshes) track.loader->extend(plan);
  if (plan.crop.on) lay_out_group(plan, silhouettes(plan, plan.whole.cameras, plan.group_count() - 1));
}

Quality default_quality(uint32_t codec) {
  return codec == FVV_CODEC_OEXR ? Quality{false, 0} : Quality{};
}

} // namespace fvv::mux
