/* video/avc.c: H.264 as MP4 stores it: configuration record and length-prefixed samples (clause 10.5).
 *
 * Only the framing of NAL units (ISO/IEC 14496-15) and their header byte (ITU-T H.264 clause 7.3.1) are read.
 * The rest is up to decoders. */
#include "base/diagnostic.h"
#include "video/codecs.h"

#include <stdio.h>

enum { NAL_SLICE_IDR = 5, NAL_SPS = 7, NAL_PPS = 8, NAL_SPS_EXTENSION = 13 };

static fvv_status check_units(const fvv_record_report *to, fvv_cursor *cursor, unsigned count, unsigned type,
                              size_t least) {
  const fvv_parameter_sets sets = {count, type, 0, 31, least};
  return fvv_record_parameter_sets(to, cursor, &sets);
}

/* Clause 5.3.3.1.2 has further fields for profiles other than Baseline, Main and Extended; old writers omit
 * them. */
static fvv_status check_extension(const fvv_record_report *to, fvv_cursor *cursor, unsigned profile) {
  const size_t offset = cursor->position;
  if (offset == cursor->size) return FVV_OK;
  if (profile == 66 || profile == 77 || profile == 88)
    return fvv_record_wrong(to, offset, "the number of bytes after the parameter sets",
                            (unsigned)(cursor->size - offset), 0);
  const uint8_t *p = fvv_cursor_take(cursor, 4);
  if (!p) return fvv_record_ends(to, cursor, "the chroma format and bit depths");
  if (p[0] >> 2 != 63)
    return fvv_record_wrong(to, offset, "the reserved bits before the chroma format", p[0] >> 2, 63);
  for (size_t i = 1; i < 3; i++)
    if (p[i] >> 3 != 31)
      return fvv_record_wrong(to, offset + i, "the reserved bits before a bit depth", p[i] >> 3, 31);
  if (p[2] != p[1])
    return fvv_record_wrong(to, offset + 2, "the bit depth of chroma", 8 + (p[2] & 7u), 8 + (p[1] & 7u));
  const fvv_status status = check_units(to, cursor, p[3], NAL_SPS_EXTENSION, 2);
  if (status != FVV_OK) return status;
  if (cursor->position != cursor->size)
    return fvv_record_wrong(to, cursor->position, "the number of bytes after the last parameter set",
                            (unsigned)(cursor->size - cursor->position), 0);
  return FVV_OK;
}

static fvv_status record_inspect(const fvv_record_report *to, const uint8_t *record, size_t size) {
  fvv_cursor cursor = {record, size, 0, 0};
  const uint8_t *p = fvv_cursor_take(&cursor, 6);
  if (!p) return fvv_record_ends(to, &cursor, "its first 6 bytes");
  if (p[0] != 1) return fvv_record_wrong(to, 0, "the version", p[0], 1);
  if (p[4] >> 2 != 63)
    return fvv_record_wrong(to, 4, "the reserved bits before lengthSizeMinusOne", p[4] >> 2, 63);
  if ((p[4] & 3) != 3) return fvv_record_wrong(to, 4, "lengthSizeMinusOne", p[4] & 3u, 3);
  if (p[5] >> 5 != 7)
    return fvv_record_wrong(to, 5, "the reserved bits before the number of SPS", p[5] >> 5, 7);
  if (!(p[5] & 31)) return fvv_record_wrong(to, 5, "the number of SPS", 0, 1);
  /* An SPS repeats the three bytes of profile, compatibility and level after its header. */
  fvv_status result = check_units(to, &cursor, p[5] & 31, NAL_SPS, 4);
  if (result != FVV_OK) return result;
  const size_t offset = cursor.position;
  const uint8_t *count = fvv_cursor_take(&cursor, 1);
  if (!count) return fvv_record_ends(to, &cursor, "the number of PPS");
  if (!*count) return fvv_record_wrong(to, offset, "the number of PPS", 0, 1);
  result = check_units(to, &cursor, *count, NAL_PPS, 2);
  return result != FVV_OK ? result : check_extension(to, &cursor, p[1]);
}

static void codec_string(const uint8_t *record, char out[FVV_CODEC_STRING_CAPACITY]) {
  snprintf(out, FVV_CODEC_STRING_CAPACITY, "avc1.%02x%02x%02x", record[1], record[2], record[3]);
}

/* Old records omit the depth; Baseline, Main, Extended and High have 8 bits. */
static unsigned bit_depth(const uint8_t *record, size_t size) {
  size_t at = 6;
  for (unsigned i = record[5] & 31; i > 0; i--) at += 2 + ((size_t)record[at] << 8 | record[at + 1]);
  unsigned pictures = record[at++];
  for (; pictures > 0; pictures--) at += 2 + ((size_t)record[at] << 8 | record[at + 1]);
  if (at < size) return 8 + (record[at + 1] & 7u);
  const unsigned profile = record[1];
  return profile == 66 || profile == 77 || profile == 88 || profile == 100 ? 8 : 0;
}

static fvv_status sample_inspect(const uint8_t *sample, size_t size, int *key, fvv_diagnostic *diagnostic) {
  fvv_nal_walk walk = {sample, size, 0, 1, FVV_ISSUE_SAMPLE_AVC, "H.264", diagnostic};
  const uint8_t *unit;
  size_t length;
  fvv_status status;
  *key = 0;
  while ((status = fvv_nal_next(&walk, &unit, &length)) == FVV_OK) *key |= (unit[0] & 31) == NAL_SLICE_IDR;
  return status == FVV_END ? FVV_OK : status;
}

const fvv_codec_rules fvv_avc_rules = {FVV_CODEC_AVC1, FVV_ISSUE_SAMPLE_AVC, "H.264",   "IDR picture",
                                       record_inspect, codec_string,         bit_depth, sample_inspect};
