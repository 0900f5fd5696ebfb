#include "fvv_demux/views.h"
#include "fvv_media/frame.h"
#include "fvv_media/image.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace fvv::demux {

namespace {

void tell(std::vector<std::string> *warnings, const std::string &text) {
  if (warnings) warnings->push_back(text);
}

std::vector<fvv_tile> tiles_of(const fvv_video_layout &video, std::vector<std::string> *warnings) {
  const fvv_video_config &config = video.config;
  std::vector<fvv_tile> tiles;
  if (config.shows == FVV_SHOWS_TILES) {
    tiles.assign(video.tiles, video.tiles + video.tile_count);
    return tiles;
  }
  if (config.width <= UINT16_MAX && config.height <= UINT16_MAX) {
    const fvv_rect whole = {0, 0, uint16_t(config.width), uint16_t(config.height)};
    return {{no_camera, whole, whole}};
  }
  tell(warnings, "track " + std::to_string(video.track) + ": its atlas of " + std::to_string(config.width) +
                     "x" + std::to_string(config.height) +
                     " pixels is left out, which has more than 65535 on a side");
  return {};
}

// None if no picture file can hold it.
std::optional<fvv_tile> whole_of(const fvv_configuration &configuration, const fvv_tile &tile) {
  const fvv_camera *camera = fvv_configuration_camera(&configuration, tile.camera_id);
  if (!camera) return tile;
  const auto side = [](uint32_t picture, uint32_t source, uint32_t destination) {
    return std::max(1.0, std::round(double(picture) * destination / source));
  };
  const double width = side(camera->width, tile.source.width, tile.destination.width),
               height = side(camera->height, tile.source.height, tile.destination.height);
  if (std::max({width, height, double(camera->width), double(camera->height)}) > media::max_dimension)
    return {};
  return fvv_tile{tile.camera_id,
                  {0, 0, uint16_t(camera->width), uint16_t(camera->height)},
                  {0, 0, uint16_t(width), uint16_t(height)}};
}

} // namespace

std::vector<VideoViews> views_of(const fvv_configuration &configuration, size_t rung,
                                 const Selection &cameras, std::vector<std::string> *warnings) {
  std::vector<VideoViews> out;
  std::set<uint16_t> shown;
  for (size_t i = 0; i < configuration.video_count; i++) {
    if (!in_rung(configuration, configuration.videos[i].track, rung)) continue;
    VideoViews track = {&configuration.videos[i], {}};
    for (const fvv_tile &tile : tiles_of(*track.video, warnings)) {
      const bool is_atlas = tile.camera_id == no_camera;
      if (!is_atlas && !cameras.has(tile.camera_id)) continue;
      const std::string id = std::to_string(tile.camera_id);
      const std::optional<fvv_tile> whole = whole_of(configuration, tile);
      if (!whole)
        tell(warnings, "camera " + id + " is left out: a side of its picture would have more than " +
                           std::to_string(media::max_dimension) + " pixels");
      else if (shown.insert(tile.camera_id).second)
        // Not from the camera's name, which is untrusted text.
        track.views.push_back({tile, is_atlas ? "atlas" : "cam" + id, *whole});
      else
        tell(warnings, (is_atlas ? "the atlas" : "camera " + id) + " is shown again by track " +
                           std::to_string(track.video->track) + ": left out");
    }
    if (!track.views.empty()) out.push_back(track);
  }
  return out;
}

fvv_status tile_in_group(fvv_stream *stream, size_t group, const fvv_video_layout &video, const View &view,
                         std::optional<fvv_tile> &tile, fvv_diagnostic &diagnostic) {
  tile.reset();
  if (video.config.shows != FVV_SHOWS_TILES) {
    tile = view.tile;
    return FVV_OK;
  }
  const fvv_tile *tiles = nullptr;
  size_t count = 0;
  const fvv_status status = fvv_stream_tiles(stream, group, video.track, &tiles, &count, &diagnostic);
  for (size_t i = 0; i < count; i++)
    if (tiles[i].camera_id == view.tile.camera_id) tile = tiles[i];
  return status;
}

uint64_t decoding_memory(const std::string &where, const std::vector<VideoViews> &tracks,
                         const media::MemoryLimit &limit) {
  uint64_t bytes = 0;
  for (const VideoViews &track : tracks) {
    bytes += media::decoding_memory(track.video->config);
    media::check_memory(where + ": track " + std::to_string(track.video->track) + ": decoding " +
                            std::to_string(track.video->config.width) + " x " +
                            std::to_string(track.video->config.height) + " pixels" +
                            (&track == tracks.data() ? "" : " and the tracks before it"),
                        bytes, limit);
  }
  return bytes;
}

const fvv_track *mesh_track_of(const fvv_configuration &configuration, size_t rung,
                               std::vector<std::string> *warnings) {
  const fvv_track *found = nullptr;
  for (size_t i = 0; i < configuration.track_count; i++) {
    const fvv_track &track = configuration.tracks[i];
    if (track.kind != FVV_TRACK_MESH || !in_rung(configuration, track.id, rung)) continue;
    if (!found)
      found = &track;
    else
      tell(warnings, "mesh track " + std::to_string(track.id) + " is left out: meshes are those of track " +
                         std::to_string(found->id));
  }
  return found;
}

namespace {

// One axis of a pixel of the whole picture: the two pixels of the tile around its centre, and the weight of
// the second. None outside of the tile.
struct Tap {
  bool inside;
  uint32_t first, second;
  double share;
};

std::vector<Tap> taps_of(uint32_t picture, uint32_t size, uint32_t source, uint32_t source_size,
                         uint32_t destination_size) {
  std::vector<Tap> taps(size);
  for (uint32_t i = 0; i < size; i++) {
    // Of the tile's pixels, in 1/(2 size) of the picture's: exact, so that pixels that are the same are found
    // to be.
    const int64_t centre = int64_t(2 * i + 1) * picture - int64_t(2) * size * source;
    const double at = double(centre * destination_size) / double(int64_t(2) * size * source_size);
    const double low = std::floor(at - 0.5);
    const auto clamped = [&](double k) { return uint32_t(std::clamp(k, 0.0, double(destination_size - 1))); };
    taps[i] = {centre >= 0 && at < destination_size, clamped(low), clamped(low + 1), at - 0.5 - low};
  }
  return taps;
}

} // namespace

template <class Sample>
media::BasicImage<Sample> whole_picture(const media::BasicImage<Sample> &frame, const fvv_tile *tile,
                                        const fvv_tile &whole) {
  const fvv_rect &to = whole.destination;
  media::BasicImage<Sample> out =
      media::make_image<Sample>(to.width, to.height, frame.channels, media::flat_grey_of<Sample>);
  if (!tile) return out;
  const media::BasicImage<Sample> part = media::extract(frame, *tile);
  const std::vector<Tap> columns = taps_of(whole.source.width, to.width, tile->source.x, tile->source.width,
                                           tile->destination.width),
                         rows = taps_of(whole.source.height, to.height, tile->source.y, tile->source.height,
                                        tile->destination.height);
  const size_t channels = size_t(frame.channels);
  constexpr double rounding = std::is_floating_point_v<Sample> ? 0 : 0.5;
  for (size_t y = 0; y < to.height; y++)
    for (size_t x = 0; x < to.width; x++) {
      const Tap &row = rows[y], &column = columns[x];
      if (!row.inside || !column.inside) continue;
      for (size_t c = 0; c < channels; c++) {
        const auto at = [&](size_t v, size_t u) {
          return double(part.pixels[(v * part.width + u) * channels + c]);
        };
        const double above = at(row.first, column.first) * (1 - column.share) +
                             at(row.first, column.second) * column.share,
                     below = at(row.second, column.first) * (1 - column.share) +
                             at(row.second, column.second) * column.share;
        out.pixels[(y * to.width + x) * channels + c] =
            Sample(above * (1 - row.share) + below * row.share + rounding);
      }
    }
  return out;
}

template media::Image whole_picture(const media::Image &, const fvv_tile *, const fvv_tile &);
template media::DeepImage whole_picture(const media::DeepImage &, const fvv_tile *, const fvv_tile &);
template media::LinearImage whole_picture(const media::LinearImage &, const fvv_tile *, const fvv_tile &);

} // namespace fvv::demux
