#include "stream/mesh_frames.h"

#include <string.h>

#include "base/diagnostic.h"
#include "base/layout.h"

void fvv_mesh_frames_reset(fvv_mesh_frames *frames) {
  fvv_mesh_sequence_close(frames->sequence);
  fvv_mesh_free(&frames->key);
  memset(frames, 0, sizeof *frames);
}

fvv_status fvv_mesh_frames_check_flag(const fvv_mesh_header *header, int key, fvv_diagnostic *diagnostic) {
  if ((header->profile != FVV_MESH_DELTA) == (key != 0)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_KEY, FVV_CHUNK_MESH, FVV_MESH_PROFILE,
                  key ? "a delta frame in a chunk with the key flag"
                      : "a mesh of profile %u in a chunk without the key flag",
                  header->profile);
}

static fvv_status add(fvv_mesh_frames *frames, const uint8_t *payload, size_t size, int key,
                      const fvv_limits *limits, const fvv_allocator *allocator, fvv_diagnostic *diagnostic) {
  fvv_mesh_header header;
  fvv_status status = fvv_mesh_peek(payload, size, limits, &header, diagnostic);
  if (status == FVV_OK) status = fvv_mesh_frames_check_flag(&header, key, diagnostic);
  if (status != FVV_OK) return status;
  if (key) {
    fvv_mesh_frames_reset(frames);
    return fvv_mesh_decode(payload, size, limits, allocator, &frames->key, diagnostic);
  }
  if (!frames->key.positions)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_KEY, FVV_CHUNK_MESH, FVV_MESH_PROFILE,
                    "a delta frame without a key mesh of its track before it in the group");
  if (!frames->sequence)
    status = fvv_mesh_sequence_open(&frames->key, allocator, &frames->sequence, diagnostic);
  if (status != FVV_OK) return status;
  return fvv_mesh_sequence_decode(frames->sequence, payload, size, UINT32_MAX, diagnostic);
}

fvv_status fvv_mesh_frames_add(fvv_mesh_frames *frames, const uint8_t *payload, size_t size, int key,
                               const fvv_limits *limits, const fvv_allocator *allocator,
                               fvv_diagnostic *diagnostic) {
  const fvv_status status = add(frames, payload, size, key, limits, allocator, diagnostic);
  if (status != FVV_OK) fvv_mesh_frames_reset(frames);
  return status;
}

const fvv_mesh *fvv_mesh_frames_current(const fvv_mesh_frames *frames) {
  if (frames->sequence) return fvv_mesh_sequence_mesh(frames->sequence);
  return frames->key.positions ? &frames->key : NULL;
}
