#include "fvvinfo/report.h"

namespace fvv::info {

namespace {

using Json = nlohmann::ordered_json;

// Ticks go as strings: they use all 64 bits, which numbers in JSON readers do not hold.
std::string ticks(int64_t value) {
  return std::to_string(value);
}

Json scene_json(const fvv_scene &scene) {
  return {{"time_base", {scene.time_base.numerator, scene.time_base.denominator}},
          {"frame_duration", ticks(scene.frame_duration)},
          {"lattice_origin", {scene.lattice_origin[0], scene.lattice_origin[1], scene.lattice_origin[2]}},
          {"lattice_step", scene.lattice_step},
          {"up", up_name(scene.up_axis)},
          {"scale_known", !(scene.flags & FVV_SCENE_SCALE_UNKNOWN)}};
}

Json rect_json(const fvv_rect &r) {
  return {r.x, r.y, r.width, r.height};
}

Json video_json(const Report &report, const fvv_video_layout &video) {
  const auto &c = video.config;
  Json out = {
      {"codec", type_name(c.codec)},
      {"codec_string", std::string(c.codec_string, c.codec_string_size)},
      {"width", c.width},
      {"height", c.height},
      {"bit_depth", c.bit_depth},
      {"shows", c.shows == FVV_SHOWS_TILES    ? "tiles"
                : c.shows == FVV_SHOWS_CAMERA ? "camera"
                                              : "atlas"},
      {"colour", {c.colour_primaries, c.transfer_characteristics, c.matrix_coefficients, c.full_range}}};
  if (c.shows == FVV_SHOWS_CAMERA) out["camera"] = c.camera_id;
  if (c.shows != FVV_SHOWS_TILES) return out;
  out["pixel_share"] = pixel_share(report, video);
  out["tiles"] = Json::array();
  for (size_t i = 0; i < video.tile_count; i++) {
    const auto &tile = video.tiles[i];
    out["tiles"].push_back({{"camera", tile.camera_id},
                            {"source", rect_json(tile.source)},
                            {"destination", rect_json(tile.destination)}});
  }
  return out;
}

Json profiles_json(const fvv_track_summary &summary) {
  Json out = Json::object();
  for (uint8_t p = 0; p < FVV_MESH_PROFILE_COUNT; p++)
    if (summary.profile_chunks[p])
      out[fvv_mesh_profile_name(p)] = {{"chunks", summary.profile_chunks[p]},
                                       {"bytes", summary.profile_bytes[p]}};
  return out;
}

Json tracks_json(const Report &report, const fvv_configuration &c) {
  Json out = Json::array();
  for (size_t i = 0; i < c.track_count; i++) {
    const auto &track = c.tracks[i];
    Json t = {{"track", track.id},
              {"kind", kind_name(track.kind)},
              {"name", std::string(track.name, track.name_size)},
              {"chunks", 0},
              {"key_chunks", 0},
              {"bytes", 0}};
    for (size_t k = 0; k < fvv_checker_track_count(report.checker.get()); k++) {
      const auto *s = fvv_checker_track(report.checker.get(), k);
      if (s->track != track.id) continue;
      t["chunks"] = s->chunks;
      t["key_chunks"] = s->key_chunks;
      t["bytes"] = s->bytes;
      if (s->layouts)
        t["layouts"] = {{"groups", s->layouts}, {"tile_pixels", {s->least_tile_pixels, s->most_tile_pixels}}};
      if (!s->chunks) continue;
      t["smallest"] = s->smallest;
      t["largest"] = s->largest;
      if (track.kind == FVV_TRACK_MESH && s->max_vertices)
        t["mesh"] = {{"vertices", {s->min_vertices, s->max_vertices}},
                     {"triangles", {s->min_faces, s->max_faces}},
                     {"vertices_sum", s->vertices},
                     {"triangles_sum", s->faces},
                     {"profiles", profiles_json(*s)}};
      if (s->parts || s->lights)
        t["background"] = {{"parts", s->parts},
                           {"vertices", s->vertices},
                           {"triangles", s->faces},
                           {"pictures", s->pictures},
                           {"lights", s->lights}};
      if (s->textured)
        t["mesh"]["texture"] = {{"chunks", s->textured},
                                {"bits", {s->min_texture_bits, s->max_texture_bits}}};
      if (s->with_normals)
        t["mesh"]["normals"] = {{"chunks", s->with_normals},
                                {"bits", {s->min_normal_bits, s->max_normal_bits}}};
      if (track.kind == FVV_TRACK_CALIBRATION)
        t["calibration"] = {{"entries", s->calibrations}, {"lost", s->lost_calibrations}};
      if (s->max_cameras)
        t["visibility"] = {{"face_chunks", s->chunks - s->of_vertices - s->of_weights},
                           {"vertex_chunks", s->of_vertices},
                           {"weight_chunks", s->of_weights},
                           {"cameras", {s->min_cameras, s->max_cameras}},
                           {"pairs", s->pairs},
                           {"bits_per_pair", s->pairs ? 8 * double(s->bytes) / double(s->pairs) : 0}};
    }
    if (const auto *video = fvv_configuration_video(&c, track.id)) t["video"] = video_json(report, *video);
    out.push_back(t);
  }
  return out;
}

Json cameras_json(const fvv_configuration &c) {
  Json out = Json::array();
  for (size_t i = 0; i < c.camera_count; i++) {
    const fvv_camera &camera = c.cameras[i];
    double centre[3];
    fvv_camera_centre(&camera, centre);
    Json one = {{"id", camera.id},
                {"name", std::string(camera.name, camera.name_size)},
                {"width", camera.width},
                {"height", camera.height},
                {"fx", camera.fx},
                {"fy", camera.fy},
                {"cx", camera.cx},
                {"cy", camera.cy},
                {"skew", camera.skew},
                {"lens", lens_name(camera.lens)},
                {"distortion", std::vector<double>(camera.distortion, camera.distortion + 8)},
                {"rotation", std::vector<double>(camera.rotation, camera.rotation + 9)},
                {"translation", std::vector<double>(camera.translation, camera.translation + 3)},
                {"centre", std::vector<double>(centre, centre + 3)}};
    // JSON has no infinity: a lens that is valid everywhere has no r_max.
    if (camera.r_max < 1e300) one["r_max"] = camera.r_max;
    if (camera.flags & FVV_CAMERA_MOVES) one["moves"] = true;
    out.push_back(one);
  }
  return out;
}

Json problems_json(const Report &report) {
  Json out = Json::array();
  for (size_t i = 0; i < fvv_checker_problem_count(report.checker.get()); i++) {
    const auto *p = fvv_checker_problem(report.checker.get(), i);
    Json one = {{"status", fvv_status_text(p->status)}, {"offset", p->offset}, {"message", p->message}};
    if (p->chunk_type) one["chunk"] = type_name(p->chunk_type);
    if (p->issue) one["issue"] = "FVV-" + std::to_string(p->issue);
    out.push_back(one);
  }
  return out;
}

Json texturing_json(const fvv_texturing &t) {
  return {{"threshold", t.threshold},
          {"best", t.best},
          {"unseen", {t.unseen[0], t.unseen[1], t.unseen[2]}},
          {"depth_bias", t.depth_bias},
          {"depth_slope", t.depth_slope}};
}

Json chunks_json(const Report &report) {
  Json out = Json::array();
  for (const auto &chunk : report.chunks) {
    const auto &h = chunk.header;
    out.push_back({{"offset", chunk.offset},
                   {"type", type_name(h.type)},
                   {"flags", h.flags},
                   {"track", h.track},
                   {"time", ticks(h.time)},
                   {"size", h.size},
                   {"intact", chunk.intact}});
  }
  return out;
}

} // namespace

Json json(const Report &report) {
  const auto &s = report.summary();
  Json out = {{"name", report.name},
              {"bytes", s.bytes},
              {"integrity", report.integrity()},
              {"decoded", report.options.check},
              {"written_version", {s.written_major, s.written_minor}},
              {"chunk_count", s.chunks},
              {"groups", s.groups},
              {"frames", s.frames},
              {"whole_frames", s.whole_frames},
              {"whole", Json::array()},
              {"start", ticks(s.start)},
              {"end", ticks(s.end)},
              {"index", s.has_footer && report.has_index},
              {"container_bytes", s.bytes - s.payload_bytes},
              {"problem_count", s.problems},
              {"problems", problems_json(report)}};
  for (size_t i = 0; i < fvv_checker_run_count(report.checker.get()); i++) {
    const auto *run = fvv_checker_run(report.checker.get(), i);
    out["whole"].push_back({{"first", run->first},
                            {"count", run->count},
                            {"first_time", ticks(run->first_time)},
                            {"last_time", ticks(run->last_time)}});
  }
  if (const fvv_configuration *c = report.configuration()) {
    out["scene"] = scene_json(c->scene);
    out["tracks"] = tracks_json(report, *c);
    out["cameras"] = cameras_json(*c);
    if (c->has_texturing) out["texturing"] = texturing_json(c->texturing);
    out["metadata"] = Json::array();
    for (size_t i = 0; i < c->metadata_count; i++)
      out["metadata"].push_back(std::string(c->metadata[i].text, c->metadata[i].size));
  }
  if (report.options.chunks) out["chunks"] = chunks_json(report);
  return out;
}

} // namespace fvv::info
