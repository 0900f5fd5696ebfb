/* Layouts of tiles: their rules, an arrangement that fits a frame, and the TILE payload (clause 10.2). */
#include <inttypes.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "fvv/video.h"

#define DESTINATION_MAX 65535 /* what the fields of a rectangle hold */

fvv_camera fvv_camera_of_tile(const fvv_camera *camera, const fvv_tile *tile) {
  const fvv_rect *from = &tile->source, *to = &tile->destination;
  const double sx = (double)to->width / from->width, sy = (double)to->height / from->height;
  fvv_camera out = *camera;
  out.width = to->width;
  out.height = to->height;
  out.fx = camera->fx * sx;
  out.skew = camera->skew * sx;
  out.cx = (camera->cx - from->x) * sx;
  out.fy = camera->fy * sy;
  out.cy = (camera->cy - from->y) * sy;
  return out;
}

static uint32_t aligned(uint32_t size) {
  return (size + FVV_TILE_ALIGNMENT - 1) / FVV_TILE_ALIGNMENT * FVV_TILE_ALIGNMENT;
}

static uint64_t entry_offset(size_t index, size_t field) {
  return FVV_TILE_SIZE + (uint64_t)index * FVV_TILE_ENTRY_SIZE + field;
}

static fvv_status check_sizes(const fvv_tile *tiles, size_t count, fvv_status status,
                              fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < count; i++) {
    const fvv_rect *s = &tiles[i].source, *d = &tiles[i].destination;
    if (!s->width || !s->height || !d->width || !d->height)
      return fvv_fail(diagnostic, status, FVV_ISSUE_TILE_RECT, FVV_CHUNK_TILES,
                      entry_offset(i, FVV_TILE_ENTRY_SOURCE),
                      "tile %zu shows %d x %d pixels in %d x %d, expected at least 1 x 1 each", i, s->width,
                      s->height, d->width, d->height);
  }
  return FVV_OK;
}

static fvv_status check_cameras(const fvv_tile *tiles, size_t count, fvv_status status,
                                fvv_diagnostic *diagnostic) {
  uint8_t seen[65536 / 8] = {0};
  for (size_t i = 0; i < count; i++) {
    const unsigned id = tiles[i].camera_id, bit = 1u << (id & 7);
    if (seen[id / 8] & bit)
      return fvv_fail(diagnostic, status, FVV_ISSUE_TILE_OVERLAP, FVV_CHUNK_TILES,
                      entry_offset(i, FVV_TILE_ENTRY_CAMERA),
                      "tile %zu is the second one of camera %u, expected one tile for each camera", i, id);
    seen[id / 8] |= (uint8_t)bit;
  }
  return FVV_OK;
}

static fvv_status check_places(const fvv_tile *tiles, size_t count, uint32_t frame_width,
                               uint32_t frame_height, fvv_status status, fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < count; i++) {
    const fvv_rect *d = &tiles[i].destination;
    const uint64_t offset = entry_offset(i, FVV_TILE_ENTRY_DESTINATION);
    if (d->x % FVV_TILE_ALIGNMENT || d->y % FVV_TILE_ALIGNMENT)
      return fvv_fail(diagnostic, status, FVV_ISSUE_TILE_RECT, FVV_CHUNK_TILES, offset,
                      "tile %zu is at (%d, %d), expected multiples of %d", i, d->x, d->y, FVV_TILE_ALIGNMENT);
    if ((uint32_t)d->x + d->width > frame_width || (uint32_t)d->y + d->height > frame_height)
      return fvv_fail(diagnostic, status, FVV_ISSUE_TILE_RECT, FVV_CHUNK_TILES, offset,
                      "tile %zu ends at (%d, %d), outside the frame of %" PRIu32 " x %" PRIu32, i,
                      d->x + d->width, d->y + d->height, frame_width, frame_height);
  }
  return FVV_OK;
}

static fvv_status check_overlaps(const fvv_tile *tiles, size_t count, fvv_status status,
                                 fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < count; i++) {
    const fvv_rect *d = &tiles[i].destination;
    const uint64_t offset = entry_offset(i, FVV_TILE_ENTRY_DESTINATION);
    for (size_t j = 0; j < i; j++) {
      const fvv_rect *o = &tiles[j].destination;
      if (d->x < o->x + o->width && o->x < d->x + d->width && d->y < o->y + o->height &&
          o->y < d->y + d->height)
        return fvv_fail(diagnostic, status, FVV_ISSUE_TILE_OVERLAP, FVV_CHUNK_TILES, offset,
                        "tile %zu at (%d, %d) overlaps tile %zu at (%d, %d)", i, d->x, d->y, j, o->x, o->y);
    }
  }
  return FVV_OK;
}

/* As fvv_tiles_validate, but does not clear the diagnostic. status: FVV_ERROR_INPUT while encoding, else
 * FVV_ERROR_INVALID. A frame of UINT32_MAX x UINT32_MAX means one whose size is not known. */
static fvv_status check_tiles(const fvv_tile *tiles, size_t count, uint32_t frame_width,
                              uint32_t frame_height, fvv_status status, fvv_diagnostic *diagnostic) {
  if (!count)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TILE_PAYLOAD, FVV_CHUNK_TILES, FVV_TILE_COUNT,
                    "0 tiles, expected at least one");
  fvv_status result = check_sizes(tiles, count, status, diagnostic);
  if (result == FVV_OK) result = check_places(tiles, count, frame_width, frame_height, status, diagnostic);
  /* Before the pairs are compared: it bounds count by the number of identifiers. */
  if (result == FVV_OK) result = check_cameras(tiles, count, status, diagnostic);
  if (result == FVV_OK) result = check_overlaps(tiles, count, status, diagnostic);
  return result;
}

fvv_status fvv_tiles_validate(const fvv_tile *tiles, size_t count, uint32_t frame_width,
                              uint32_t frame_height, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  return check_tiles(tiles, count, frame_width, frame_height, FVV_ERROR_INVALID, diagnostic);
}

/* ---- arrangement ------------------------------------------------------------------------------------ */

typedef struct extent {
  uint32_t width, height;
} extent;

/* Rows from left to right, in the order given; a tile that would pass width opens the next row, whose top is
 * below the tallest of this one. With place the tiles are moved there. Returns the extent used, and height 0
 * when it would exceed max. */
static extent shelve(const fvv_tile *tiles, size_t count, uint32_t width, uint32_t max, fvv_tile *place) {
  extent used = {0, 0};
  uint32_t x = 0, row = 0;
  for (size_t i = 0; i < count; i++) {
    const uint32_t w = aligned(tiles[i].destination.width), h = aligned(tiles[i].destination.height);
    if (x && x + w > width) {
      used.height += row;
      x = row = 0;
    }
    if (h > row) row = h;
    if (used.height + row > max) return (extent){0, 0};
    if (place) {
      place[i].destination.x = (uint16_t)x;
      place[i].destination.y = (uint16_t)used.height;
    }
    x += w;
    if (x > used.width) used.width = x;
  }
  used.height += row;
  return used;
}

/* Frames no longer than twice their other side come first, then small ones, then square ones. */
static int better(extent a, extent b) {
  if (!b.height) return 1;
  const uint64_t a_long = a.width > a.height ? a.width : a.height,
                 a_short = (uint64_t)a.width + a.height - a_long;
  const uint64_t b_long = b.width > b.height ? b.width : b.height,
                 b_short = (uint64_t)b.width + b.height - b_long;
  const int a_near = a_long <= 2 * a_short, b_near = b_long <= 2 * b_short;
  if (a_near != b_near) return a_near;
  const uint64_t a_area = a_long * a_short, b_area = b_long * b_short;
  if (a_near && a_area != b_area) return a_area < b_area;
  return a_long * b_short < b_long * a_short;
}

fvv_status fvv_tiles_arrange(fvv_tile *tiles, size_t count, uint32_t max_dimension, uint32_t *frame_width,
                             uint32_t *frame_height, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const uint32_t held = max_dimension < DESTINATION_MAX ? max_dimension : DESTINATION_MAX;
  const uint32_t max = held / FVV_TILE_ALIGNMENT * FVV_TILE_ALIGNMENT;
  if (!count)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_TILE_PAYLOAD, FVV_CHUNK_TILES, 0,
                    "0 tiles, expected at least one");
  fvv_status status = check_sizes(tiles, count, FVV_ERROR_INPUT, diagnostic);
  if (status == FVV_OK) status = check_cameras(tiles, count, FVV_ERROR_INPUT, diagnostic);
  if (status != FVV_OK) return status;

  uint32_t widest = 0;
  uint64_t total = 0, area = 0;
  for (size_t i = 0; i < count; i++) {
    const uint32_t w = aligned(tiles[i].destination.width), h = aligned(tiles[i].destination.height);
    if (w > max || h > max)
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, FVV_CHUNK_TILES, 0,
                      "the tile of camera %d takes %" PRIu32 " x %" PRIu32
                      " pixels, a frame can have at most %" PRIu32 " a side",
                      tiles[i].camera_id, w, h, max);
    if (w > widest) widest = w;
    total += w;
    area += (uint64_t)w * h;
  }
  extent best = {0, 0};
  const uint32_t last = total < max ? (uint32_t)total : max;
  if (area <= (uint64_t)max * max)
    for (uint32_t width = widest; width <= last; width += FVV_TILE_ALIGNMENT) {
      const extent used = shelve(tiles, count, width, max, NULL);
      if (used.height && better(used, best)) best = used;
    }
  if (!best.height)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, FVV_CHUNK_TILES, 0,
                    "%zu tiles of together %" PRIu64 " pixels do not fit a frame of %" PRIu32 " x %" PRIu32
                    " in rows: make them smaller",
                    count, area, max, max);
  shelve(tiles, count, best.width, max, tiles);
  *frame_width = best.width;
  *frame_height = best.height;
  return FVV_OK;
}

/* ---- the TILE payload ------------------------------------------------------------------------------- */

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
  fvv_status status = fvv_readable_check(count, fvv_limits_or_default(NULL).max_cameras, "tiles",
                                         FVV_CHUNK_TILES, diagnostic);
  if (status == FVV_OK)
    status = check_tiles(tiles, count, UINT32_MAX, UINT32_MAX, FVV_ERROR_INPUT, diagnostic);
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
  return check_tiles(tiles, declared, UINT32_MAX, UINT32_MAX, FVV_ERROR_INVALID, diagnostic);
}
