#include "capture/lens_check.h"
#include "fvvmux/background.h"
#include "fvvmux/stream_writer.h"
#include "fvvmux/summary_terms.h"

#include <cmath>

namespace fvv::mux {

namespace {

nlohmann::ordered_json sources_json(const Summary &s) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const capture::VideoReport &v : s.plan.sources) {
    nlohmann::ordered_json unmet = nlohmann::ordered_json::array();
    for (const capture::FrameRange &range : v.unmet) unmet.push_back({range.first, range.last});
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
    if (s.plan.tracks[i].is_atlas())
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
  out["domain"] = domain_text(s);
  out["smooth"] = s.plan.visibility.smooth;
  out["cameras"] = v.cameras.size();
  out["frames"] = v.frames;
  out["bytes"] = v.bytes;
  out["smallest"] = v.smallest;
  out["largest"] = v.largest;
  out["key_frames"] = v.keys;
  out["bits_per_pair"] = v.bits_per_pair();
  return out;
}

nlohmann::ordered_json video_json(const Summary &s, size_t index) {
  const VideoTrack &track = s.plan.tracks[index];
  nlohmann::ordered_json out = track_json(s.videos[index]);
  out["codec"] = codec_text(s);
  out["bit_depth"] = track.choice.settings.bit_depth;
  out["quality"] = track.choice.settings.quality;
  out["width"] = track.tiling.width;
  out["height"] = track.tiling.height;
  if (track.is_atlas())
    out["texture_bits"] = s.plan.texture_bits;
  else
    out["cameras"] = track.tiling.tiles.size();
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
    out["bit_rate"] = {{"asked", track.choice.settings.bit_rate},
                       {"reached", s.bit_rate(index)},
                       {"finest", s.rates[index].finest},
                       {"coarsest", s.rates[index].coarsest},
                       {"groups_over", s.rates[index].over}};
  return out;
}

} // namespace

nlohmann::ordered_json summary_json(const Summary &s) {
  using Json = nlohmann::ordered_json;
  const Plan &plan = s.plan;
  const capture::Lattice &lattice = plan.lattice.lattice;
  Json out = {
      {"fvvmux", 1},
      {"output", plan.options.output},
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
    for (const NamedChange &named : named_changes)
      mesh[named.key] = {{"count", (s.changes.*named.change).count},
                         {"frames", (s.changes.*named.change).frames}};
    out["mesh"] = mesh;
  }
  if (s.calibration.chunks) out["calibration"] = track_json(s.calibration);
  for (size_t i = 0; i < plan.tracks.size(); i++) {
    const VideoTrack &track = plan.tracks[i];
    Json video = video_json(s, i);
    if (track.is_atlas() || plan.tile_track_count() == 1) {
      out[label_of(track)] = std::move(video);
      continue;
    }
    video["track"] = track_id(track);
    for (const fvv_tile &tile : track.tiling.tiles) video["camera_ids"].push_back(tile.camera_id);
    out[label_of(track)].push_back(std::move(video));
  }
  out["visibility"] = visibility_json(s);
  if (plan.background) out["background"] = background_json(*plan.background, s.background.chunks);
  if (!plan.sources.empty()) out["sources"] = sources_json(s);
  if (plan.undistortion) out["undistorted"] = plan.undistortion->json();
  for (const capture::LensGap &gap : capture::lens_gaps(plan.capture))
    out["lens_gaps"].push_back({{"camera", gap.camera}, {"r_max", gap.r_max}, {"share", gap.share}});
  out["seconds"] = s.seconds;
  out["frames_per_second"] = per_second(s);
  if (s.verdict) out["verified"] = verdict_json(s);
  return out;
}

} // namespace fvv::mux
