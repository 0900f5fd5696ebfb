/* Header and table of VISI payloads (clause 17.1). */
#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/limits.h"
#include "fvv/visibility.h"

static fvv_status read_header(const uint8_t *payload, size_t size, const fvv_limits *limits,
                              fvv_visibility_header *header, fvv_diagnostic *diagnostic) {
  if (size < FVV_VISI_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_PAYLOAD, FVV_CHUNK_VISIBILITY, size,
                    "the header has %d bytes, the payload %zu", FVV_VISI_SIZE, size);
  header->domain = payload[FVV_VISI_DOMAIN];
  header->threshold = payload[FVV_VISI_THRESHOLD];
  header->mesh_track = fvv_get_u16(payload + FVV_VISI_MESH_TRACK);
  header->element_count = fvv_get_u32(payload + FVV_VISI_ELEMENT_COUNT);
  header->number = fvv_get_u32(payload + FVV_VISI_NUMBER);
  header->camera_count = fvv_get_u32(payload + FVV_VISI_CAMERA_COUNT);
  if (header->domain > FVV_VISIBILITY_SHARES)
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_VISIBILITY_DOMAIN, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_DOMAIN, "domain %u, known are 0 to 2", header->domain);
  /* Two bytes of the table for each camera. */
  if (!header->camera_count || header->camera_count > (size - FVV_VISI_SIZE) / 2)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_SIZE, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_CAMERA_COUNT, "%lu cameras in a table of at most %zu bytes",
                    (unsigned long)header->camera_count, size - FVV_VISI_SIZE);
  if (header->camera_count > limits->max_cameras)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_VISIBILITY, FVV_VISI_CAMERA_COUNT,
                    "%lu cameras, the limit is %lu", (unsigned long)header->camera_count,
                    (unsigned long)limits->max_cameras);
  const uint32_t most = header->domain == FVV_VISIBILITY_FACES ? limits->max_faces : limits->max_vertices;
  if (header->element_count > most)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_ELEMENT_COUNT, "%lu elements, the limit is %lu",
                    (unsigned long)header->element_count, (unsigned long)most);
  return FVV_OK;
}

/* Fills streams, for which there is room, or passes over the table when it is NULL. */
static fvv_status read_table(const uint8_t *payload, size_t size, const fvv_visibility_header *header,
                             fvv_visibility_stream *streams, fvv_diagnostic *diagnostic) {
  fvv_cursor cursor = {payload, size, FVV_VISI_SIZE, 0};
  uint64_t camera = 0, all = 0;
  for (uint32_t i = 0; i < header->camera_count && !cursor.failed; i++) {
    const size_t place = cursor.position;
    const uint64_t more = fvv_cursor_uleb(&cursor), bytes = fvv_cursor_uleb(&cursor);
    if (cursor.failed) break;
    camera += more < FVV_NO_CAMERA ? more : FVV_NO_CAMERA;
    if (camera >= FVV_NO_CAMERA || (i && !more))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_CAMERA, FVV_CHUNK_VISIBILITY, place,
                      "camera %lu of the table does not rise from the one before, or is beyond 65534",
                      (unsigned long)i);
    const size_t taken = bytes <= size ? (size_t)bytes : size + 1;
    if (streams) streams[i] = (fvv_visibility_stream){(uint16_t)camera, (size_t)all, taken};
    all += taken;
  }
  if (cursor.failed || all != size - cursor.position)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_SIZE, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_SIZE, "the streams' sizes do not add up to the payload's");
  for (uint32_t i = 0; i < header->camera_count && streams; i++) streams[i].offset += cursor.position;
  return FVV_OK;
}

fvv_status fvv_visibility_peek(const uint8_t *payload, size_t size, const fvv_limits *limits,
                               fvv_visibility_header *header, fvv_visibility_stream *streams, size_t capacity,
                               fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *header = (fvv_visibility_header){0};
  const fvv_limits chosen = fvv_limits_or_default(limits);
  fvv_status status = read_header(payload, size, &chosen, header, diagnostic);
  if (status == FVV_OK && streams && capacity < header->camera_count)
    return fvv_fail(diagnostic, FVV_ERROR_BUFFER_TOO_SMALL, 0, FVV_CHUNK_VISIBILITY, FVV_VISI_CAMERA_COUNT,
                    "%lu cameras, room for %zu", (unsigned long)header->camera_count, capacity);
  if (status == FVV_OK) status = read_table(payload, size, header, streams, diagnostic);
  if (status != FVV_OK && status != FVV_ERROR_BUFFER_TOO_SMALL) *header = (fvv_visibility_header){0};
  return status;
}
