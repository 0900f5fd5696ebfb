#include "stream/check_mesh.h"

#include "base/diagnostic.h"
#include "base/layout.h"

/* Where a group's beginning was lost, its meshes are compared with none. */
static fvv_status compare_attributes(fvv_checked_mesh *mesh, const fvv_event *event,
                                     const fvv_mesh_header *header, fvv_diagnostic *diagnostic) {
  if (!event->group_intact) return FVV_OK;
  if (!mesh->has_first) {
    mesh->has_first = 1;
    mesh->texture_bits = header->texture_bits;
    mesh->normal_bits = header->normal_bits;
  }
  if (mesh->texture_bits != header->texture_bits)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_TEXTURE_GROUP, FVV_CHUNK_MESH,
                    FVV_MESH_TEXTURE_BITS,
                    "%u texture bits, the first mesh of the track in this group has %u", header->texture_bits,
                    mesh->texture_bits);
  if (mesh->normal_bits == header->normal_bits) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_NORMAL_GROUP, FVV_CHUNK_MESH,
                  FVV_MESH_NORMAL_BITS, "%u normal bits, the first mesh of the track in this group has %u",
                  header->normal_bits, mesh->normal_bits);
}

static fvv_status judge_content(fvv_checked_mesh *mesh, const fvv_event *event, const fvv_limits *limits,
                                const fvv_allocator *allocator, int *whole, fvv_diagnostic *diagnostic) {
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  /* Behind damage it is not known what is missing; a delta frame in vain is not one problem more. */
  const int has_key = fvv_mesh_frames_current(&mesh->frames) != NULL;
  if (!key && (mesh->lost || (!has_key && !event->group_intact))) {
    *whole = 0;
    return FVV_OK;
  }
  fvv_diagnostic why = {0};
  const fvv_status status = fvv_mesh_frames_add(&mesh->frames, event->payload, (size_t)event->chunk.size, key,
                                                limits, allocator, &why);
  mesh->lost = status != FVV_OK;
  mesh->time = event->chunk.time;
  if (status == FVV_OK) return FVV_OK;
  if (why.issue == FVV_ISSUE_DELTA_NUMBER && !event->group_intact) {
    *whole = 0;
    return FVV_OK;
  }
  *diagnostic = why;
  return status;
}

fvv_status fvv_check_mesh(fvv_checked_mesh *mesh, const fvv_event *event, uint64_t group, int decode,
                          const fvv_limits *limits, const fvv_allocator *allocator, fvv_mesh_header *header,
                          int *whole, fvv_diagnostic *diagnostic) {
  if (mesh->group != group) {
    fvv_mesh_frames_reset(&mesh->frames);
    mesh->group = group;
    mesh->has_first = mesh->lost = 0;
  }
  fvv_status status = fvv_mesh_peek(event->payload, (size_t)event->chunk.size, limits, header, diagnostic);
  if (status == FVV_OK) status = compare_attributes(mesh, event, header, diagnostic);
  if (status == FVV_OK)
    status = fvv_mesh_frames_check_flag(header, event->chunk.flags & FVV_FLAG_KEY, diagnostic);
  if (status == FVV_OK && decode) return judge_content(mesh, event, limits, allocator, whole, diagnostic);
  if (status != FVV_OK) mesh->lost = 1;
  return status;
}
