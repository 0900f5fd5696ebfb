#include "fvvdemux/views.h"

#include <set>

namespace fvv::demux {

namespace {

void tell(std::vector<std::string> *warnings, const std::string &text) {
  if (warnings) warnings->push_back(text);
}

std::vector<fvv_tile> tiles_of(const fvv_configuration &configuration, const fvv_video_layout &video,
                               std::vector<std::string> *warnings) {
  const fvv_video_config &config = video.config;
  std::vector<fvv_tile> out;
  if (config.shows == FVV_SHOWS_TILES) {
    for (size_t i = 0; i < video.tile_count; i++) out.push_back(video.tiles[i]);
    return out;
  }
  const fvv_rect whole = {0, 0, uint16_t(config.width), uint16_t(config.height)};
  if (config.shows == FVV_SHOWS_ATLAS && config.width <= UINT16_MAX && config.height <= UINT16_MAX) {
    out.push_back({no_camera, whole, whole});
    return out;
  }
  const fvv_camera *camera =
      config.shows == FVV_SHOWS_CAMERA ? fvv_configuration_camera(&configuration, config.camera_id) : nullptr;
  if (!camera || camera->width > UINT16_MAX || camera->height > UINT16_MAX || config.width > UINT16_MAX ||
      config.height > UINT16_MAX) {
    tell(warnings, "track " + std::to_string(video.track) + " shows no pictures of cameras: left out");
    return out;
  }
  out.push_back({camera->id, {0, 0, uint16_t(camera->width), uint16_t(camera->height)}, whole});
  return out;
}

} // namespace

fvv_camera camera_of_tile(const fvv_camera &camera, const fvv_tile &tile) {
  const fvv_rect &from = tile.source, &to = tile.destination;
  const double sx = double(to.width) / from.width, sy = double(to.height) / from.height;
  fvv_camera out = camera;
  out.width = to.width;
  out.height = to.height;
  out.fx = camera.fx * sx;
  out.skew = camera.skew * sx;
  out.cx = (camera.cx - from.x) * sx;
  out.fy = camera.fy * sy;
  out.cy = (camera.cy - from.y) * sy;
  return out;
}

std::vector<VideoViews> views_of(const fvv_configuration &configuration, const Selection &cameras,
                                 std::vector<std::string> *warnings) {
  std::vector<VideoViews> out;
  std::set<uint16_t> shown;
  for (size_t i = 0; i < configuration.video_count; i++) {
    VideoViews track = {&configuration.videos[i], {}};
    for (const fvv_tile &tile : tiles_of(configuration, *track.video, warnings)) {
      const bool is_atlas = tile.camera_id == no_camera;
      if (!is_atlas && !cameras.has(tile.camera_id)) continue;
      const std::string id = std::to_string(tile.camera_id);
      if (shown.insert(tile.camera_id).second)
        // Never from the camera's name: that is text from outside.
        track.views.push_back({tile, is_atlas ? "atlas" : "cam" + id});
      else
        tell(warnings, (is_atlas ? "the atlas" : "camera " + id) + " is shown again by track " +
                           std::to_string(track.video->track) + ": left out");
    }
    if (!track.views.empty()) out.push_back(track);
  }
  return out;
}

const fvv_track *mesh_track_of(const fvv_configuration &configuration, std::vector<std::string> *warnings) {
  const fvv_track *found = nullptr;
  for (size_t i = 0; i < configuration.track_count; i++) {
    const fvv_track &track = configuration.tracks[i];
    if (track.kind != FVV_TRACK_MESH) continue;
    if (!found)
      found = &track;
    else
      tell(warnings, "mesh track " + std::to_string(track.id) + " is left out: meshes are those of track " +
                         std::to_string(found->id));
  }
  return found;
}

} // namespace fvv::demux
