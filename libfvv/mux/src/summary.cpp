#include "fvv_cxx/format.h"
#include "fvv_scene/capture.h"
#include "mux/src/background.h"
#include "mux/src/choices.h"
#include "mux/src/layout.h"
#include "mux/src/sound/sound.h"
#include "mux/src/stream_writer.h"
#include "mux/src/summary_terms.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace fvv::mux {

void DecimationSums::add(const decimate::Report &report) {
  frames++;
  kept += report.kept;
  faces_before += report.faces_before;
  faces_after += report.faces_after;
  locked_faces += report.locked_faces;
  squares += report.error.rms * report.error.rms;
  max = std::max(max, report.error.max);
  max_pixels = std::max(max_pixels, report.error.max_pixels);
  rms_pixels = std::max(rms_pixels, report.error.rms_pixels);
  volume_before += report.volume_before;
  volume_after += report.volume_after;
  vanished.pieces += report.vanished.pieces;
  vanished.area += report.vanished.area;
  thin_area += report.thin_area;
}

double DecimationSums::rms() const {
  return frames > kept ? std::sqrt(squares / double(frames - kept)) : 0;
}

double DecimationSums::volume_change() const {
  return volume_before != 0 ? volume_after / volume_before - 1 : 0;
}

static std::string decimation_text(const Plan &plan, const DecimationSums &sums) {
  const DecimationChoice &choice = plan.meshes[0].decimation;
  std::string out = "  budget    " + budget_text(plan);
  const bool seen = std::isfinite(choice.pixel) && !choice.is_length;
  if (seen)
    out += (choice.budget.pixels == 1 ? " is " : " are ") +
           length_text(plan, choice.budget.pixels * choice.pixel) + " where cameras see sharpest";
  if (!choice.on) return out + "; all triangles are kept: " + choice.reason + "\n";
  const double frames = double(sums.frames);
  out += fvv::format(": %.0f -> %.0f triangles a frame ", double(sums.faces_before) / frames,
                     double(sums.faces_after) / frames) +
         choice.reason + "\n";
  if (sums.kept < sums.frames) {
    out += "            off by " + length_text(plan, sums.rms()) + " rms, " + length_text(plan, sums.max) +
           " at most, lattice included; the worst frame";
    if (seen) out += fvv::format(" %.3f px rms, %.2f px at most;", sums.rms_pixels, sums.max_pixels);
    out += fvv::format(" volume %+.2f %%\n", 100 * sums.volume_change());
  }
  if (sums.locked_faces)
    out += fvv::format("            %.0f triangles a frame stay, or places would be off by more than ",
                       double(sums.locked_faces) / frames) +
           budget_text(plan, decimate::max_over_rms) + "\n";
  if (sums.kept)
    out += fvv::format("            %llu frames are as they were: fewer triangles would break the budget\n",
                       (unsigned long long)sums.kept);
  return out;
}

static nlohmann::ordered_json decimation_json(const Plan &plan, const DecimationSums &sums) {
  const DecimationChoice &choice = plan.meshes[0].decimation;
  const bool seen = std::isfinite(choice.pixel) && !choice.is_length;
  nlohmann::ordered_json out = {{"max_error", plan.error.value},
                                {"unit", !choice.is_length            ? "pixels"
                                         : plan.capture.scale_unknown ? "units"
                                                                      : "metres"},
                                {"pixel", nullptr},
                                {"reason", choice.reason},
                                {"decimated_frames", sums.frames - sums.kept},
                                {"kept_frames", sums.kept}};
  if (seen) out["pixel"] = choice.pixel;
  if (sums.frames == sums.kept) return out;
  const double frames = double(sums.frames);
  out["triangles_before"] = double(sums.faces_before) / frames;
  out["triangles"] = double(sums.faces_after) / frames;
  out["rms"] = sums.rms();
  out["max"] = sums.max;
  out["rms_pixels"] = seen ? nlohmann::ordered_json(sums.rms_pixels) : nullptr;
  out["max_pixels"] = seen ? nlohmann::ordered_json(sums.max_pixels) : nullptr;
  out["volume_change"] = sums.volume_change();
  out["locked_triangles"] = double(sums.locked_faces) / frames;
  out["vanished_pieces"] = sums.vanished.pieces;
  out["vanished_area"] = sums.vanished.area;
  out["thin_area"] = sums.thin_area;
  return out;
}

namespace {

__attribute__((format(printf, 2, 3))) void line(std::string &out, const char *pattern, ...) {
  va_list arguments;
  va_start(arguments, pattern);
  out += fvv::format_list(pattern, arguments) + '\n';
  va_end(arguments);
}

double frame_rate(const Summary &s) {
  return double(s.plan.capture.frame_duration.denominator) / s.plan.capture.frame_duration.numerator;
}

void track_line(std::string &out, const Summary &s, const char *label, uint64_t payload,
                const std::string &what) {
  line(out, "  %-10s%9.1f kB %5.1f %% %8.2f kB/frame  %s", label, double(payload) / 1000,
       100 * double(payload) / double(s.bytes), double(payload) / 1000 / double(s.plan.frame_count()),
       what.c_str());
}

std::string quality_text(const Summary &s, size_t track) {
  if (!s.plan.options.bit_rate) return std::to_string(s.plan.tracks[track].choice.settings.quality);
  char text[80];
  const RateResult &rate = s.rates[track];
  if (rate.finest == rate.coarsest)
    std::snprintf(text, sizeof text, "%g", rate.finest);
  else
    std::snprintf(text, sizeof text, "%g to %g", rate.finest, rate.coarsest);
  return text;
}

std::string codec_choice(const Summary &s, size_t index) {
  const VideoTrack &track = s.plan.tracks[index];
  const media::VideoSettings &v = track.choice.settings;
  const media::VideoCodec &codec = *media::find_video_codec(v.codec);
  return std::string(codec.name) + " " +
         (track.encoded                  ? "encoded before"
          : codec.code == FVV_CODEC_OEXR ? "lossless"
                                         : codec.scale + (" " + quality_text(s, index))) +
         ", " + std::to_string(v.bit_depth) + " bits, " +
         (track.is_atlas() ? "" : std::to_string(track.tiling.tiles.size()) + " tiles in ") +
         std::to_string(v.width) + "x" + std::to_string(v.height);
}

// Of all tracks that show cameras.
void crop_lines(std::string &out, const Summary &s) {
  const CropChoice &crop = s.plan.crop;
  size_t tiles = 0;
  double share = 0;
  for (const VideoTrack &track : s.plan.tracks) {
    if (track.is_atlas() || track.encoded || track.rung) continue;
    tiles += track.tiling.tiles.size();
    share += pixel_share(s, track);
  }
  if (!tiles) return;
  const size_t tracks = s.plan.tile_track_count();
  line(out,
       "  tiles     %s%s: the frame%s %.1f %% of the pixels of %zu whole pictures; %zu of %zu groups have a "
       "layout of their own; background: %s",
       crop.on ? "cropped " : "not cropped, ", crop.reason.c_str(), tracks > 1 ? "s together have" : " has",
       100 * share, tiles, s.layouts, s.plan.group_count(), fill_text(s));
  if (tracks <= 1) return;
  line(out, "            in %zu video tracks%s: at %.6g frames/s a frame may have %s", tracks,
       s.plan.options.video_tracks > 1 ? " (--video-tracks)" : "", frame_rate(s),
       limit_text(s.plan.frame_limit).c_str());
}

void video_lines(std::string &out, const Summary &s, size_t index) {
  const VideoTrack &track = s.plan.tracks[index];
  const VideoChoice &video = track.choice;
  if (track.encoded) return;
  char wish[40] = "";
  if (s.plan.options.bit_rate)
    line(out, "  rate      %.1f kbit/s of the %s (target %.1f)", s.bit_rate(index) / 1000,
         name_of(s, track).c_str(), double(video.settings.bit_rate) / 1000);
  else if (s.plan.options.quality.is_psnr && !track.rung)
    std::snprintf(wish, sizeof wish, " (target %.4g dB)", s.plan.options.quality.value);
  line(out, "  quality   %.2f dB luma%s over the %s%s of %u sampled frames", video.sample_psnr, wish,
       track.is_atlas() ? "whole atlas"
       : video.masks    ? "foreground"
                        : "whole pictures",
       name_of(s, track) == label_of(track) ? "" : (" of " + name_of(s, track)).c_str(), video.sample_frames);
}

// Bytes of payload of the pictures of a rung, those included that all rungs share.
uint64_t picture_bytes(const Summary &s, size_t rung) {
  uint64_t bytes = 0;
  for (size_t i = 0; i < s.plan.tracks.size(); i++)
    if (s.plan.tracks[i].is_in(rung)) bytes += s.videos[i].payload;
  return bytes;
}

double rate_of(const Summary &s, uint64_t bytes) {
  return 8 * double(bytes) * frame_rate(s) / double(s.plan.end());
}

// Of meshes with visibility and colours that a rung takes; NULL: there are none.
const MeshSums *meshes_of(const Summary &s, size_t rung) {
  return s.plan.has_meshes() ? &s.meshes(size_t(&s.plan.mesh_of(rung) - s.plan.meshes.data())) : nullptr;
}

// A rung for which coarser meshes were considered; NULL: none were.
const MeshTrack *considered(const Plan &plan, size_t rung) {
  const auto found = std::find_if(plan.meshes.begin(), plan.meshes.end(),
                                  [&](const MeshTrack &track) { return track.rung == rung; });
  return rung && found != plan.meshes.end() ? &*found : nullptr;
}

double triangles_of(const MeshSums &sums) {
  return sums.mesh.chunks ? double(sums.faces) / double(sums.mesh.chunks) : 0;
}

std::string rung_meshes_text(const Summary &s, size_t rung) {
  const Plan &plan = s.plan;
  if (!rung || !plan.has_meshes()) return "";
  const MeshTrack &taken = plan.mesh_of(rung), *track = considered(plan, rung);
  const std::string saving = track ? fvv::format("%.1f %% of its bytes", 100 * track->saving) : std::string();
  if (taken.rung == rung) return "; meshes of its own save " + saving;
  return "; meshes of rung " + std::to_string(taken.rung) + ": " +
         (track ? "its own would save " + saving : plan.shares_meshes);
}

void ladder_lines(std::string &out, const Summary &s) {
  const std::vector<Rung> &ladder = s.plan.options.ladder;
  uint64_t common = s.bytes - s.payload();
  for (const TrackBytes &video : s.videos) common -= video.payload;
  for (const MeshSums &meshes : s.lower_meshes) common -= meshes.payload();
  for (size_t rung = 0; rung < ladder.size(); rung++) {
    const uint64_t pictures = picture_bytes(s, rung);
    const MeshSums *meshes = meshes_of(s, rung);
    line(out, "  %-10srung %zu: %.1f kbit/s, of these %.1f for pictures at scale %.4g%s",
         rung ? "" : "ladder", rung, rate_of(s, common + pictures + (meshes ? meshes->payload() : 0)) / 1000,
         rate_of(s, pictures) / 1000, ladder[rung].scale, rung_meshes_text(s, rung).c_str());
  }
}

void source_lines(std::string &out, const Summary &s) {
  for (const scene::VideoReport &v : s.plan.sources)
    line(out,
         "  source    %s %s %s: %zu pictures at %.6g/s%s; %lld of %lld frames met, offset at most "
         "%.2f ms, "
         "mean %.2f ms; %zu frames repeat a picture, %zu pictures between are not used",
         v.camera ? ("camera " + std::to_string(*v.camera)).c_str() : "atlas", v.masks ? "masks" : "pictures",
         v.file.c_str(), v.pictures, v.rate, v.constant_rate ? "" : " on average", (long long)v.met,
         (long long)v.frames, v.largest_offset * 1000, v.mean_offset * 1000, v.used_again, v.between);
}

void mesh_lines(std::string &out, const Summary &s) {
  const LatticeChoice &choice = s.plan.lattice;
  const double *origin = choice.lattice.origin;
  const bool metric = !s.plan.capture.scale_unknown;
  char pixels[80] = "";
  if (choice.pixels > 0)
    std::snprintf(pixels, sizeof pixels, "; vertices are at most %.3g px off there", choice.pixels);
  line(out, "  lattice   step %.6g %s from (%g, %g, %g): %s%s", choice.lattice.step * (metric ? 1000 : 1),
       metric ? "mm" : "units", origin[0], origin[1], origin[2], choice.reason.c_str(), pixels);
  out += decimation_text(s.plan, s.decimation);
  line(out, "  winding   %s: %s", s.plan.winding.flip ? "flipped" : "as in the files",
       winding_text(s.plan.winding).c_str());
  const NormalChoice &normals = s.plan.normals;
  line(out, "  normals   %s: %s",
       normals.bits ? ("sent with " + std::to_string(normals.bits) + " bits").c_str() : "not sent",
       normals.reason.c_str());
  if (s.delta.chunks)
    line(out, "  frames    %llu key, %.2f kB each; %llu delta, %.2f kB each, off by %u steps at most",
         (unsigned long long)(s.mesh.chunks - s.delta.chunks),
         double(s.mesh.payload - s.delta.payload) / 1000 / double(s.mesh.chunks - s.delta.chunks),
         (unsigned long long)s.delta.chunks, double(s.delta.payload) / 1000 / double(s.delta.chunks),
         choice.delta_error);
  line(out, "  meshes    %llu of %llu frames changed", (unsigned long long)s.changes.changed_frames,
       (unsigned long long)s.mesh.chunks);
  if (const size_t empty = empty_frames(s))
    line(out, "            %zu frames have none: the stage is empty", empty);
  for (const NamedChange &named : named_changes) {
    const Change &change = s.changes.*named.change;
    if (change.count)
      line(out, "            %llu %s in %llu frames", (unsigned long long)change.count, named.text,
           (unsigned long long)change.frames);
  }
}

std::string picture_text(const Summary &s, const VideoTrack &track) {
  const std::string name = name_of(s, track);
  return track.is_atlas() ? name : name == label_of(track) ? "pictures" : "pictures of " + name;
}

void verdict_lines(std::string &out, const Summary &s) {
  const Verdict &v = *s.verdict;
  const bool metric = !s.plan.capture.scale_unknown;
  size_t pictures = 0;
  for (const VideoVerdict &video : v.videos) pictures += video.pictures;
  line(out, "  verified  %zu meshes, %zu pictures and %zu cameras read back", v.meshes, pictures, v.cameras);
  for (const MeshTrack &track : s.plan.meshes)
    if (track.rung && track.sent)
      line(out, "            and %zu meshes of rung %zu",
           v.lower_meshes[size_t(&track - s.plan.meshes.data()) - 1].meshes, track.rung);
  if (v.meshes)
    line(out, "            coordinates at most %.4g %s off, %.3f lattice steps",
         v.mesh.max_vertex_error * (metric ? 1000 : 1), metric ? "mm" : "units",
         v.mesh.max_vertex_error / s.plan.lattice.lattice.step);
  if (s.plan.normals.bits) line(out, "            normals at most %.3g degrees off", v.mesh.max_normal_error);
  if (s.plan.texture_bits)
    line(out, "            texture coordinates at most %.3g of the atlas off", v.mesh.max_texture_error);
  for (size_t i = 0; i < v.videos.size(); i++)
    if (v.videos[i].luma.pixels)
      line(out, "            %s %.2f dB luma, the worst frame %.2f dB",
           picture_text(s, s.plan.tracks[i]).c_str(), v.videos[i].luma.psnr(), v.videos[i].min_psnr);
  if (v.cameras) line(out, "            points at most %.3g px elsewhere in the cameras", v.max_reprojection);
  if (v.sounds) line(out, "            sound of %zu groups is what was written", v.sounds);
  if (v.visible) line(out, "            visibility of %zu meshes is what their cameras see", v.visible);
  if (v.backgrounds) line(out, "            the environment of %zu groups is the capture's", v.backgrounds);
  if (s.calibration.chunks) line(out, "            and %.3g px in those that move", v.moving_reprojection);
}

void match_lines(std::string &out, const Plan &plan) {
  const MatchChoice &match = plan.match;
  line(out, "  matched   %s: %s", match.on ? "colours of cameras" : "no colours", match.reason.c_str());
  for (size_t i = 0; i < match.cameras.size() && match.on; i++) {
    const render::CameraMatch &camera = match.found.cameras[i];
    line(out, "            camera %u: %s", unsigned(plan.capture.cameras[match.cameras[i]].calibration.id),
         camera.matched ? fvv::format("gains %.3f, %.3f, %.3f by %zu places", camera.gain[0], camera.gain[1],
                                      camera.gain[2], camera.places)
                              .c_str()
                        : "as it is: it shares too little surface with others");
  }
}

void inset_line(std::string &out, const Plan &plan) {
  const InsetChoice &inset = plan.inset;
  line(out, "  inset     %s: %s", inset.inset > 0 ? length_text(plan, inset.inset).c_str() : "none",
       inset.reason.c_str());
}

std::string visibility_text(const Summary &s) {
  char text[100];
  std::snprintf(text, sizeof text, "%.3f bits a vertex and camera, %zu cameras", s.visibility.bits_per_pair(),
                s.visibility.cameras.size());
  return text;
}

} // namespace

static std::string sound_text(const Plan &plan, const SoundTrack &sound) {
  const media::SoundFormat &format = sound.packets.format;
  std::string out = fvv::format("%s %.1f kbit/s, %u channel%s at %u Hz, ", sound_codec_text(sound),
                                double(bit_rate_of(sound)) / 1000, format.channels,
                                format.channels == 1 ? "" : "s", format.rate) +
                    (sound.packets.encoded ? "from " : "unchanged from ") + sound.source.file;
  if (!sound.source.language.empty()) out += ", " + sound.source.language;
  if (sound.source.is_placed()) out += sound.source.per_frame.empty() ? ", placed" : ", moving";
  const SoundSpan span = span_of(plan, sound);
  const double end =
      double(plan.end()) * plan.capture.frame_duration.numerator / plan.capture.frame_duration.denominator;
  if (span.start > 0.02 || span.end < end - 0.02)
    out += fvv::format(", from %.2f to %.2f s", span.start, span.end);
  return out;
}

std::string summary_text(const Summary &s, const std::string &output) {
  const Plan &plan = s.plan;
  std::string out;
  line(out, "%s: %llu bytes, %zu frames at %.6g/s in %zu %s of %u, %.1f kbit/s", output.c_str(),
       (unsigned long long)s.bytes, plan.frame_count(), frame_rate(s), plan.group_count(),
       plan.group_count() == 1 ? "group" : "groups", plan.group_size,
       double(s.bytes) * 8 / 1000 * frame_rate(s) / double(plan.end()));
  if (!plan.bad.empty()) line(out, "  left out  %zu frames that cannot be used", plan.bad.size());
  if (plan.has_meshes())
    track_line(out, s, "mesh", s.mesh.payload,
               profile_text(s) + (plan.options.mesh_profile == FVV_MESH_DRACO
                                      ? " level " + std::to_string(plan.options.mesh_level)
                                      : std::string()));
  if (s.calibration.chunks) {
    char error[60];
    std::snprintf(error, sizeof error, "of cameras that move, to %g px", calibration_error);
    track_line(out, s, "calibration", s.calibration.payload, error);
  }
  if (s.visibility.frames) track_line(out, s, "visibility", s.visibility.bytes, visibility_text(s));
  if (s.colours.track.chunks)
    track_line(out, s, "colours", s.colours.track.payload,
               fvv::format("%llu key meshes, %.0f cells of %.3g bits each, %.1f dB; no camera shows %.2g %%",
                           (unsigned long long)s.colours.track.chunks,
                           double(s.colours.cells) / double(s.colours.track.chunks),
                           8 * double(s.colours.track.payload) / double(s.colours.cells), s.colours.psnr(),
                           100 * (1 - double(s.colours.shown) / double(s.colours.vertices))));
  for (const MeshTrack &track : plan.meshes) {
    if (!track.rung || !track.sent) continue;
    const MeshSums &sums = *meshes_of(s, track.rung);
    track_line(
        out, s, "mesh", sums.payload(),
        fvv::format("rung %zu: error ", track.rung) + budget_text(plan, track.times) +
            fvv::format(", %.0f triangles a frame (rung 0: %.0f); visibility %.1f kB, colours %.1f kB of it",
                        triangles_of(sums), triangles_of(s), double(sums.visibility.bytes) / 1000,
                        double(sums.colours.track.payload) / 1000));
  }
  for (size_t i = 0; i < plan.tracks.size(); i++)
    track_line(out, s, name_of(s, plan.tracks[i]).c_str(), s.videos[i].payload, codec_choice(s, i));
  for (size_t i = 0; i < plan.sounds.size(); i++)
    track_line(out, s, plan.sounds.size() > 1 ? fvv::format("audio %zu", i + 1).c_str() : "audio",
               s.sounds[i].payload, sound_text(plan, plan.sounds[i]));
  if (plan.background)
    track_line(out, s, "background", s.background.payload,
               std::to_string(s.background.chunks) + " times " + background_text(*plan.background));
  track_line(out, s, "container", overhead(s), plan.options.live ? "live: no index" : "with index");
  for (size_t i = 0; i < plan.tracks.size(); i++) video_lines(out, s, i);
  ladder_lines(out, s);
  crop_lines(out, s);
  source_lines(out, s);
  if (plan.undistortion) out += plan.undistortion->text();
  out += scene::text_of(scene::lens_gaps(plan.capture));
  if (plan.has_meshes()) mesh_lines(out, s);
  line(out, "  visible   %s: %s", plan.visibility.on ? "sent" : "not sent", plan.visibility.reason.c_str());
  line(out, "  colours   %s: %s", plan.colours.on ? "sent" : "not sent", plan.colours.reason.c_str());
  match_lines(out, plan);
  inset_line(out, plan);
  line(out, "  time      %.2f s, %.1f frames/s", s.seconds, per_second(s));
  if (s.verdict) verdict_lines(out, s);
  return out;
}

namespace {

nlohmann::ordered_json sources_json(const Summary &s) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const scene::VideoReport &v : s.plan.sources) {
    nlohmann::ordered_json unmet = nlohmann::ordered_json::array();
    for (const scene::FrameRange &range : v.unmet) unmet.push_back({range.first, range.last});
    nlohmann::ordered_json start = nullptr;
    if (v.better_start) start = {v.better_start->numerator, v.better_start->denominator};
    out.push_back({{"camera", v.camera ? nlohmann::ordered_json(*v.camera) : nlohmann::ordered_json(nullptr)},
                   {"kind", v.masks ? "masks" : "pictures"},
                   {"file", v.file},
                   {"pictures", v.pictures},
                   {"rate", v.rate},
                   {"constant_rate", v.constant_rate},
                   {"frames", v.frames},
                   {"met", v.met},
                   {"unmet", unmet},
                   {"largest_offset", v.largest_offset},
                   {"mean_offset", v.mean_offset},
                   {"repeated", v.used_again},
                   {"unused", {{"before", v.before}, {"between", v.between}, {"after", v.behind}}},
                   {"better_start", start}});
  }
  return out;
}

// JSON has no infinity: a PSNR of identical pictures is null.
nlohmann::ordered_json decibels(double psnr) {
  return std::isfinite(psnr) ? nlohmann::ordered_json(psnr) : nullptr;
}

nlohmann::ordered_json video_verdict_json(const VideoVerdict &v) {
  return {{"pictures", v.pictures},
          {"psnr", v.luma.pixels ? decibels(v.luma.psnr()) : nullptr},
          {"min_psnr", v.luma.pixels ? decibels(v.min_psnr) : nullptr}};
}

nlohmann::ordered_json verdict_json(const Summary &s) {
  const Verdict &v = *s.verdict;
  VideoVerdict shown; // by all tracks that show cameras
  nlohmann::ordered_json atlas;
  for (size_t i = 0; i < v.videos.size(); i++)
    if (s.plan.tracks[i].rung)
      continue; // with the ladder
    else if (s.plan.tracks[i].is_atlas())
      atlas = video_verdict_json(v.videos[i]);
    else
      shown.add(v.videos[i]);
  const nlohmann::ordered_json cameras = video_verdict_json(shown);
  nlohmann::ordered_json out = {
      {"meshes", v.meshes},
      {"pictures", cameras["pictures"]},
      {"cameras", v.cameras},
      {"max_vertex_error", v.mesh.max_vertex_error},
      {"max_vertex_error_steps", v.mesh.max_vertex_error / s.plan.lattice.lattice.step},
      {"psnr", cameras["psnr"]},
      {"min_psnr", cameras["min_psnr"]},
      {"max_reprojection", v.max_reprojection}};
  if (s.calibration.chunks) out["moving_max_reprojection"] = v.moving_reprojection;
  if (s.plan.visibility.on) out["visibility"] = v.visible;
  if (s.plan.background) out["background"] = v.backgrounds;
  if (!s.plan.sounds.empty()) out["audio"] = v.sounds;
  if (s.plan.normals.bits) out["max_normal_error"] = v.mesh.max_normal_error;
  if (s.plan.texture_bits) out["max_texture_error"] = v.mesh.max_texture_error;
  if (!atlas.is_null()) out["atlas"] = atlas;
  return out;
}

nlohmann::ordered_json track_json(const TrackBytes &track) {
  return {{"bytes", track.payload}, {"smallest", track.smallest}, {"largest", track.largest}};
}

nlohmann::ordered_json visibility_json(const Summary &s) {
  const VisibilitySums &v = s.visibility;
  nlohmann::ordered_json out = {{"sent", v.frames > 0}, {"reason", s.plan.visibility.reason}};
  if (!v.frames) return out;
  out["cameras"] = v.cameras.size();
  out["frames"] = v.frames;
  out["bytes"] = v.bytes;
  out["smallest"] = v.smallest;
  out["largest"] = v.largest;
  out["key_frames"] = v.keys;
  out["bits_per_pair"] = v.bits_per_pair();
  return out;
}

nlohmann::ordered_json colours_json(const Summary &s) {
  const ColourSums &c = s.colours;
  nlohmann::ordered_json out = {{"sent", c.track.chunks > 0}, {"reason", s.plan.colours.reason}};
  if (!c.track.chunks) return out;
  out["frames"] = c.track.chunks;
  out.update(track_json(c.track));
  out["cells"] = c.cells;
  out["psnr"] = decibels(c.psnr());
  out["not_shown"] = 1 - double(c.shown) / double(c.vertices);
  out["cell_size"] = s.plan.colours.cell_size * s.plan.lattice.lattice.step;
  return out;
}

nlohmann::ordered_json match_json(const Plan &plan) {
  const MatchChoice &match = plan.match;
  nlohmann::ordered_json out = {{"applied", match.on}, {"reason", match.reason}};
  if (!match.frames) return out;
  out["frames"] = match.frames;
  out["difference"] = match.found.before;
  out["difference_left"] = match.found.after;
  for (size_t i = 0; i < match.cameras.size(); i++) {
    const render::CameraMatch &camera = match.found.cameras[i];
    out["cameras"].push_back({{"id", plan.capture.cameras[match.cameras[i]].calibration.id},
                              {"matched", camera.matched},
                              {"gains", camera.gain},
                              {"places", camera.places}});
  }
  return out;
}

nlohmann::ordered_json inset_json(const Plan &plan) {
  const InsetChoice &inset = plan.inset;
  nlohmann::ordered_json out = {{"length", inset.inset}, {"reason", inset.reason}};
  if (!inset.frame) return out;
  out["frame"] = *inset.frame;
  out["pixels"] = inset.found.pixels;
  out["cameras"] = inset.found.views;
  out["better"] = inset.found.better;
  if (inset.found.pixels < render::least_compared) return out;
  out["psnr_without"] = inset.found.before;
  out["psnr_best"] = inset.found.after;
  return out;
}

nlohmann::ordered_json sound_json(const Summary &s, size_t index) {
  const SoundTrack &sound = s.plan.sounds[index];
  const SoundSpan span = span_of(s.plan, sound);
  nlohmann::ordered_json out = {{"track", sound_track_id(index)}, {"chunks", s.sounds[index].chunks}};
  out.update(track_json(s.sounds[index]));
  out["file"] = sound.source.file;
  out["encoded"] = sound.packets.encoded;
  out["codec"] = sound_codec_text(sound) == std::string("AAC") ? "aac" : "opus";
  out["rate"] = sound.packets.format.rate;
  out["channels"] = sound.packets.format.channels;
  out["bit_rate"] = bit_rate_of(sound);
  out["start"] = span.start;
  out["end"] = span.end;
  out["title"] = sound.source.title;
  out["language"] = sound.source.language;
  out["placed"] = sound.source.is_placed();
  out["moves"] = !sound.source.per_frame.empty();
  return out;
}

nlohmann::ordered_json video_json(const Summary &s, size_t index) {
  const VideoTrack &track = s.plan.tracks[index];
  nlohmann::ordered_json out = track_json(s.videos[index]);
  out["codec"] = media::find_video_codec(track.choice.settings.codec)->option;
  out["bit_depth"] = track.choice.settings.bit_depth;
  if (!track.encoded) out["quality"] = track.choice.settings.quality;
  out["width"] = track.tiling.width;
  out["height"] = track.tiling.height;
  if (track.is_atlas())
    out["texture_bits"] = s.plan.texture_bits;
  else
    out["cameras"] = track.tiling.tiles.size();
  if (track.encoded) return out;
  if (!track.is_atlas())
    out["crop"] = {{"cropped", s.plan.crop.on},
                   {"reason", s.plan.crop.reason},
                   {"by_masks", s.plan.crop.by_masks},
                   {"by_mesh", s.plan.crop.by_mesh},
                   {"pixel_share", pixel_share(s, track)},
                   {"layouts", s.layouts},
                   {"background", fill_text(s)}};
  out["sample_frames"] = track.choice.sample_frames;
  out["sample_psnr"] = decibels(track.choice.sample_psnr);
  out["sample_foreground"] = track.choice.masks;
  if (s.plan.options.bit_rate)
    out["bit_rate"] = {{"target", track.choice.settings.bit_rate},
                       {"reached", s.bit_rate(index)},
                       {"finest", s.rates[index].finest},
                       {"coarsest", s.rates[index].coarsest},
                       {"groups_over", s.rates[index].over}};
  return out;
}

// Errors in pixels are those of the rung's own pictures.
nlohmann::ordered_json rung_meshes_json(const Summary &s, size_t rung) {
  const Plan &plan = s.plan;
  const MeshTrack &track = plan.mesh_of(rung);
  const MeshSums &sums = *meshes_of(s, rung);
  nlohmann::ordered_json out = {{"rung", track.rung},
                                {"track", track.id},
                                {"bytes", sums.mesh.payload},
                                {"visibility_bytes", sums.visibility.bytes},
                                {"colours_bytes", sums.colours.track.payload},
                                {"max_error", plan.error.value * track.times},
                                {"triangles", triangles_of(sums)}};
  const DecimationChoice &choice = track.decimation;
  if (std::isfinite(choice.pixel) && !choice.is_length && sums.decimation.frames > sums.decimation.kept) {
    const double scale = plan.rung_scale(rung);
    out["rms_pixels"] = sums.decimation.rms_pixels * scale;
    out["max_pixels"] = sums.decimation.max_pixels * scale;
  }
  if (const MeshTrack *own = considered(plan, rung))
    out["saving"] = own->saving;
  else if (rung)
    out["reason"] = plan.shares_meshes;
  if (!s.verdict || !rung || track.rung != rung) return out;
  const MeshTrackVerdict &verdict = s.verdict->lower_meshes[size_t(&track - plan.meshes.data()) - 1];
  out["verified"] = {{"meshes", verdict.meshes}, {"max_vertex_error", verdict.mesh.max_vertex_error}};
  if (plan.visibility.on) out["verified"]["visibility"] = verdict.visible;
  return out;
}

nlohmann::ordered_json ladder_json(const Summary &s) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (size_t rung = 0; rung < s.plan.rung_count(); rung++) {
    const uint64_t pictures = picture_bytes(s, rung);
    nlohmann::ordered_json tracks = nlohmann::ordered_json::array();
    for (size_t i = 0; i < s.plan.tracks.size(); i++) {
      const VideoTrack &track = s.plan.tracks[i];
      if (track.rung != rung || !track.alternate_group) continue;
      const VideoChoice &choice = track.choice;
      tracks.push_back(
          {{"track", track.id},
           {"alternate_group", track.alternate_group},
           {"shows", track.is_atlas() ? "atlas" : "cameras"},
           {"width", track.tiling.width},
           {"height", track.tiling.height},
           {"quality", choice.settings.quality},
           {"nominal_rate", choice.settings.bit_rate ? double(choice.settings.bit_rate) : choice.sample_rate},
           {"bytes", s.videos[i].payload},
           {"sample_psnr", decibels(choice.sample_psnr)}});
      if (s.verdict) tracks.back()["verified"] = video_verdict_json(s.verdict->videos[i]);
    }
    out.push_back({{"rung", rung},
                   {"scale", s.plan.options.ladder[rung].scale},
                   {"picture_bytes", pictures},
                   {"picture_rate", rate_of(s, pictures)},
                   {"tracks", tracks}});
    if (s.plan.has_meshes()) out.back()["meshes"] = rung_meshes_json(s, rung);
  }
  return out;
}

} // namespace

nlohmann::ordered_json summary_json(const Summary &s, const std::string &output) {
  using Json = nlohmann::ordered_json;
  const Plan &plan = s.plan;
  const geometry::Lattice &lattice = plan.lattice.lattice;
  Json out = {
      {"fvvmux", 1},
      {"output", output},
      {"bytes", s.bytes},
      {"container_bytes", overhead(s)},
      {"frames", plan.frame_count()},
      {"frame_duration", {plan.capture.frame_duration.numerator, plan.capture.frame_duration.denominator}},
      {"group", plan.group_size},
      {"groups", plan.group_count()},
      {"lattice",
       {{"origin", {lattice.origin[0], lattice.origin[1], lattice.origin[2]}},
        {"step", lattice.step},
        {"reason", plan.lattice.reason},
        {"error_pixels", plan.lattice.pixels > 0 ? Json(plan.lattice.pixels) : Json(nullptr)}}}};
  if (plan.options.skip_bad_frames) {
    out["left_out"] = Json::array();
    for (const BadFrame &frame : plan.bad)
      out["left_out"].push_back({{"frame", frame.number}, {"reason", frame.reason}});
  }
  if (plan.has_meshes()) {
    out["budget"] = decimation_json(plan, s.decimation);
    Json mesh = track_json(s.mesh);
    mesh["profile"] = profile_text(s);
    mesh["level"] = plan.options.mesh_level;
    mesh["key"] = {{"frames", s.mesh.chunks - s.delta.chunks}, {"bytes", s.mesh.payload - s.delta.payload}};
    mesh["delta"] = {{"frames", s.delta.chunks},
                     {"bytes", s.delta.payload},
                     {"max_error_steps", plan.lattice.delta_error}};
    mesh["winding"] = {{"flipped", plan.winding.flip},
                       {"turned_away", plan.winding.in_stream()},
                       {"by_cameras", plan.winding.by_cameras}};
    mesh["normals"] = {{"bits", plan.normals.bits}, {"reason", plan.normals.reason}};
    mesh["max_axis_error"] = s.changes.max_error;
    mesh["changed_frames"] = s.changes.changed_frames;
    mesh["empty_frames"] = empty_frames(s);
    for (const NamedChange &named : named_changes)
      mesh[named.key] = {{"count", (s.changes.*named.change).count},
                         {"frames", (s.changes.*named.change).frames}};
    out["mesh"] = mesh;
  }
  if (s.calibration.chunks) out["calibration"] = track_json(s.calibration);
  for (size_t i = 0; i < plan.tracks.size(); i++) {
    const VideoTrack &track = plan.tracks[i];
    if (track.rung) continue;
    Json video = video_json(s, i);
    if (track.is_atlas() || plan.tile_track_count() == 1) {
      out[label_of(track)] = std::move(video);
      continue;
    }
    video["track"] = track.id;
    for (const fvv_tile &tile : track.tiling.tiles) video["camera_ids"].push_back(tile.camera_id);
    out[label_of(track)].push_back(std::move(video));
  }
  if (!plan.options.ladder.empty()) out["ladder"] = ladder_json(s);
  out["visibility"] = visibility_json(s);
  out["colours"] = colours_json(s);
  out["match_colours"] = match_json(plan);
  out["texture_inset"] = inset_json(plan);
  for (size_t i = 0; i < plan.sounds.size(); i++) out["audio"].push_back(sound_json(s, i));
  if (plan.background) out["background"] = background_json(*plan.background, s.background.chunks);
  if (!plan.sources.empty()) out["sources"] = sources_json(s);
  if (plan.undistortion) out["undistorted"] = plan.undistortion->json();
  for (const scene::LensGap &gap : scene::lens_gaps(plan.capture))
    out["lens_gaps"].push_back({{"camera", gap.camera}, {"r_max", gap.r_max}, {"share", gap.share}});
  out["reads"] = {
      {"meshes", s.mesh_reads}, {"pictures", s.picture_reads.pictures}, {"masks", s.picture_reads.masks}};
  out["seconds"] = s.seconds;
  out["frames_per_second"] = per_second(s);
  if (s.verdict) out["verified"] = verdict_json(s);
  return out;
}

} // namespace fvv::mux
