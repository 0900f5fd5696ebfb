/* video/nal.c: see nal.h. */
#include "video/nal.h"
#include "base/diagnostic.h"

#include <inttypes.h>

/* Big-endian, as everything in MP4. */
static uint32_t get_be32(const uint8_t *p) {
  return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

fvv_status fvv_nal_next(fvv_nal_walk *walk, const uint8_t **unit, size_t *size) {
  const uint32_t type = FVV_CHUNK_VIDEO_PACKET;
  const size_t position = walk->position, left = walk->size - position;
  if (!walk->size)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, 0,
                    "%s sample has 0 bytes, expected a NAL unit", walk->codec);
  if (!left) return FVV_END;
  if (left < 4)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, position,
                    "%zu bytes follow the last NAL unit, expected none or a 4-byte length", left);
  const uint32_t length = get_be32(walk->sample + position);
  if (length < walk->least || length > left - 4)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, position,
                    "NAL unit of %" PRIu32 " bytes, expected %zu to %zu", length, walk->least, left - 4);
  const uint8_t header = walk->sample[position + 4];
  if (header & 0x80)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, position + 4,
                    "NAL unit header is 0x%02x, expected its first bit to be 0", header);
  *unit = walk->sample + position + 4;
  *size = length;
  walk->position = position + 4 + (size_t)length;
  return FVV_OK;
}
