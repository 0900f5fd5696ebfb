// The report as a document of spec/fvvmux.schema.json.
#include "fvv/mesh.h"
#include "fvv_media/video.h"
#include "fvv_mux/report.h"
#include "mux/src/report/report_names.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace fvv::mux {

namespace {

using Json = nlohmann::ordered_json;

// JSON has no infinity: a PSNR of identical pictures is null.
Json decibels(double psnr) {
  return std::isfinite(psnr) ? Json(psnr) : Json(nullptr);
}

Json track_json(const TrackBytes &track) {
  return {{"bytes", track.payload}, {"smallest", track.smallest}, {"largest", track.largest}};
}

Json lattice_json(const LatticeReport &lattice) {
  return {{"origin", {lattice.origin[0], lattice.origin[1], lattice.origin[2]}},
          {"step", lattice.step},
          {"reason", lattice.reason},
          {"error_pixels", lattice.pixels > 0 ? Json(lattice.pixels) : Json(nullptr)}};
}

Json budget_json(const Report &r) {
  const DecimationSums &sums = r.decimation;
  const BudgetReport &budget = r.budget;
  const bool seen = budget.in_pixels();
  Json out = {{"max_error", budget.max_error},
              {"unit", !budget.is_length ? "pixels"
                       : r.scale_unknown ? "units"
                                         : "metres"},
              {"pixel", nullptr},
              {"reason", budget.reason},
              {"decimated_frames", sums.frames - sums.kept},
              {"kept_frames", sums.kept},
              {"measured_frames", sums.measured}};
  if (seen) out["pixel"] = budget.pixel;
  if (sums.frames == sums.kept) return out;
  const double frames = double(sums.frames);
  out["triangles_before"] = double(sums.faces_before) / frames;
  out["triangles"] = double(sums.faces_after) / frames;
  const auto measured = [&](double value, bool known = true) {
    return sums.measured && known ? Json(value) : Json(nullptr);
  };
  out["rms"] = measured(sums.rms());
  out["max"] = measured(sums.max);
  out["rms_pixels"] = measured(sums.rms_pixels, seen);
  out["max_pixels"] = measured(sums.max_pixels, seen);
  out["volume_change"] = measured(sums.volume_change());
  out["triangles_max_over_median"] = sums.max_over_median();
  out["locked_triangles"] = double(sums.locked_faces) / frames;
  out["vanished_pieces"] = sums.vanished_pieces;
  out["vanished_area"] = sums.vanished_area;
  out["thin_area"] = sums.thin_area;
  return out;
}

Json mesh_json(const Report &r) {
  Json out = track_json(r.mesh);
  out["profile"] = fvv_mesh_profile_name(r.mesh_profile);
  out["level"] = r.mesh_level;
  out["key"] = {{"frames", r.mesh.chunks - r.delta.chunks}, {"bytes", r.mesh.payload - r.delta.payload}};
  out["delta"] = {
      {"frames", r.delta.chunks}, {"bytes", r.delta.payload}, {"max_error_steps", r.lattice.delta_error}};
  out["patched"] = {{"frames", r.patched.chunks}, {"bytes", r.patched.payload}};
  out["winding"] = {{"flipped", r.winding.flipped},
                    {"turned_away", r.winding.turned_away},
                    {"by_cameras", r.winding.by_cameras}};
  out["normals"] = {{"bits", r.normals.bits}, {"reason", r.normals.reason}};
  if (r.tracking)
    out["tracking"] = {
        {"on", r.tracking->on}, {"reason", r.tracking->reason}, {"by_outlines", r.decimation.by_outlines}};
  out["max_axis_error"] = r.changes.max_error;
  out["changed_frames"] = r.changes.changed_frames;
  out["empty_frames"] = r.empty_frames;
  for (const NamedChange &named : named_changes)
    out[named.key] = {{"count", (r.changes.*named.change).count},
                      {"frames", (r.changes.*named.change).frames}};
  return out;
}

Json sources_json(const Report &r) {
  Json out = Json::array();
  for (const SourceReport &v : r.sources) {
    Json unmet = Json::array();
    for (const SourceReport::Range &range : v.unmet) unmet.push_back({range.first, range.last});
    Json start = nullptr;
    if (v.better_start) start = {v.better_start->numerator, v.better_start->denominator};
    out.push_back({{"camera", v.camera ? Json(*v.camera) : Json(nullptr)},
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

Json video_verdict_json(const VideoVerdict &v) {
  return {{"pictures", v.pictures},
          {"psnr", v.pixels ? decibels(v.psnr()) : Json(nullptr)},
          {"min_psnr", v.pixels ? decibels(v.min_psnr) : Json(nullptr)}};
}

Json verdict_json(const Report &r) {
  const Verdict &v = *r.verdict;
  VideoVerdict shown; // by all tracks that show cameras
  Json atlas;
  for (size_t i = 0; i < v.videos.size(); i++)
    if (r.videos[i].rung)
      continue; // with the ladder
    else if (r.videos[i].is_atlas)
      atlas = video_verdict_json(v.videos[i]);
    else
      shown.add(v.videos[i]);
  const Json cameras = video_verdict_json(shown);
  Json out = {{"meshes", v.meshes},
              {"pictures", cameras["pictures"]},
              {"cameras", v.cameras},
              {"max_vertex_error", v.mesh.max_vertex_error},
              {"max_vertex_error_steps", v.mesh.max_vertex_error / r.lattice.step},
              {"psnr", cameras["psnr"]},
              {"min_psnr", cameras["min_psnr"]},
              {"max_reprojection", v.max_reprojection}};
  if (r.calibration.chunks) out["moving_max_reprojection"] = v.moving_reprojection;
  if (r.visibility_choice.sent) out["visibility"] = v.visible;
  if (r.environment) out["environment"] = v.environments;
  if (!r.sounds.empty()) out["audio"] = v.sounds;
  if (r.normals.bits) out["max_normal_error"] = v.mesh.max_normal_error;
  if (r.texture_bits) out["max_texture_error"] = v.mesh.max_texture_error;
  if (!atlas.is_null()) out["atlas"] = atlas;
  return out;
}

Json visibility_json(const Report &r) {
  const VisibilitySums &v = r.visibility;
  Json out = {{"sent", v.frames > 0}, {"reason", r.visibility_choice.reason}};
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

Json colours_json(const Report &r) {
  const ColourSums &c = r.colours;
  Json out = {{"sent", c.track.chunks > 0}, {"reason", r.colours_choice.reason}};
  if (!c.track.chunks) return out;
  out["frames"] = c.track.chunks;
  out.update(track_json(c.track));
  out["cells"] = c.cells;
  out["psnr"] = decibels(c.psnr());
  out["not_shown"] = 1 - double(c.shown) / double(c.vertices);
  out["cell_size"] = r.colour_cell;
  return out;
}

Json match_json(const MatchReport &match) {
  Json out = {{"applied", match.applied}, {"reason", match.reason}};
  if (!match.frames) return out;
  out["frames"] = match.frames;
  out["difference"] = match.difference;
  out["difference_left"] = match.difference_left;
  for (const CameraGains &camera : match.cameras)
    out["cameras"].push_back({{"id", camera.camera},
                              {"matched", camera.matched},
                              {"gains", camera.gains},
                              {"places", camera.places}});
  return out;
}

Json view_json(const ViewReport &view) {
  Json out = {{"goal", view.goal}, {"measured", view.is_measured}};
  if (!view.reason.empty()) out["reason"] = view.reason;
  if (!view.is_measured) return out;
  out["frame"] = view.frame;
  out["picture_psnr"] = view.psnr;
  out["max_error"] = view.max_error;
  out["max_error_unit"] = view.is_length ? "length" : "pixels";
  out["step"] = view.step;
  out["blend"] = view.is_paper ? "paper" : "viewer";
  out["threshold"] = view.threshold;
  out["best"] = view.best;
  out["loss"] = view.loss;
  out["finest"] = {{"psnr", view.finest_psnr}, {"ssim", view.finest_ssim}};
  out["chosen"] = {{"psnr", view.held_out_psnr}, {"ssim", view.held_out_ssim}, {"group_bytes", view.bytes}};
  out["without"] = {{"psnr", view.psnr_without}, {"group_bytes", view.bytes_without}};
  if (std::isfinite(view.between_psnr)) out["between_psnr"] = view.between_psnr;
  for (const ViewCandidate &one : view.candidates)
    out["candidates"].push_back({{"max_error", one.max_error},
                                 {"step", one.step},
                                 {"picture_psnr", one.psnr},
                                 {"group_bytes", one.bytes},
                                 {"loss", one.loss},
                                 {"measured", one.is_measured}});
  for (const RungView &one : view.rungs)
    out["rungs"].push_back(
        {{"scale", one.scale}, {"picture_psnr", one.psnr}, {"max_error", one.max_error}, {"loss", one.loss}});
  for (const BlendCandidate &one : view.blends)
    out["blends"].push_back({{"threshold", one.threshold}, {"best", one.best}, {"gain", one.gain}});
  return out;
}

Json inset_json(const InsetReport &inset) {
  Json out = {{"length", inset.length}, {"reason", inset.reason}};
  if (!inset.frame) return out;
  out["frame"] = *inset.frame;
  out["pixels"] = inset.pixels;
  out["cameras"] = inset.cameras;
  out["better"] = inset.better;
  if (!inset.is_compared) return out;
  out["psnr_without"] = inset.psnr_without;
  out["psnr_best"] = inset.psnr_best;
  return out;
}

Json sound_json(const SoundReport &sound) {
  Json out = {{"track", sound.track}, {"chunks", sound.chunks}};
  out.update(track_json(sound));
  out["file"] = sound.file;
  out["encoded"] = sound.encoded;
  out["codec"] = sound.codec == "AAC" ? "aac" : "opus";
  out["rate"] = sound.rate;
  out["channels"] = sound.channels;
  out["bit_rate"] = sound.bit_rate;
  out["start"] = sound.start;
  out["end"] = sound.end;
  out["title"] = sound.title;
  out["language"] = sound.language;
  out["placed"] = sound.placed;
  out["moves"] = sound.moves;
  return out;
}

Json environment_json(const EnvironmentReport &b) {
  return {{"chunks", b.chunks},
          {"bytes", b.bytes},
          {"parts", b.parts},
          {"vertices", b.vertices},
          {"triangles", b.triangles},
          {"mesh_bytes", b.mesh_bytes},
          {"pictures", b.pictures},
          {"picture_bytes", b.picture_bytes},
          {"lights", b.lights},
          {"lattice",
           {{"origin", {b.origin[0], b.origin[1], b.origin[2]}}, {"step", b.step}, {"reason", b.reason}}},
          {"max_axis_error", b.max_axis_error}};
}

Json undistorted_json(const std::vector<UndistortedCamera> &cameras) {
  Json out = Json::array();
  for (const UndistortedCamera &one : cameras)
    out.push_back({{"camera", one.camera},
                   {"source_width", one.source_width},
                   {"source_height", one.source_height},
                   {"width", one.width},
                   {"height", one.height},
                   {"horizontal_degrees", one.horizontal},
                   {"vertical_degrees", one.vertical},
                   {"kept", one.kept},
                   {"blank", one.blank},
                   {"axis_scale", one.axis_scale},
                   {"limited", one.limited}});
  return out;
}

// A whole number where it is one.
Json quality_json(const VideoTrackReport &video) {
  const double whole = std::floor(video.quality);
  return video.quality == whole ? Json(int(whole)) : Json(video.quality);
}

Json video_json(const Report &r, const VideoTrackReport &video) {
  Json out = track_json(video);
  out["codec"] = media::find_video_codec(video.codec)->option;
  out["bit_depth"] = video.bit_depth;
  if (!video.is_encoded) out["quality"] = quality_json(video);
  out["width"] = video.width;
  out["height"] = video.height;
  if (video.is_atlas)
    out["texture_bits"] = r.texture_bits;
  else
    out["cameras"] = video.cameras.size();
  if (video.is_encoded) return out;
  if (!video.is_atlas)
    out["crop"] = {
        {"cropped", r.crop.cropped}, {"reason", r.crop.reason},          {"by_masks", r.crop.by_masks},
        {"by_mesh", r.crop.by_mesh}, {"pixel_share", video.pixel_share}, {"layouts", r.crop.layouts},
        {"fill", r.crop.fill}};
  out["sample_frames"] = video.sample_frames;
  out["sample_psnr"] = decibels(video.sample_psnr);
  out["sample_foreground"] = video.sample_foreground;
  if (r.has_bit_rate)
    out["bit_rate"] = {{"target", video.target_rate},
                       {"reached", video.bit_rate},
                       {"finest", video.rate.finest},
                       {"coarsest", video.rate.coarsest},
                       {"groups_over", video.rate.over}};
  return out;
}

// Errors in pixels are those of the rung's own pictures.
Json rung_meshes_json(const Report &r, size_t rung) {
  const size_t taken = r.mesh_of(rung);
  const LowerMeshes *lower = taken ? &r.lower_meshes[taken - 1] : nullptr;
  const MeshSums &sums = r.meshes(taken);
  Json out = {{"rung", lower ? lower->rung : 0},
              {"track", lower ? lower->track : r.mesh_track},
              {"bytes", sums.mesh.payload},
              {"visibility_bytes", sums.visibility.bytes},
              {"colours_bytes", sums.colours.track.payload},
              {"max_error", lower ? lower->max_error : r.budget.max_error},
              {"triangles", triangles_of(sums)}};
  if ((lower ? lower->in_pixels : r.budget.in_pixels()) && sums.decimation.measured) {
    const double scale = r.rung_scale(rung);
    out["rms_pixels"] = sums.decimation.rms_pixels * scale;
    out["max_pixels"] = sums.decimation.max_pixels * scale;
  }
  if (const LowerMeshes *own = considered(r, rung))
    out["saving"] = own->saving;
  else if (rung)
    out["reason"] = r.shares_meshes;
  if (!r.verdict || !lower || lower->rung != rung) return out;
  const MeshTrackVerdict &verdict = r.verdict->lower_meshes[taken - 1];
  out["verified"] = {{"meshes", verdict.meshes}, {"max_vertex_error", verdict.mesh.max_vertex_error}};
  if (r.visibility_choice.sent) out["verified"]["visibility"] = verdict.visible;
  return out;
}

Json ladder_json(const Report &r) {
  Json out = Json::array();
  for (size_t rung = 0; rung < r.rung_count(); rung++) {
    const uint64_t pictures = picture_bytes(r, rung);
    Json tracks = Json::array();
    for (size_t i = 0; i < r.videos.size(); i++) {
      const VideoTrackReport &video = r.videos[i];
      if (video.rung != rung || !video.alternate_group) continue;
      tracks.push_back({{"track", video.track},
                        {"alternate_group", video.alternate_group},
                        {"shows", video.is_atlas ? "atlas" : "cameras"},
                        {"width", video.width},
                        {"height", video.height},
                        {"quality", quality_json(video)},
                        {"nominal_rate", video.target_rate ? double(video.target_rate) : video.sample_rate},
                        {"bytes", video.payload},
                        {"sample_psnr", decibels(video.sample_psnr)}});
      if (r.verdict) tracks.back()["verified"] = video_verdict_json(r.verdict->videos[i]);
    }
    out.push_back({{"rung", rung},
                   {"scale", r.ladder[rung]},
                   {"picture_bytes", pictures},
                   {"picture_rate", rate_of(r, pictures)},
                   {"tracks", tracks}});
    if (r.has_meshes) out.back()["meshes"] = rung_meshes_json(r, rung);
  }
  return out;
}

// Those of the best rung, by what they show.
void add_videos(Json &out, const Report &r) {
  for (const VideoTrackReport &video : r.videos) {
    if (video.rung) continue;
    Json one = video_json(r, video);
    if (video.is_atlas || r.tile_track_count() == 1) {
      out[label_of(video)] = std::move(one);
      continue;
    }
    one["track"] = video.track;
    for (const uint16_t camera : video.cameras) one["camera_ids"].push_back(camera);
    out[label_of(video)].push_back(std::move(one));
  }
}

// Reasons name options.
void spell_texts(Json &json, Spelling spelling) {
  if (json.is_string()) json = spell(json.get_ref<const std::string &>(), spelling);
  if (json.is_structured())
    for (Json &one : json) spell_texts(one, spelling);
}

} // namespace

std::string report_json(const Report &r, const std::string &output, Spelling spelling) {
  Json out = {{"fvvmux", 1},
              {"output", output},
              {"bytes", r.bytes},
              {"container_bytes", overhead(r)},
              {"frames", r.frames},
              {"preset", r.preset},
              {"frame_duration", {r.frame_duration.numerator, r.frame_duration.denominator}},
              {"group", r.group_size},
              {"groups", r.groups},
              {"lattice", lattice_json(r.lattice)}};
  if (r.skips_bad_frames) {
    out["left_out"] = Json::array();
    for (const LeftOutFrame &frame : r.left_out)
      out["left_out"].push_back({{"frame", frame.frame}, {"reason", frame.reason}});
  }
  if (r.has_meshes) {
    out["budget"] = budget_json(r);
    out["mesh"] = mesh_json(r);
  }
  if (r.calibration.chunks) out["calibration"] = track_json(r.calibration);
  add_videos(out, r);
  if (!r.ladder.empty()) out["ladder"] = ladder_json(r);
  out["visibility"] = visibility_json(r);
  out["colours"] = colours_json(r);
  out["match_colours"] = match_json(r.match);
  out["texture_inset"] = inset_json(r.inset);
  if (r.view) out["view_loss"] = view_json(*r.view);
  for (const SoundReport &sound : r.sounds) out["audio"].push_back(sound_json(sound));
  if (r.environment) out["environment"] = environment_json(*r.environment);
  if (!r.sources.empty()) out["sources"] = sources_json(r);
  if (r.undistorted) out["undistorted"] = undistorted_json(*r.undistorted);
  for (const LensGapReport &gap : r.lens_gaps)
    out["lens_gaps"].push_back({{"camera", gap.camera}, {"r_max", gap.r_max}, {"share", gap.share}});
  out["reads"] = {{"meshes", r.mesh_reads}, {"pictures", r.picture_reads}, {"masks", r.mask_reads}};
  if (r.realtime)
    out["realtime"] = {{"lost_frames", r.realtime->lost},
                       {"dropped_frames", r.realtime->dropped},
                       {"delay_median", r.realtime->median_delay},
                       {"delay_p95", r.realtime->p95_delay},
                       {"delay_max", r.realtime->largest_delay},
                       {"first_delay", r.realtime->start},
                       {"effort", Json::array()},
                       {"end", r.realtime->end}};
  if (r.realtime)
    for (const RealtimeReport::Step &step : r.realtime->steps)
      out["realtime"]["effort"].push_back(
          {{"frame", step.frame}, {"step", step.effort}, {"text", step.text}});
  out["seconds"] = r.seconds;
  out["frames_per_second"] = frames_per_second(r);
  if (r.verdict) out["verified"] = verdict_json(r);
  spell_texts(out, spelling);
  return out.dump(2, ' ', false, Json::error_handler_t::replace);
}

} // namespace fvv::mux
