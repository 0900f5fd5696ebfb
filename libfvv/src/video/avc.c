/* video/avc.c: H.264 as MP4 stores it: configuration record and length-prefixed samples (clause 10.5).
 *
 * Knows the frame around NAL units by ISO/IEC 14496-15 and the one header byte of ITU-T H.264 clause 7.3.1;
 * must not parse what is inside them. Decoders do. */
#include "video/avc.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

#include <inttypes.h>
#include <stdio.h>

enum { NAL_SLICE_IDR = 5, NAL_SPS = 7, NAL_PPS = 8, NAL_SPS_EXTENSION = 13 };

/* Big-endian, as everything in MP4. */
static uint32_t get_be32(const uint8_t *p) {
  return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

typedef struct report {
  fvv_status status;
  uint64_t base;
  fvv_diagnostic *diagnostic;
} report;

static fvv_status wrong(const report *to, size_t offset, const char *what, unsigned found,
                        unsigned expected) {
  return fvv_fail(to->diagnostic, to->status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG,
                  to->base + offset, "H.264 record: %s is %u, expected %u", what, found, expected);
}

static fvv_status ends(const report *to, const fvv_cursor *cursor, const char *in) {
  return fvv_fail(to->diagnostic, to->status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG,
                  to->base + cursor->position, "H.264 record of %zu bytes ends within %s", cursor->size, in);
}

/* count units of one type with 2-byte lengths. */
static fvv_status check_units(const report *to, fvv_cursor *cursor, unsigned count, unsigned type,
                              size_t least) {
  for (unsigned i = 0; i < count; i++) {
    const uint8_t *length = fvv_cursor_take(cursor, 2);
    if (!length) return ends(to, cursor, "the length of a parameter set");
    const size_t size = (size_t)length[0] << 8 | length[1], offset = cursor->position;
    if (size < least)
      return wrong(to, offset - 2, "the length of a parameter set", (unsigned)size, (unsigned)least);
    const uint8_t *unit = fvv_cursor_take(cursor, size);
    if (!unit) return ends(to, cursor, "a parameter set");
    if (unit[0] & 0x80) return wrong(to, offset, "the forbidden bit of a parameter set", 1, 0);
    if ((unit[0] & 31) != type) return wrong(to, offset, "the type of a parameter set", unit[0] & 31u, type);
  }
  return FVV_OK;
}

/* Clause 5.3.3.1.2 lets profiles other than Baseline, Main and Extended say more; old writers leave it out.
 */
static fvv_status check_extension(const report *to, fvv_cursor *cursor, unsigned profile) {
  const size_t offset = cursor->position;
  if (offset == cursor->size) return FVV_OK;
  if (profile == 66 || profile == 77 || profile == 88)
    return wrong(to, offset, "the number of bytes behind the parameter sets",
                 (unsigned)(cursor->size - offset), 0);
  const uint8_t *p = fvv_cursor_take(cursor, 4);
  if (!p) return ends(to, cursor, "the chroma format and bit depths");
  if (p[0] >> 2 != 63) return wrong(to, offset, "the reserved bits before the chroma format", p[0] >> 2, 63);
  for (size_t i = 1; i < 3; i++)
    if (p[i] >> 3 != 31) return wrong(to, offset + i, "the reserved bits before a bit depth", p[i] >> 3, 31);
  const fvv_status status = check_units(to, cursor, p[3], NAL_SPS_EXTENSION, 2);
  if (status != FVV_OK) return status;
  if (cursor->position != cursor->size)
    return wrong(to, cursor->position, "the number of bytes behind the last parameter set",
                 (unsigned)(cursor->size - cursor->position), 0);
  return FVV_OK;
}

fvv_status fvv_avc_record_inspect(const uint8_t *record, size_t size, fvv_status status, uint64_t base,
                                  fvv_diagnostic *diagnostic) {
  const report to = {status, base, diagnostic};
  fvv_cursor cursor = {record, size, 0, 0};
  const uint8_t *p = fvv_cursor_take(&cursor, 6);
  if (!p) return ends(&to, &cursor, "its first 6 bytes");
  if (p[0] != 1) return wrong(&to, 0, "the version", p[0], 1);
  if (p[4] >> 2 != 63) return wrong(&to, 4, "the reserved bits before lengthSizeMinusOne", p[4] >> 2, 63);
  if ((p[4] & 3) != 3) return wrong(&to, 4, "lengthSizeMinusOne", p[4] & 3u, 3);
  if (p[5] >> 5 != 7) return wrong(&to, 5, "the reserved bits before the number of SPS", p[5] >> 5, 7);
  if (!(p[5] & 31)) return wrong(&to, 5, "the number of SPS", 0, 1);
  /* An SPS repeats the three bytes of profile, compatibility and level behind its header. */
  fvv_status result = check_units(&to, &cursor, p[5] & 31, NAL_SPS, 4);
  if (result != FVV_OK) return result;
  const size_t offset = cursor.position;
  const uint8_t *count = fvv_cursor_take(&cursor, 1);
  if (!count) return ends(&to, &cursor, "the number of PPS");
  if (!*count) return wrong(&to, offset, "the number of PPS", 0, 1);
  result = check_units(&to, &cursor, *count, NAL_PPS, 2);
  return result != FVV_OK ? result : check_extension(&to, &cursor, p[1]);
}

fvv_status fvv_avc_record_check(const uint8_t *record, size_t size, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  return fvv_avc_record_inspect(record, size, FVV_ERROR_INVALID, 0, diagnostic);
}

void fvv_avc_codec_string(const uint8_t *record, char out[FVV_AVC_CODEC_STRING_SIZE + 1]) {
  snprintf(out, FVV_AVC_CODEC_STRING_SIZE + 1, "avc1.%02x%02x%02x", record[1], record[2], record[3]);
}

fvv_status fvv_avc_sample_inspect(int key, const uint8_t *sample, size_t size, fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_SAMPLE_AVC, type = FVV_CHUNK_VIDEO_PACKET;
  int idr = 0;
  size_t position = 0;
  if (!size)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, 0,
                    "H.264 sample has 0 bytes, expected a NAL unit");
  while (position < size) {
    const size_t left = size - position;
    if (left < 4)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, position,
                      "%zu bytes follow the last NAL unit, expected none or a 4-byte length", left);
    const uint32_t length = get_be32(sample + position);
    if (!length || length > left - 4)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, position,
                      "NAL unit of %" PRIu32 " bytes, expected 1 to %zu", length, left - 4);
    const uint8_t header = sample[position + 4];
    if (header & 0x80)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, position + 4,
                      "NAL unit header is 0x%02x, expected its first bit to be 0", header);
    idr |= (header & 31) == NAL_SLICE_IDR;
    position += 4 + (size_t)length;
  }
  if (idr != !!key)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, 0,
                    "%s sample has %s IDR picture, expected %s", key ? "key" : "non-key", idr ? "an" : "no",
                    key ? "one" : "none");
  return FVV_OK;
}
