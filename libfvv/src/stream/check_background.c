#include "stream/check_background.h"

#include "base/diagnostic.h"

static fvv_status judge_meshes(const fvv_background *background, const fvv_limits *limits,
                               const fvv_allocator *allocator, fvv_diagnostic *diagnostic) {
  fvv_status status = FVV_OK;
  for (size_t i = 0; i < background->part_count && status == FVV_OK; i++) {
    fvv_mesh mesh;
    status = fvv_background_mesh(background, i, limits, allocator, &mesh, diagnostic);
    fvv_mesh_free(&mesh);
  }
  return status;
}

static void count(const fvv_background *background, fvv_track_summary *counts) {
  counts->parts = (uint32_t)background->part_count;
  counts->pictures = (uint32_t)background->picture_count;
  counts->lights = (uint32_t)background->light_count;
  counts->vertices = counts->faces = 0;
  for (size_t i = 0; i < background->part_count; i++) {
    const fvv_background_part *part = &background->parts[i];
    fvv_mesh_header header;
    if (fvv_mesh_peek(part->mesh, part->mesh_size, NULL, &header, NULL) != FVV_OK) continue;
    counts->vertices += header.vertex_count;
    counts->faces += header.face_count;
  }
}

fvv_status fvv_check_background(fvv_checked_background *background, const fvv_event *event, uint32_t digest,
                                int decode, const fvv_limits *limits, const fvv_allocator *allocator,
                                fvv_track_summary *counts, fvv_diagnostic *diagnostic) {
  const fvv_chunk_header *chunk = &event->chunk;
  if (!(chunk->flags & FVV_FLAG_KEY))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_BACKGROUND_KEY, FVV_CHUNK_BACKGROUND, 0,
                    "the chunk does not have the key flag");
  const int repeats = background->size && background->digest == digest;
  const int same = background->size == chunk->size && background->crc == chunk->payload_crc;
  if (repeats && same) return FVV_OK;
  background->size = chunk->size;
  background->crc = chunk->payload_crc;
  background->digest = digest;
  if (repeats)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_BACKGROUND_SAME, FVV_CHUNK_BACKGROUND, 0,
                    "track %u has another background than before under the same configuration", chunk->track);
  fvv_background decoded;
  fvv_status status =
      fvv_background_decode(event->payload, (size_t)chunk->size, limits, allocator, &decoded, diagnostic);
  if (status != FVV_OK) return status;
  count(&decoded, counts);
  if (decode) status = judge_meshes(&decoded, limits, allocator, diagnostic);
  fvv_background_free(&decoded);
  return status;
}
