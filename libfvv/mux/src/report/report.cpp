// The report of a stream: what its plan, its decisions and the sums over its groups say, as plain values.
#include "fvv_mux/report.h"
#include "fvv_cxx/format.h"
#include "fvv_media/image.h"
#include "mux/src/choose/choices.h"
#include "mux/src/environment.h"
#include "mux/src/layout.h"
#include "mux/src/options/presets.h"
#include "mux/src/pictures.h"
#include "mux/src/sound/sound.h"
#include "mux/src/stream_writer.h"
#include "mux/src/sums.h"
#include "mux/src/terms.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

void TrackBytes::add(uint64_t bytes) {
  chunks++;
  payload += bytes;
  smallest = std::min(smallest, bytes);
  largest = std::max(largest, bytes);
}

double ColourSums::psnr() const {
  return squares > 0 ? 10 * std::log10(255 * 255 * 3 * double(shown) / squares) : INFINITY;
}

double DecimationSums::rms() const {
  return measured ? std::sqrt(squares / double(measured)) : 0;
}

double DecimationSums::volume_change() const {
  return volume_before != 0 ? volume_after / volume_before - 1 : 0;
}

void MeshVerdict::add(const MeshVerdict &other) {
  max_vertex_error = std::max(max_vertex_error, other.max_vertex_error);
  max_texture_error = std::max(max_texture_error, other.max_texture_error);
  max_normal_error = std::max(max_normal_error, other.max_normal_error);
}

void MeshTrackVerdict::add(const MeshTrackVerdict &other) {
  meshes += other.meshes;
  visible += other.visible;
  mesh.add(other.mesh);
}

double VideoVerdict::psnr() const {
  return media::LumaError{squares, pixels}.psnr();
}

void VideoVerdict::add(const VideoVerdict &other) {
  pictures += other.pictures;
  squares += other.squares;
  pixels += other.pixels;
  min_psnr = std::min(min_psnr, other.min_psnr);
}

size_t Report::mesh_of(size_t rung) const {
  size_t k = lower_meshes.size();
  while (k && (!lower_meshes[k - 1].sent || lower_meshes[k - 1].rung > rung)) k--;
  return k;
}

size_t Report::tile_track_count() const {
  return size_t(std::count_if(videos.begin(), videos.end(),
                              [](const VideoTrackReport &video) { return !video.is_atlas && !video.rung; }));
}

void add(VisibilitySums &sums, const VisibilityFrame &frame) {
  if (frame.payload.empty()) return;
  const uint64_t size = frame.payload.size();
  sums.frames++;
  sums.keys += frame.key;
  sums.bytes += size;
  sums.smallest = std::min(sums.smallest, size);
  sums.largest = std::max(sums.largest, size);
  sums.pairs += uint64_t(frame.vertices) * frame.cameras.size();
  sums.cameras.insert(frame.cameras.begin(), frame.cameras.end());
}

void add(ColourSums &sums, const ColourFrame &frame) {
  if (frame.payload.empty()) return;
  sums.track.add(frame.payload.size());
  sums.cells += frame.cells;
  sums.shown += frame.shown;
  sums.vertices += frame.vertices;
  sums.squares += frame.squares;
}

void add(DecimationSums &sums, const decimate::Report &report, size_t group) {
  sums.frames++;
  sums.kept += report.kept;
  sums.measured += report.measured && !report.kept;
  sums.faces_before += report.faces_before;
  sums.faces_after += report.faces_after;
  sums.locked_faces += report.locked_faces;
  sums.squares += report.error.rms * report.error.rms;
  sums.max = std::max(sums.max, report.error.max);
  sums.max_pixels = std::max(sums.max_pixels, report.error.max_pixels);
  sums.rms_pixels = std::max(sums.rms_pixels, report.error.rms_pixels);
  sums.volume_before += report.volume_before;
  sums.volume_after += report.volume_after;
  sums.vanished_pieces += report.vanished.pieces;
  sums.vanished_area += report.vanished.area;
  sums.thin_area += report.thin_area;
  sums.by_outlines += report.by_outlines;
  if (sums.groups.empty() || sums.groups.back().group != group) sums.groups.push_back({group});
  GroupTriangles &here = sums.groups.back();
  here.frames++;
  here.faces += report.faces_after;
  here.locked_faces += report.locked_faces;
  here.kept += report.kept;
}

double DecimationSums::max_over_median(GroupTriangles *largest) const {
  if (groups.empty()) return 0;
  std::vector<GroupTriangles> sorted = groups;
  std::sort(sorted.begin(), sorted.end(), [](const auto &a, const auto &b) { return a.mean() < b.mean(); });
  if (largest) *largest = sorted.back();
  const double median = sorted[sorted.size() / 2].mean();
  return median > 0 ? sorted.back().mean() / median : 0;
}

void add(RateResult &rate, const media::VideoCodec &codec, double quality, bool is_over) {
  const auto finer = [&](double a, double b) { return codec.finest < codec.coarsest ? a < b : a > b; };
  if (!rate.groups || finer(quality, rate.finest)) rate.finest = quality;
  if (!rate.groups || finer(rate.coarsest, quality)) rate.coarsest = quality;
  rate.groups++;
  rate.over += is_over;
}

void add(MeshChanges &changes, const scene::MeshReport &source, const fvv_mesh_report &report) {
  changes.split_polygons.add(source.polygons);
  changes.self_crossing.add(source.self_crossing);
  changes.left_out.add(source.lines_and_points);
  changes.untextured.add(source.untextured);
  changes.welded.add(report.welded_vertices);
  changes.degenerate.add(report.degenerate_faces);
  changes.duplicate.add(report.duplicate_faces);
  changes.unreferenced.add(report.unreferenced_vertices);
  changes.flipped.add(report.flipped_faces);
  changes.dropped_components.add(report.dropped_components);
  changes.dropped_faces.add(report.dropped_component_faces);
  changes.nonmanifold_edges.add(report.nonmanifold_edges);
  changes.boundary_edges.add(report.boundary_edges);
  changes.changed_frames += source.polygons || source.lines_and_points || report.welded_vertices ||
                            report.degenerate_faces || report.duplicate_faces ||
                            report.unreferenced_vertices || report.flipped_faces || report.dropped_components;
  changes.max_error = std::max(changes.max_error, report.max_error);
}

namespace {

// Frames of the capture at which the stage is empty, also where they are no frames of the stream.
size_t empty_frames(const scene::Capture &capture) {
  const scene::Frames &frames = capture.frames;
  size_t count = 0;
  for (const int64_t number : capture.empty) {
    const int64_t place = (number - frames.first) / frames.step;
    count += number >= frames.first && place < frames.places();
  }
  return count;
}

const char *fill_text(const Plan &plan) {
  const auto &cameras = plan.capture.cameras;
  const bool masks = std::any_of(cameras.begin(), cameras.end(), [](const auto &c) { return bool(c.masks); });
  if (!masks) return "keep";
  const TileFill fill = tile_fill_of(plan.options);
  return fill == TileFill::flat ? "flat" : fill == TileFill::smooth ? "smooth" : "keep";
}

bool in_pixels(const DecimationChoice &choice) {
  return std::isfinite(choice.pixel) && !choice.is_length;
}

void report_meshes(Report &out, const Plan &plan, const Decisions &decisions, const StreamSums &sums) {
  const LatticeChoice &lattice = plan.lattice;
  std::copy_n(lattice.lattice.origin, 3, out.lattice.origin);
  out.lattice.step = lattice.lattice.step;
  out.lattice.reason = lattice.reason;
  out.lattice.pixels = lattice.pixels;
  out.lattice.delta_error = lattice.delta_error;
  out.normals = {plan.normals.bits, plan.normals.reason};
  if (!plan.tracking.reason.empty()) out.tracking = TrackingReport{plan.tracking.on, plan.tracking.reason};
  out.texture_bits = plan.texture_bits;
  out.has_constant_topology = plan.has_constant_topology;
  out.shares_meshes = plan.shares_meshes;
  out.mesh_profile = plan.options.mesh_profile;
  out.mesh_level = *plan.options.mesh_level;
  if (!plan.has_meshes()) return;
  out.has_meshes = true;
  out.empty_frames = empty_frames(plan.capture);
  out.winding = {plan.winding.flip, plan.winding.by_cameras, plan.winding.in_stream()};
  const DecimationChoice &choice = plan.meshes[0].decimation;
  out.budget = {plan.error.value, choice.budget.most_over_rms() * plan.error.value,
                choice.is_length, choice.pixel,
                choice.on,        choice.reason};
  out.mesh_track = plan.meshes[0].id;
  static_cast<MeshSums &>(out) = sums.meshes[0];
  for (size_t k = 1; k < plan.meshes.size(); k++) {
    const MeshTrack &track = plan.meshes[k];
    LowerMeshes lower;
    static_cast<MeshSums &>(lower) = sums.meshes[k];
    lower.rung = track.rung;
    lower.track = track.id;
    lower.max_error = plan.error.value * track.times;
    lower.in_pixels = in_pixels(track.decimation);
    lower.sent = decisions.meshes[k].sent;
    lower.saving = decisions.meshes[k].saving;
    out.lower_meshes.push_back(std::move(lower));
  }
}

VideoTrackReport report_video(const Plan &plan, const Decisions &decisions, const StreamSums &sums,
                              size_t index) {
  const VideoTrack &track = plan.tracks[index];
  const VideoDecision &decision = decisions.videos[index];
  const media::VideoSettings &settings = decision.settings;
  const fvv_rational &duration = plan.capture.frame_duration;
  VideoTrackReport out;
  static_cast<TrackBytes &>(out) = sums.videos[index];
  out.track = track.id;
  out.alternate_group = track.alternate_group;
  out.rung = track.rung;
  out.part = track.part;
  out.is_atlas = track.is_atlas();
  out.is_encoded = track.encoded != nullptr;
  out.codec = settings.codec;
  out.bit_depth = settings.bit_depth;
  out.width = track.tiling.width;
  out.height = track.tiling.height;
  if (!out.is_atlas)
    for (const fvv_tile &tile : track.tiling.tiles) out.cameras.push_back(tile.camera_id);
  out.quality = settings.quality + settings.parts;
  out.sample_frames = decision.sample_frames;
  out.sample_psnr = decision.sample_psnr;
  out.sample_rate = decision.sample_rate;
  out.sample_foreground = decision.masks;
  out.target_rate = settings.bit_rate;
  out.bit_rate = double(out.payload) * 8 * duration.denominator / duration.numerator / double(plan.end());
  out.rate = sums.rates[index];
  out.pixel_share = double(out.width) * out.height / double(plan.crop.whole_pixels);
  return out;
}

MatchReport report_match(const Plan &plan) {
  const MatchChoice &match = plan.match;
  MatchReport out = {match.on, match.reason, match.frames, match.found.before, match.found.after, {}};
  for (size_t i = 0; i < match.found.cameras.size(); i++) {
    const render::CameraMatch &found = match.found.cameras[i];
    CameraGains gains = {
        plan.capture.cameras[match.cameras[i]].calibration.id, found.matched, {}, found.places};
    std::copy_n(std::begin(found.gain), 3, gains.gains.begin());
    out.cameras.push_back(gains);
  }
  return out;
}

InsetReport report_inset(const InsetChoice &inset) {
  const render::TextureInset &found = inset.found;
  return {inset.inset,
          inset.reason,
          inset.frame,
          found.pixels,
          found.views,
          found.better,
          found.pixels >= render::least_compared,
          found.before,
          found.after};
}

SoundReport report_sound(const Plan &plan, const StreamSums &sums, size_t index) {
  const SoundTrack &sound = plan.sounds[index];
  const SoundSpan span = span_of(plan, sound);
  SoundReport out;
  static_cast<TrackBytes &>(out) = sums.sounds[index];
  out.track = sound_track_id(index);
  out.file = sound.source.file;
  out.title = sound.source.title;
  out.language = sound.source.language;
  out.encoded = sound.packets.encoded;
  out.codec = sound_codec_text(sound);
  out.rate = sound.packets.format.rate;
  out.channels = sound.packets.format.channels;
  out.bit_rate = bit_rate_of(sound);
  out.start = span.start;
  out.end = span.end;
  out.placed = sound.source.is_placed();
  out.moves = !sound.source.per_frame.empty();
  return out;
}

EnvironmentReport report_environment(const PackedEnvironment &packed, uint64_t chunks) {
  EnvironmentReport out;
  out.chunks = chunks;
  out.bytes = packed.payload.size();
  out.parts = packed.parts;
  out.pictures = packed.pictures;
  out.lights = packed.lights;
  out.vertices = packed.vertices;
  out.triangles = packed.faces;
  out.mesh_bytes = packed.mesh_bytes;
  out.picture_bytes = packed.picture_bytes;
  std::copy_n(packed.lattice.origin, 3, out.origin);
  out.step = packed.lattice.step;
  out.reason = packed.reason;
  out.max_axis_error = packed.max_error;
  return out;
}

SourceReport report_source(const scene::VideoReport &video) {
  SourceReport out;
  out.camera = video.camera;
  out.masks = video.masks;
  out.file = video.file;
  out.pictures = video.pictures;
  out.rate = video.rate;
  out.constant_rate = video.constant_rate;
  out.frames = video.frames;
  out.met = video.met;
  out.largest_offset = video.largest_offset;
  out.mean_offset = video.mean_offset;
  for (const scene::FrameRange &range : video.unmet) out.unmet.push_back({range.first, range.last});
  out.used_again = video.used_again;
  out.before = video.before;
  out.between = video.between;
  out.behind = video.behind;
  if (video.better_start) out.better_start = {video.better_start->numerator, video.better_start->denominator};
  return out;
}

void report_lenses(Report &out, const Plan &plan) {
  if (plan.undistortion) {
    out.undistorted.emplace();
    for (const scene::Undistorted &one : plan.undistortion->report())
      out.undistorted->push_back({one.id, one.source_width, one.source_height, one.width, one.height,
                                  one.horizontal, one.vertical, one.kept, one.blank, one.finest,
                                  one.limited});
  }
  for (const scene::LensGap &gap : scene::lens_gaps(plan.capture))
    out.lens_gaps.push_back({gap.camera, gap.r_max, gap.share});
}

} // namespace

Report make_report(const Plan &plan, const Decisions &decisions, const StreamSums &sums) {
  const Options &options = plan.options;
  Report out;
  out.warned = plan.warned || sums.warned;
  out.bytes = sums.bytes;
  out.frames = plan.frame_count();
  out.groups = plan.group_count();
  out.group_size = plan.group_size;
  out.frame_duration = plan.capture.frame_duration;
  out.ticks = plan.end();
  out.scale_unknown = plan.capture.scale_unknown;
  out.live = options.live;
  out.skips_bad_frames = options.skip_bad_frames;
  out.preset = row_of(options.preset).name;
  for (const BadFrame &frame : plan.bad) out.left_out.push_back({frame.number, frame.reason});
  report_meshes(out, plan, decisions, sums);
  out.calibration = sums.calibration;
  out.environment_chunks = sums.environment;
  for (size_t i = 0; i < plan.tracks.size(); i++)
    out.videos.push_back(report_video(plan, decisions, sums, i));
  out.has_bit_rate = options.bit_rate != 0;
  if (!out.has_bit_rate && options.quality.is_psnr) out.target_psnr = options.quality.value;
  out.video_tracks = options.video_tracks;
  for (const Rung &rung : options.ladder) out.ladder.push_back(rung.scale);
  out.crop = {plan.crop.on, plan.crop.reason, plan.crop.by_masks,          plan.crop.by_mesh,
              sums.layouts, fill_text(plan),  limit_text(plan.frame_limit)};
  out.visibility_choice = {decisions.visibility.on, decisions.visibility.reason};
  out.colours_choice = {plan.colours.on, plan.colours.reason};
  out.colour_cell = plan.colours.cell_size * plan.lattice.lattice.step;
  out.match = report_match(plan);
  out.inset = report_inset(plan.inset);
  if (plan.view.report.goal > 0) out.view = plan.view.report;
  for (size_t i = 0; i < plan.sounds.size(); i++) out.sounds.push_back(report_sound(plan, sums, i));
  if (plan.environment) out.environment = report_environment(*plan.environment, sums.environment.chunks);
  for (const scene::VideoReport &video : plan.sources) out.sources.push_back(report_source(video));
  report_lenses(out, plan);
  return out;
}

} // namespace fvv::mux
