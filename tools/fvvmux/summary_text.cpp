#include "fvvmux/summary_terms.h"

#include "capture/lens_check.h"
#include "cli/format.h"
#include "fvvmux/background.h"
#include "fvvmux/frame_limit.h"
#include "fvvmux/moving.h"
#include "fvvmux/winding.h"

#include <cstdarg>
#include <cstdio>

namespace fvv::mux {

namespace {

__attribute__((format(printf, 2, 3))) void line(std::string &out, const char *pattern, ...) {
  va_list arguments;
  va_start(arguments, pattern);
  out += cli::format_list(pattern, arguments) + '\n';
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
  const std::string quality = quality_text(s, index);
  const bool lossless = codec.code == FVV_CODEC_OEXR && quality == "0";
  return std::string(codec.name) + " " + (lossless ? "lossless" : codec.scale + (" " + quality)) + ", " +
         std::to_string(v.bit_depth) + " bits, " +
         (track.is_atlas() ? "" : std::to_string(track.tiling.tiles.size()) + " tiles in ") +
         std::to_string(v.width) + "x" + std::to_string(v.height);
}

// Of all tracks that show cameras.
void crop_lines(std::string &out, const Summary &s) {
  const CropChoice &crop = s.plan.crop;
  size_t tiles = 0;
  double share = 0;
  for (const VideoTrack &track : s.plan.tracks) {
    if (track.is_atlas()) continue;
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
  char wish[40] = "";
  if (s.plan.options.bit_rate)
    line(out, "  rate      %.1f kbit/s of the %s (asked for %.1f)", s.bit_rate(index) / 1000,
         name_of(s, track).c_str(), double(video.settings.bit_rate) / 1000);
  else if (s.plan.options.quality.is_psnr)
    std::snprintf(wish, sizeof wish, " (asked for %.4g dB)", s.plan.options.quality.value);
  line(out, "  quality   %.2f dB luma%s over the %s%s of %u sampled frames", video.sample_psnr, wish,
       track.is_atlas() ? "whole atlas"
       : video.masks    ? "foreground"
                        : "whole pictures",
       name_of(s, track) == label_of(track) ? "" : (" of " + name_of(s, track)).c_str(), video.sample_frames);
}

void source_lines(std::string &out, const Summary &s) {
  for (const capture::VideoReport &v : s.plan.sources)
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
  line(out, "  meshes    %llu of %zu frames changed", (unsigned long long)s.changes.changed_frames,
       s.plan.frame_count());
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
  if (v.visible) line(out, "            visibility of %zu meshes is what their cameras see", v.visible);
  if (v.backgrounds) line(out, "            the environment of %zu groups is the capture's", v.backgrounds);
  if (s.calibration.chunks) line(out, "            and %.3g px in those that move", v.moving_reprojection);
}

std::string visibility_text(const Summary &s) {
  char text[100];
  const bool shares = s.plan.visibility.domain == FVV_VISIBILITY_SHARES;
  std::snprintf(text, sizeof text, "%.3f bits a %s and camera, %zu cameras", s.visibility.bits_per_pair(),
                shares ? "vertex with a share" : domain_text(s), s.visibility.cameras.size());
  return text;
}

} // namespace

std::string summary_text(const Summary &s) {
  const Plan &plan = s.plan;
  std::string out;
  line(out, "%s: %llu bytes, %zu frames at %.6g/s in %zu %s of %u, %.1f kbit/s", plan.options.output.c_str(),
       (unsigned long long)s.bytes, plan.frame_count(), frame_rate(s), plan.group_count(),
       plan.group_count() == 1 ? "group" : "groups", plan.group_size,
       double(s.bytes) * 8 / 1000 * frame_rate(s) / double(plan.frame_count()));
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
  for (size_t i = 0; i < plan.tracks.size(); i++)
    track_line(out, s, name_of(s, plan.tracks[i]).c_str(), s.videos[i].payload, codec_choice(s, i));
  if (plan.background)
    track_line(out, s, "background", s.background.payload,
               std::to_string(s.background.chunks) + " times " + background_text(*plan.background));
  track_line(out, s, "container", overhead(s), plan.options.live ? "live: no index" : "with index");
  for (size_t i = 0; i < plan.tracks.size(); i++) video_lines(out, s, i);
  crop_lines(out, s);
  source_lines(out, s);
  if (plan.undistortion) out += plan.undistortion->text();
  out += capture::text_of(capture::lens_gaps(plan.capture));
  if (plan.has_meshes()) mesh_lines(out, s);
  line(out, "  visible   %s: %s", plan.visibility.on ? "sent" : "not sent", plan.visibility.reason.c_str());
  line(out, "  time      %.2f s, %.1f frames/s", s.seconds, per_second(s));
  if (s.verdict) verdict_lines(out, s);
  return out;
}

} // namespace fvv::mux
