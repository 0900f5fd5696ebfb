#include "stream/group_tiles.h"

#include "base/diagnostic.h"
#include "base/layout.h"
#include "stream/configuration.h"

static int shows(const fvv_video_layout *video, uint16_t camera) {
  for (size_t i = 0; i < video->tile_count; i++)
    if (video->tiles[i].camera_id == camera) return 1;
  return 0;
}

static fvv_status decode(const fvv_configuration *configuration, uint16_t track, const uint8_t *payload,
                         size_t size, const fvv_limits *limits, fvv_bytes *tiles,
                         fvv_diagnostic *diagnostic) {
  tiles->size = 0;
  const fvv_video_layout *video = fvv_configuration_video(configuration, track);
  if (!video || video->config.shows != FVV_SHOWS_TILES)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_SHOWN, FVV_CHUNK_GROUP_TILES, 0,
                    "track %u shows no tiles", track);
  /* No more tiles than the payload has bytes for. */
  const size_t most = size / FVV_TILE_ENTRY_SIZE;
  fvv_status status = fvv_bytes_reserve(tiles, most * sizeof(fvv_tile));
  if (status < 0) return status;
  size_t count = 0;
  status = fvv_tiles_decode((fvv_tile *)tiles->data, most, &count, payload, size, limits, diagnostic);
  const fvv_tile *decoded = (const fvv_tile *)tiles->data;
  for (size_t i = 0; i < count && status == FVV_OK; i++)
    if (!shows(video, decoded[i].camera_id))
      status = fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_SHOWN, FVV_CHUNK_GROUP_TILES,
                        FVV_TILE_SIZE + i * FVV_TILE_ENTRY_SIZE,
                        "tile %zu shows camera %u, which is not in the TILE of track %u", i,
                        decoded[i].camera_id, track);
  if (status == FVV_OK)
    status = fvv_configuration_check_tiles(configuration, video, decoded, count, diagnostic);
  if (status == FVV_OK) tiles->size = count * sizeof(fvv_tile);
  return status;
}

fvv_status fvv_group_tiles_decode(const fvv_configuration *configuration, uint16_t track,
                                  const uint8_t *payload, size_t size, const fvv_limits *limits,
                                  fvv_bytes *tiles, fvv_diagnostic *diagnostic) {
  const fvv_status status = decode(configuration, track, payload, size, limits, tiles, diagnostic);
  if (status < 0 && diagnostic) diagnostic->chunk_type = FVV_CHUNK_GROUP_TILES;
  return status;
}

static void count_tiles(fvv_track_summary *summary, const fvv_bytes *decoded) {
  const fvv_tile *tiles = (const fvv_tile *)decoded->data;
  uint64_t pixels = 0;
  for (size_t i = 0; i < decoded->size / sizeof *tiles; i++)
    pixels += (uint64_t)tiles[i].destination.width * tiles[i].destination.height;
  if (!summary->layouts || pixels < summary->least_tile_pixels) summary->least_tile_pixels = pixels;
  if (pixels > summary->most_tile_pixels) summary->most_tile_pixels = pixels;
  summary->layouts++;
}

fvv_status fvv_check_group_tiles(fvv_checked_tiles *checked, const fvv_event *event, uint64_t group,
                                 const fvv_configuration *configuration, const fvv_limits *limits,
                                 const fvv_allocator *allocator, fvv_track_summary *summary,
                                 fvv_diagnostic *diagnostic) {
  fvv_bytes tiles = {NULL, 0, 0, *allocator};
  const fvv_status status = fvv_group_tiles_decode(configuration, event->chunk.track, event->payload,
                                                   (size_t)event->chunk.size, limits, &tiles, diagnostic);
  if (status == FVV_OK)
    count_tiles(summary, &tiles);
  else
    checked->lost_in = group;
  fvv_bytes_free(&tiles);
  return status;
}
