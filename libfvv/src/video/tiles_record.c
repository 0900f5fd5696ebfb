/* video/tiles_record.c: the TILE payload (clause 10.2).
 *
 * Knows the bytes of one record; what makes a layout valid stands in tiles.c. Must not know the video frame's
 * size, which is in another chunk, or cameras. */
#include "video/tiles.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/limits.h"

#include <inttypes.h>

static void put_rect(uint8_t *p, const fvv_rect *rect) {
  fvv_put_u16(p, rect->x);
  fvv_put_u16(p + 2, rect->y);
  fvv_put_u16(p + 4, rect->width);
  fvv_put_u16(p + 6, rect->height);
}

static fvv_rect get_rect(const uint8_t *p) {
  const fvv_rect rect = {fvv_get_u16(p), fvv_get_u16(p + 2), fvv_get_u16(p + 4), fvv_get_u16(p + 6)};
  return rect;
}

fvv_status fvv_tiles_encode(const fvv_tile *tiles, size_t count, uint8_t *out, size_t capacity,
                            size_t *written, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *written = 0;
  const fvv_status status =
      fvv_tiles_check(tiles, count, UINT32_MAX, UINT32_MAX, FVV_ERROR_INPUT, diagnostic);
  if (status != FVV_OK) return status;
  *written = FVV_TILE_SIZE + count * FVV_TILE_ENTRY_SIZE;
  if (capacity < *written)
    return fvv_fail(diagnostic, FVV_ERROR_BUFFER_TOO_SMALL, 0, FVV_CHUNK_TILES, 0,
                    "the record needs %zu bytes, the buffer has %zu", *written, capacity);
  memset(out, 0, *written);
  fvv_put_u32(out + FVV_TILE_COUNT, (uint32_t)count);
  for (size_t i = 0; i < count; i++) {
    uint8_t *entry = out + FVV_TILE_SIZE + i * FVV_TILE_ENTRY_SIZE;
    fvv_put_u16(entry + FVV_TILE_ENTRY_CAMERA, tiles[i].camera_id);
    put_rect(entry + FVV_TILE_ENTRY_SOURCE, &tiles[i].source);
    put_rect(entry + FVV_TILE_ENTRY_DESTINATION, &tiles[i].destination);
  }
  return FVV_OK;
}

fvv_status fvv_tiles_decode(fvv_tile *tiles, size_t capacity, size_t *count, const uint8_t *payload,
                            size_t size, const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  const fvv_limits allowed = fvv_limits_or_default(limits);
  fvv_diagnostic_clear(diagnostic);
  *count = 0;
  if (size < FVV_TILE_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_PAYLOAD, FVV_CHUNK_TILES, 0,
                    "payload has %zu bytes, expected at least %d", size, FVV_TILE_SIZE);
  const uint32_t declared = fvv_get_u32(payload + FVV_TILE_COUNT);
  if (!declared || size != FVV_TILE_SIZE + (uint64_t)declared * FVV_TILE_ENTRY_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_PAYLOAD, FVV_CHUNK_TILES, FVV_TILE_COUNT,
                    "payload has %zu bytes for %" PRIu32
                    " tiles, expected at least one tile and %d bytes each",
                    size, declared, FVV_TILE_ENTRY_SIZE);
  if (declared > allowed.max_cameras)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_TILES, FVV_TILE_COUNT,
                    "%" PRIu32 " tiles, at most %" PRIu32 " cameras are allowed", declared,
                    allowed.max_cameras);
  if (fvv_get_u32(payload + FVV_TILE_RESERVED))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_PAYLOAD, FVV_CHUNK_TILES, FVV_TILE_RESERVED,
                    "reserved bytes are not 0");
  *count = declared;
  for (size_t i = 0; i < declared && i < capacity; i++) {
    const size_t offset = FVV_TILE_SIZE + i * FVV_TILE_ENTRY_SIZE;
    const uint8_t *entry = payload + offset;
    if (fvv_get_u16(entry + FVV_TILE_ENTRY_FLAGS) || fvv_get_u32(entry + FVV_TILE_ENTRY_RESERVED))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_PAYLOAD, FVV_CHUNK_TILES, offset,
                      "flags or reserved bytes of tile %zu are not 0", i);
    tiles[i].camera_id = fvv_get_u16(entry + FVV_TILE_ENTRY_CAMERA);
    tiles[i].source = get_rect(entry + FVV_TILE_ENTRY_SOURCE);
    tiles[i].destination = get_rect(entry + FVV_TILE_ENTRY_DESTINATION);
  }
  if (capacity < declared)
    return fvv_fail(diagnostic, FVV_ERROR_BUFFER_TOO_SMALL, 0, FVV_CHUNK_TILES, 0,
                    "there are %" PRIu32 " tiles, the array has room for %zu", declared, capacity);
  return fvv_tiles_check(tiles, declared, UINT32_MAX, UINT32_MAX, FVV_ERROR_INVALID, diagnostic);
}
