/* The layout of a video track in a group: that of its GTIL, else that of the configuration. What was decoded
 * last is kept for each track. */
#include "base/diagnostic.h"
#include "base/layout.h"
#include "container/file.h"
#include "stream/group_tiles.h"
#include "stream/stream.h"

typedef struct followed_tiles {
  uint16_t track;
  uint64_t chunk;  /* offset of the GTIL that was decoded last; 0: none */
  fvv_bytes tiles; /* fvv_tile */
} followed_tiles;

void fvv_stream_release_tiles(fvv_stream *stream) {
  followed_tiles *tracks = (followed_tiles *)stream->layouts.data;
  for (size_t i = 0; i < stream->layouts.size / sizeof *tracks; i++) fvv_bytes_free(&tracks[i].tiles);
  fvv_bytes_free(&stream->layouts);
}

/* A layout that was lost would leave no trace in the list of a group whose table is lost as well, and the
 * configuration's would be taken in its place. The continuity counter of a sample tells how many chunks of
 * the group stood in front of it. */
static fvv_status check_complete(fvv_stream *s, const fvv_chunk_info *first, const fvv_chunk_info *sample,
                                 fvv_diagnostic *diagnostic) {
  fvv_chunk_header header;
  const fvv_status status = fvv_file_load(s->file, sample->offset, &header, diagnostic);
  if (status < 0) return status;
  if (header.counter == (uint8_t)(sample - first + 1)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_CONTINUITY, FVV_CHUNK_VIDEO_PACKET, sample->offset,
                  "chunks in front of the first sample of track %u are missing: its layout may be among them",
                  sample->track);
}

/* The GTIL of the group; NULL: it has none. */
static fvv_status find_layout(fvv_stream *s, size_t group, uint16_t track, const fvv_chunk_info **layout,
                              fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *chunks, *sample = NULL;
  size_t count;
  *layout = NULL;
  const fvv_status status = fvv_file_group_chunks(s->file, group, &chunks, &count, diagnostic);
  if (status < 0) return status;
  for (size_t i = 0; i < count; i++) {
    if (chunks[i].track != track) continue;
    if (chunks[i].type == FVV_CHUNK_VIDEO_PACKET && !sample) sample = &chunks[i];
    if (chunks[i].type != FVV_CHUNK_GROUP_TILES) continue;
    if (*layout || sample)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_GROUP, FVV_CHUNK_GROUP_TILES,
                      chunks[i].offset, "layout of track %u is not the only one, or stands behind a sample",
                      track);
    *layout = &chunks[i];
  }
  if (*layout || !sample || fvv_file_group(s->file, group)->intact) return FVV_OK;
  return check_complete(s, chunks, sample, diagnostic);
}

fvv_status fvv_stream_tiles(fvv_stream *stream, size_t group, uint16_t track, const fvv_tile **tiles,
                            size_t *count, fvv_diagnostic *diagnostic) {
  *tiles = NULL;
  *count = 0;
  const fvv_configuration *configuration;
  fvv_status status = fvv_stream_configuration(stream, group, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_video_layout *video = fvv_configuration_video(configuration, track);
  if (!video || !video->tile_count) return FVV_END;
  const fvv_chunk_info *layout;
  status = find_layout(stream, group, track, &layout, diagnostic);
  if (status < 0) return status;
  if (!layout) {
    *tiles = video->tiles;
    *count = video->tile_count;
    return FVV_OK;
  }
  void *kept;
  status = fvv_stream_kept_of(stream, &stream->layouts, sizeof(followed_tiles), track, &kept);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, 0, "%s", fvv_status_text(status));
  followed_tiles *followed = kept;
  if (followed->chunk != layout->offset) {
    followed->chunk = 0;
    followed->tiles.allocator = stream->allocator;
    const uint8_t *payload;
    status = fvv_file_read_chunk(stream->file, layout, &payload, diagnostic);
    if (status < 0) return status;
    status = fvv_group_tiles_decode(configuration, track, payload, (size_t)layout->size, &stream->limits,
                                    &followed->tiles, diagnostic);
    if (status < 0) {
      fvv_fail(diagnostic, status, 0, FVV_CHUNK_GROUP_TILES, 0, "%s", fvv_status_text(status));
      fvv_diagnostic_rebase(diagnostic, layout->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_GROUP_TILES);
      return status;
    }
    followed->chunk = layout->offset;
  }
  *tiles = (const fvv_tile *)followed->tiles.data;
  *count = followed->tiles.size / sizeof(fvv_tile);
  return FVV_OK;
}
