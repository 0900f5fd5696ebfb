// The report as text on one screen.
#include "fvv/mesh.h"
#include "fvv/video.h"
#include "fvv_cxx/format.h"
#include "fvv_geometry/decimate.h"
#include "fvv_media/video.h"
#include "fvv_mux/report.h"
#include "mux/src/choose/choices.h"
#include "mux/src/report/report_names.h"
#include "mux/src/stream_writer.h"
#include "mux/src/terms.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>

namespace fvv::mux {

namespace {

std::string budget_text(const Report &r, double value) {
  return r.budget.is_length ? length_text(r.scale_unknown, value) : fvv::format("%g px", value);
}

// More than this many times the triangles of the median group is worth a reason.
constexpr double uneven = 1.5;

std::string largest_group_text(const Report &r) {
  GroupTriangles largest = {};
  const double times = r.decimation.max_over_median(&largest);
  if (!(times > uneven)) return "";
  std::string out =
      fvv::format("            group %zu has %.0f triangles a frame, %.1f times as many as the median "
                  "group: ",
                  largest.group, largest.mean(), times);
  if (largest.kept) return out + "fewer would break the budget there\n";
  if (2 * largest.locked_faces > largest.faces)
    return out +
           fvv::format("%.0f stay, or places would be off by more than ",
                       double(largest.locked_faces) / double(largest.frames)) +
           budget_text(r, r.budget.most) + "\n";
  return out + "its shapes, or how they change, need them\n";
}

std::string decimation_text(const Report &r) {
  const DecimationSums &sums = r.decimation;
  const BudgetReport &budget = r.budget;
  std::string out = "  budget    " + budget_text(r, budget.max_error);
  const bool seen = budget.in_pixels();
  if (seen)
    out += (budget.max_error == 1 ? " is " : " are ") +
           length_text(r.scale_unknown, budget.max_error * budget.pixel) + " where cameras see sharpest";
  if (!budget.decimates) return out + "; all triangles are kept: " + budget.reason + "\n";
  const double frames = double(sums.frames);
  out += fvv::format(": %.0f -> %.0f triangles a frame ", double(sums.faces_before) / frames,
                     double(sums.faces_after) / frames) +
         budget.reason + "\n";
  if (const uint64_t changed = sums.frames - sums.kept; sums.measured < changed)
    out += fvv::format("            %llu of %llu frames were not measured, ",
                       (unsigned long long)(changed - sums.measured), (unsigned long long)changed) +
           "as " + option_name("preset", r.preset) + " has it: their error is not known\n";
  if (sums.measured) {
    out += "            off by " + length_text(r.scale_unknown, sums.rms()) + " rms, " +
           length_text(r.scale_unknown, sums.max) + " at most, lattice included; the worst frame";
    if (seen) out += fvv::format(" %.3f px rms, %.2f px at most;", sums.rms_pixels, sums.max_pixels);
    out += fvv::format(" volume %+.2f %%\n", 100 * sums.volume_change());
  }
  if (sums.locked_faces)
    out += fvv::format("            %.0f triangles a frame stay, or places would be off by more than ",
                       double(sums.locked_faces) / frames) +
           budget_text(r, budget.most) + "\n";
  out += largest_group_text(r);
  if (sums.kept)
    out += fvv::format("            %llu frames are as they were: fewer triangles would break the budget\n",
                       (unsigned long long)sums.kept);
  return out;
}

__attribute__((format(printf, 2, 3))) void line(std::string &out, const char *pattern, ...) {
  va_list arguments;
  va_start(arguments, pattern);
  out += fvv::format_list(pattern, arguments) + '\n';
  va_end(arguments);
}

void track_line(std::string &out, const Report &r, const char *label, uint64_t payload,
                const std::string &what) {
  line(out, "  %-10s%9.1f kB %5.1f %% %8.2f kB/frame  %s", label, double(payload) / 1000,
       100 * double(payload) / double(r.bytes), double(payload) / 1000 / double(r.frames), what.c_str());
}

std::string quality_text(const Report &r, const VideoTrackReport &video) {
  if (!r.has_bit_rate) return fvv::format("%g", video.quality);
  const RateResult &rate = video.rate;
  return rate.finest == rate.coarsest ? fvv::format("%g", rate.finest)
                                      : fvv::format("%g to %g", rate.finest, rate.coarsest);
}

std::string codec_choice(const Report &r, const VideoTrackReport &video) {
  const media::VideoCodec &codec = *media::find_video_codec(video.codec);
  return std::string(codec.name) + " " +
         (video.is_encoded               ? "encoded before"
          : codec.code == FVV_CODEC_OEXR ? "lossless"
                                         : codec.scale + (" " + quality_text(r, video))) +
         ", " + std::to_string(video.bit_depth) + " bits, " +
         (video.is_atlas ? "" : std::to_string(video.cameras.size()) + " tiles in ") +
         std::to_string(video.width) + "x" + std::to_string(video.height);
}

// Of all tracks that show cameras.
void crop_lines(std::string &out, const Report &r) {
  const CropReport &crop = r.crop;
  size_t tiles = 0;
  double share = 0;
  for (const VideoTrackReport &video : r.videos) {
    if (video.is_atlas || video.is_encoded || video.rung) continue;
    tiles += video.cameras.size();
    share += video.pixel_share;
  }
  if (!tiles) return;
  const size_t tracks = r.tile_track_count();
  line(out,
       "  tiles     %s%s: the frame%s %.1f %% of the pixels of %zu whole pictures; %zu of %zu groups have a "
       "layout of their own; fill: %s",
       crop.cropped ? "cropped " : "not cropped, ", crop.reason.c_str(),
       tracks > 1 ? "s together have" : " has", 100 * share, tiles, crop.layouts, r.groups,
       crop.fill.c_str());
  if (tracks <= 1) return;
  line(out, "            in %zu video tracks%s: at %.6g frames/s a frame may have %s", tracks,
       r.video_tracks > 1 ? (" (" + option_name("video-tracks") + ")").c_str() : "", frame_rate(r),
       crop.frame_limit.c_str());
}

void video_lines(std::string &out, const Report &r, const VideoTrackReport &video) {
  if (video.is_encoded) return;
  std::string wish;
  if (r.has_bit_rate)
    line(out, "  rate      %.1f kbit/s of the %s (target %.1f)", video.bit_rate / 1000,
         name_of(r, video).c_str(), double(video.target_rate) / 1000);
  else if (r.target_psnr && !video.rung)
    wish = fvv::format(" (target %.4g dB)", *r.target_psnr);
  line(out, "  quality   %.2f dB luma%s over the %s%s of %u sampled frames", video.sample_psnr, wish.c_str(),
       video.is_atlas            ? "whole atlas"
       : video.sample_foreground ? "foreground"
                                 : "whole pictures",
       name_of(r, video) == label_of(video) ? "" : (" of " + name_of(r, video)).c_str(), video.sample_frames);
}

std::string rung_meshes_text(const Report &r, size_t rung) {
  if (!rung || !r.has_meshes) return "";
  const size_t taken = r.mesh_of(rung), rung_of_taken = taken ? r.lower_meshes[taken - 1].rung : 0;
  const LowerMeshes *own = considered(r, rung);
  const std::string saving = own ? fvv::format("%.1f %% of its bytes", 100 * own->saving) : std::string();
  if (rung_of_taken == rung) return "; meshes of its own save " + saving;
  return "; meshes of rung " + std::to_string(rung_of_taken) + ": " +
         (own ? "its own would save " + saving : r.shares_meshes);
}

void ladder_lines(std::string &out, const Report &r) {
  uint64_t common = r.bytes - r.payload();
  for (const VideoTrackReport &video : r.videos) common -= video.payload;
  for (const LowerMeshes &meshes : r.lower_meshes) common -= meshes.payload();
  for (size_t rung = 0; rung < r.ladder.size(); rung++) {
    const uint64_t pictures = picture_bytes(r, rung), meshes = r.meshes(r.mesh_of(rung)).payload();
    line(out, "  %-10srung %zu: %.1f kbit/s, of these %.1f for pictures at scale %.4g%s",
         rung ? "" : "ladder", rung, rate_of(r, common + pictures + meshes) / 1000,
         rate_of(r, pictures) / 1000, r.ladder[rung], rung_meshes_text(r, rung).c_str());
  }
}

void source_lines(std::string &out, const Report &r) {
  for (const SourceReport &v : r.sources)
    line(out,
         "  source    %s %s %s: %zu pictures at %.6g/s%s; %lld of %lld frames met, offset at most "
         "%.2f ms, "
         "mean %.2f ms; %zu frames repeat a picture, %zu pictures between are not used",
         v.camera ? ("camera " + std::to_string(*v.camera)).c_str() : "atlas", v.masks ? "masks" : "pictures",
         v.file.c_str(), v.pictures, v.rate, v.constant_rate ? "" : " on average", (long long)v.met,
         (long long)v.frames, v.largest_offset * 1000, v.mean_offset * 1000, v.used_again, v.between);
}

void mesh_lines(std::string &out, const Report &r) {
  const LatticeReport &lattice = r.lattice;
  const double *origin = lattice.origin;
  const bool metric = !r.scale_unknown;
  const std::string pixels = lattice.pixels > 0
                                 ? fvv::format("; vertices are at most %.3g px off there", lattice.pixels)
                                 : std::string();
  line(out, "  lattice   step %.6g %s from (%g, %g, %g): %s%s", lattice.step * (metric ? 1000 : 1),
       metric ? "mm" : "units", origin[0], origin[1], origin[2], lattice.reason.c_str(), pixels.c_str());
  out += decimation_text(r);
  line(out, "  winding   %s: %s", r.winding.flipped ? "flipped" : "as in the files",
       winding_text(r.winding.turned_away, r.winding.by_cameras).c_str());
  line(out, "  normals   %s: %s",
       r.normals.bits ? ("sent with " + std::to_string(r.normals.bits) + " bits").c_str() : "not sent",
       r.normals.reason.c_str());
  if (r.tracking)
    line(out, "  tracked   %s: %s", r.tracking->on ? "where the budget allows" : "no frame",
         r.tracking->reason.c_str());
  if (r.decimation.by_outlines)
    line(out, "            %llu frames by their outlines", (unsigned long long)r.decimation.by_outlines);
  if (r.delta.chunks)
    line(out, "  frames    %llu key, %.2f kB each; %llu delta, %.2f kB each, off by %u steps at most",
         (unsigned long long)(r.mesh.chunks - r.delta.chunks),
         double(r.mesh.payload - r.delta.payload) / 1000 / double(r.mesh.chunks - r.delta.chunks),
         (unsigned long long)r.delta.chunks, double(r.delta.payload) / 1000 / double(r.delta.chunks),
         lattice.delta_error);
  if (r.patched.chunks)
    line(out, "  patches   in %llu of the delta frames, %.2f kB each with its patch",
         (unsigned long long)r.patched.chunks, double(r.patched.payload) / 1000 / double(r.patched.chunks));
  line(out, "  meshes    %llu of %llu frames changed", (unsigned long long)r.changes.changed_frames,
       (unsigned long long)r.mesh.chunks);
  if (r.empty_frames) line(out, "            %zu frames have none: the stage is empty", r.empty_frames);
  for (const NamedChange &named : named_changes) {
    const Change &change = r.changes.*named.change;
    if (change.count)
      line(out, "            %llu %s in %llu frames", (unsigned long long)change.count, named.text,
           (unsigned long long)change.frames);
  }
}

std::string picture_text(const Report &r, const VideoTrackReport &video) {
  const std::string name = name_of(r, video);
  return video.is_atlas ? name : name == label_of(video) ? "pictures" : "pictures of " + name;
}

void verdict_lines(std::string &out, const Report &r) {
  const Verdict &v = *r.verdict;
  const bool metric = !r.scale_unknown;
  size_t pictures = 0;
  for (const VideoVerdict &video : v.videos) pictures += video.pictures;
  line(out, "  verified  %zu meshes, %zu pictures and %zu cameras read back", v.meshes, pictures, v.cameras);
  for (size_t k = 0; k < r.lower_meshes.size(); k++)
    if (r.lower_meshes[k].sent)
      line(out, "            and %zu meshes of rung %zu", v.lower_meshes[k].meshes, r.lower_meshes[k].rung);
  if (v.meshes)
    line(out, "            coordinates at most %.4g %s off, %.3f lattice steps",
         v.mesh.max_vertex_error * (metric ? 1000 : 1), metric ? "mm" : "units",
         v.mesh.max_vertex_error / r.lattice.step);
  if (r.normals.bits) line(out, "            normals at most %.3g degrees off", v.mesh.max_normal_error);
  if (r.texture_bits)
    line(out, "            texture coordinates at most %.3g of the atlas off", v.mesh.max_texture_error);
  for (size_t i = 0; i < v.videos.size(); i++)
    if (v.videos[i].pixels)
      line(out, "            %s %.2f dB luma, the worst frame %.2f dB", picture_text(r, r.videos[i]).c_str(),
           v.videos[i].psnr(), v.videos[i].min_psnr);
  if (v.cameras) line(out, "            points at most %.3g px elsewhere in the cameras", v.max_reprojection);
  if (v.sounds) line(out, "            sound of %zu groups is what was written", v.sounds);
  if (v.visible) line(out, "            visibility of %zu meshes is what their cameras see", v.visible);
  if (v.environments) line(out, "            the environment of %zu groups is the capture's", v.environments);
  if (r.calibration.chunks) line(out, "            and %.3g px in those that move", v.moving_reprojection);
}

void match_lines(std::string &out, const MatchReport &match) {
  line(out, "  matched   %s: %s", match.applied ? "colours of cameras" : "no colours", match.reason.c_str());
  if (!match.applied) return;
  for (const CameraGains &camera : match.cameras)
    line(out, "            camera %u: %s", unsigned(camera.camera),
         camera.matched ? fvv::format("gains %.3f, %.3f, %.3f by %zu places", camera.gains[0],
                                      camera.gains[1], camera.gains[2], camera.places)
                              .c_str()
                        : "as it is: it shares too little surface with others");
}

void undistorted_lines(std::string &out, const std::vector<UndistortedCamera> &cameras) {
  for (const UndistortedCamera &one : cameras)
    line(out,
         "  undistort camera %u: %ux%u without lens for %ux%u, %.1f x %.1f degrees, %.1f %% of the picture "
         "kept, %.1f %% blank, %.3g px for one on the axis%s",
         unsigned(one.camera), one.width, one.height, one.source_width, one.source_height, one.horizontal,
         one.vertical, 100 * one.kept, 100 * one.blank, one.axis_scale,
         one.limited ? "; cut at r_max or 75 degrees from the axis" : "");
  if (cameras.empty()) line(out, "  undistort no camera with pictures has a lens");
}

std::string sound_text(const Report &r, const SoundReport &sound) {
  std::string out =
      fvv::format("%s %.1f kbit/s, %u channel%s at %u Hz, ", sound.codec.c_str(),
                  double(sound.bit_rate) / 1000, sound.channels, sound.channels == 1 ? "" : "s", sound.rate) +
      (sound.encoded ? "from " : "unchanged from ") + sound.file;
  if (!sound.language.empty()) out += ", " + sound.language;
  if (sound.placed) out += sound.moves ? ", moving" : ", placed";
  const double end = double(r.ticks) * r.frame_duration.numerator / r.frame_duration.denominator;
  if (sound.start > 0.02 || sound.end < end - 0.02)
    out += fvv::format(", from %.2f to %.2f s", sound.start, sound.end);
  return out;
}

std::string environment_text(const EnvironmentReport &b) {
  return fvv::format("%llu times %zu parts, %llu triangles, %.2f kB; %zu pictures, %.2f kB; %zu lights",
                     (unsigned long long)b.chunks, b.parts, (unsigned long long)b.triangles,
                     double(b.mesh_bytes) / 1000, b.pictures, double(b.picture_bytes) / 1000, b.lights);
}

// Chunks other than those of the video.
void track_lines(std::string &out, const Report &r) {
  if (r.has_meshes)
    track_line(out, r, "mesh", r.mesh.payload,
               fvv_mesh_profile_name(r.mesh_profile) + (r.mesh_profile == FVV_MESH_DRACO
                                                            ? " level " + std::to_string(r.mesh_level)
                                                            : std::string()));
  if (r.calibration.chunks)
    track_line(out, r, "calibration", r.calibration.payload,
               fvv::format("of cameras that move, to %g px", calibration_error));
  if (r.visibility.frames)
    track_line(out, r, "visibility", r.visibility.bytes,
               fvv::format("%.3f bits a vertex and camera, %zu cameras", r.visibility.bits_per_pair(),
                           r.visibility.cameras.size()));
  const ColourSums &colours = r.colours;
  if (colours.track.chunks)
    track_line(out, r, "colours", colours.track.payload,
               fvv::format("%llu key meshes, %.0f cells of %.3g bits each, %.1f dB",
                           (unsigned long long)colours.track.chunks,
                           double(colours.cells) / double(colours.track.chunks),
                           8 * double(colours.track.payload) / double(colours.cells), colours.psnr()) +
                   (colours.shown == colours.vertices
                        ? std::string()
                        : fvv::format("; no camera shows %.2g %%",
                                      100 * (1 - double(colours.shown) / double(colours.vertices)))));
  for (const LowerMeshes &meshes : r.lower_meshes)
    if (meshes.sent)
      track_line(out, r, "mesh", meshes.payload(),
                 fvv::format("rung %zu: error ", meshes.rung) + budget_text(r, meshes.max_error) +
                     fvv::format(
                         ", %.0f triangles a frame (rung 0: %.0f); visibility %.1f kB, colours %.1f kB of it",
                         triangles_of(meshes), triangles_of(r), double(meshes.visibility.bytes) / 1000,
                         double(meshes.colours.track.payload) / 1000));
  for (const VideoTrackReport &video : r.videos)
    track_line(out, r, name_of(r, video).c_str(), video.payload, codec_choice(r, video));
  for (size_t i = 0; i < r.sounds.size(); i++)
    track_line(out, r, r.sounds.size() > 1 ? fvv::format("audio %zu", i + 1).c_str() : "audio",
               r.sounds[i].payload, sound_text(r, r.sounds[i]));
  if (r.environment)
    track_line(out, r, "environment", r.environment_chunks.payload, environment_text(*r.environment));
  track_line(out, r, "container", overhead(r), r.live ? "live: no index" : "with index");
}

void view_lines(std::string &out, const Report &r, const ViewReport &view) {
  if (!view.is_measured) return line(out, "  views     nothing chosen: %s", view.reason.c_str());
  line(out,
       "  views     %s %.2f dB (goal: lose at most %g%s%s): cameras drawn from the others have %.2f dB, %.2f "
       "without the choice, %.2f by the source",
       view.loss > 0 ? "lose" : "gain", std::abs(view.loss), view.goal, view.reason.empty() ? "" : "; ",
       view.reason.c_str(), view.held_out_psnr, view.psnr_without, view.finest_psnr);
  line(out,
       "            by pictures of %.4g dB, an error of %s, a step of %s, the blend %s, threshold %g, best "
       "%u: about %.0f "
       "%% of the bytes",
       view.psnr,
       view.is_length ? length_text(r.scale_unknown, view.max_error).c_str()
                      : fvv::format("%g px", view.max_error).c_str(),
       length_text(r.scale_unknown, view.step).c_str(), view.is_paper ? "paper" : "viewer", view.threshold,
       view.best, 100 * view.bytes / view.bytes_without);
  for (size_t k = 0; k < view.rungs.size(); k++)
    line(out, "            rung %zu, %g of the size with %.4g dB, %s %.2f dB", k + 1, view.rungs[k].scale,
         view.rungs[k].psnr, view.rungs[k].loss > 0 ? "loses" : "gains", std::abs(view.rungs[k].loss));
}

void realtime_lines(std::string &out, const RealtimeReport &r) {
  line(out, "  arrival   %zu frames lost, %zu dropped because they were too old; it ended because %s", r.lost,
       r.dropped, r.end.c_str());
  line(out,
       "  delay     %.0f ms (median), %.0f ms (95 %% of the frames), %.0f ms at most; %.0f ms at the start",
       1000 * r.median_delay, 1000 * r.p95_delay, 1000 * r.largest_delay, 1000 * r.start);
  for (const RealtimeReport::Step &step : r.steps)
    line(out, "  effort    from frame %lld on step %zu: %s", (long long)step.frame, step.effort,
         step.text.c_str());
}

} // namespace

std::string report_text(const Report &r, const std::string &output, Spelling spelling) {
  std::string out;
  line(out, "%s: %llu bytes, %zu frames at %.6g/s in %zu %s of %u, %.1f kbit/s", output.c_str(),
       (unsigned long long)r.bytes, r.frames, frame_rate(r), r.groups, r.groups == 1 ? "group" : "groups",
       r.group_size, double(r.bytes) * 8 / 1000 * frame_rate(r) / double(r.ticks));
  if (!r.left_out.empty()) line(out, "  left out  %zu frames that cannot be used", r.left_out.size());
  track_lines(out, r);
  for (const VideoTrackReport &video : r.videos) video_lines(out, r, video);
  ladder_lines(out, r);
  crop_lines(out, r);
  source_lines(out, r);
  if (r.undistorted) undistorted_lines(out, *r.undistorted);
  for (const LensGapReport &gap : r.lens_gaps)
    line(out, "  lens      camera %u: %.1f %% of the picture lie beyond r_max %.4g and are not used",
         unsigned(gap.camera), 100 * gap.share, gap.r_max);
  if (r.has_meshes) mesh_lines(out, r);
  line(out, "  visible   %s: %s", r.visibility_choice.sent ? "sent" : "not sent",
       r.visibility_choice.reason.c_str());
  line(out, "  colours   %s: %s", r.colours_choice.sent ? "sent" : "not sent",
       r.colours_choice.reason.c_str());
  match_lines(out, r.match);
  line(out, "  inset     %s: %s",
       r.inset.length > 0 ? length_text(r.scale_unknown, r.inset.length).c_str() : "none",
       r.inset.reason.c_str());
  if (r.view) view_lines(out, r, *r.view);
  if (r.realtime) realtime_lines(out, *r.realtime);
  line(out, "  time      %.2f s, %.1f frames/s with the preset %s", r.seconds, frames_per_second(r),
       r.preset.c_str());
  if (r.verdict) verdict_lines(out, r);
  return spell(out, spelling);
}

} // namespace fvv::mux
