/* What stands in front of a delta payload's levels (clause 8.7), against the sequence that it goes on with.
 */
#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "mesh/delta_payload.h"

fvv_status fvv_delta_read_header(const fvv_mesh_sequence *s, const uint8_t *payload, size_t size,
                                 fvv_delta_frame *frame, fvv_diagnostic *diagnostic) {
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = limits.max_faces = UINT32_MAX; /* the key has passed the caller's */
  fvv_mesh_header header;
  fvv_status status = fvv_mesh_peek(payload, size, &limits, &header, diagnostic);
  if (status != FVV_OK) return status;
  if (header.profile != FVV_MESH_DELTA)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, FVV_CHUNK_MESH, FVV_MESH_PROFILE,
                    "a mesh of profile %u begins a sequence, it does not go on with one", header.profile);
  if (header.vertex_count != s->mesh.vertex_count || header.face_count != s->mesh.face_count ||
      header.texture_bits != s->mesh.texture_bits || header.normal_bits != s->mesh.normal_bits)
    return fvv_fail(
        diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_KEY, FVV_CHUNK_MESH, FVV_MESH_VERTEX_COUNT,
        "%lu vertices, %lu faces, %u texture and %u normal bits, the key mesh has %lu, %lu, %u and %u",
        (unsigned long)header.vertex_count, (unsigned long)header.face_count, header.texture_bits,
        header.normal_bits, (unsigned long)s->mesh.vertex_count, (unsigned long)s->mesh.face_count,
        s->mesh.texture_bits, s->mesh.normal_bits);
  fvv_cursor cursor = {payload, size, FVV_MESH_SIZE, 0};
  const uint64_t number = fvv_cursor_uleb(&cursor), levels = fvv_cursor_uleb(&cursor);
  if (!cursor.failed && number != (uint64_t)s->frame + 1)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_NUMBER, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "delta frame %llu behind frame %lu of the group: frames are missing",
                    (unsigned long long)number, (unsigned long)s->frame);
  if (!cursor.failed && levels != s->hierarchy.level_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_LEVELS, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "%llu levels, the key mesh has %lu", (unsigned long long)levels,
                    (unsigned long)s->hierarchy.level_count);
  uint64_t all = 0;
  for (uint32_t k = 0; k < s->hierarchy.level_count && !cursor.failed; k++) {
    const uint64_t step = fvv_cursor_uleb(&cursor), bytes = fvv_cursor_uleb(&cursor);
    if (!cursor.failed && (step < 1 || step > FVV_DELTA_STEP_MAX))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_LEVELS, FVV_CHUNK_MESH, cursor.position,
                      "level %lu has a step of %llu, steps are 1 to 262143", (unsigned long)k,
                      (unsigned long long)step);
    frame->level[k].step = (uint32_t)step;
    frame->level[k].size = bytes <= size ? (size_t)bytes : size + 1;
    all += frame->level[k].size;
  }
  if (cursor.failed || all != size - cursor.position)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_SIZE, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "the levels' sizes do not add up to the payload's");
  size_t offset = cursor.position;
  for (uint32_t k = 0; k < s->hierarchy.level_count; k++) {
    frame->level[k].offset = offset;
    offset += frame->level[k].size;
  }
  return FVV_OK;
}
