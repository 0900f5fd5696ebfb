/* video/hevc.c: HEVC as MP4 stores it: configuration record and length-prefixed samples (clause 10.7).
 *
 * Only the framing of NAL units (ISO/IEC 14496-15), their two header bytes (ITU-T H.265 clause 7.3.1.2) and
 * the first bit of a slice segment are read. The rest is up to decoders. */
#include "base/diagnostic.h"
#include "video/codecs.h"

#include <stdio.h>

enum {
  HEADER_SIZE = 23,
  NAL_RADL_N = 6, /* up to 9: leading pictures, shown before the IRAP picture that they follow */
  NAL_RASL_R = 9,
  NAL_IRAP_FIRST = 16,
  NAL_IRAP_LAST = 23,
  NAL_VCL_LAST = 31,
  NAL_VPS = 32,
  NAL_PPS = 34
};

static unsigned type_of(const uint8_t *unit) {
  return (unsigned)unit[0] >> 1 & 63;
}

static fvv_status check_header(const fvv_record_report *to, const uint8_t *p) {
  const struct {
    size_t offset;
    unsigned shift, mask, expected;
    const char *what;
  } fields[] = {{0, 0, 255, 1, "the version"},
                {1, 6, 3, 0, "general_profile_space"},
                {13, 4, 15, 15, "the reserved bits before min_spatial_segmentation_idc"},
                {15, 2, 63, 63, "the reserved bits before parallelismType"},
                {16, 2, 63, 63, "the reserved bits before the chroma format"},
                {17, 3, 31, 31, "the reserved bits before the bit depth of luma"},
                {18, 3, 31, 31, "the reserved bits before the bit depth of chroma"},
                {21, 0, 3, 3, "lengthSizeMinusOne"}};
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
    const unsigned found = (unsigned)p[fields[i].offset] >> fields[i].shift & fields[i].mask;
    if (found != fields[i].expected)
      return fvv_record_wrong(to, fields[i].offset, fields[i].what, found, fields[i].expected);
  }
  if (p[18] != p[17])
    return fvv_record_wrong(to, 18, "the bit depth of chroma", 8 + (p[18] & 7u), 8 + (p[17] & 7u));
  return FVV_OK;
}

static fvv_status record_inspect(const fvv_record_report *to, const uint8_t *record, size_t size) {
  fvv_cursor cursor = {record, size, 0, 0};
  const uint8_t *p = fvv_cursor_take(&cursor, HEADER_SIZE);
  if (!p) return fvv_record_ends(to, &cursor, "its first 23 bytes");
  fvv_status status = check_header(to, p);
  if (status != FVV_OK) return status;
  /* One array for each kind of parameter set, in the order in which they refer to each other. */
  if (p[22] != NAL_PPS - NAL_VPS + 1)
    return fvv_record_wrong(to, 22, "the number of arrays", p[22], NAL_PPS - NAL_VPS + 1);
  for (unsigned type = NAL_VPS; type <= NAL_PPS; type++) {
    const size_t offset = cursor.position;
    const uint8_t *array = fvv_cursor_take(&cursor, 3);
    if (!array) return fvv_record_ends(to, &cursor, "the head of an array");
    /* array_completeness, which the sample entry hvc1 demands, a reserved bit, the type. */
    if (array[0] != (0x80 | type))
      return fvv_record_wrong(to, offset, "array_completeness and type of an array", array[0], 0x80 | type);
    /* The header, and at least one byte. */
    const fvv_parameter_sets sets = {(unsigned)array[1] << 8 | array[2], type, 1, 63, 3};
    if (!sets.count) return fvv_record_wrong(to, offset + 1, "the number of units of an array", 0, 1);
    status = fvv_record_parameter_sets(to, &cursor, &sets);
    if (status != FVV_OK) return status;
  }
  if (cursor.position != size)
    return fvv_record_wrong(to, cursor.position, "the number of bytes after the last parameter set",
                            (unsigned)(size - cursor.position), 0);
  return FVV_OK;
}

/* ISO/IEC 14496-15 annex E.3: compatibility flags from the last to the first, constraint bytes without the
 * zeros at the end. */
static void codec_string(const uint8_t *record, char out[FVV_CODEC_STRING_CAPACITY]) {
  unsigned long flags = 0;
  for (unsigned i = 0; i < 32; i++) flags |= (unsigned long)(record[2 + i / 8] >> (7 - i % 8) & 1) << i;
  int length = snprintf(out, FVV_CODEC_STRING_CAPACITY, "hvc1.%d.%lX.%c%d", record[1] & 31, flags,
                        record[1] & 0x20 ? 'H' : 'L', record[12]);
  int last = 11;
  while (last >= 6 && !record[last]) last--;
  for (int i = 6; i <= last; i++)
    length += snprintf(out + length, (size_t)(FVV_CODEC_STRING_CAPACITY - length), ".%02X", record[i]);
}

static unsigned bit_depth(const uint8_t *record, size_t size) {
  (void)size;
  return 8 + (record[17] & 7u);
}

static fvv_status sample_inspect(const uint8_t *sample, size_t size, int *key, fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_SAMPLE_HEVC, chunk = FVV_CHUNK_VIDEO_PACKET;
  fvv_nal_walk walk = {sample, size, 0, 2, issue, "HEVC", diagnostic};
  const uint8_t *unit;
  size_t length;
  fvv_status status;
  unsigned pictures = 0;
  *key = 0;
  while ((status = fvv_nal_next(&walk, &unit, &length)) == FVV_OK) {
    const uint64_t offset = (uint64_t)(unit - sample);
    if (!(unit[1] & 7))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, chunk, offset + 1,
                      "nuh_temporal_id_plus1 of a NAL unit is 0, expected 1 to 7");
    const unsigned type = type_of(unit);
    if (type > NAL_VCL_LAST) continue;
    if (type >= NAL_RADL_N && type <= NAL_RASL_R)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, chunk, offset,
                      "HEVC sample has a leading picture (NAL unit type %u), expected none", type);
    if (length < 3)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, chunk, offset,
                      "slice segment of %zu bytes, expected at least 3", length);
    pictures += unit[2] >> 7; /* first_slice_segment_in_pic_flag */
    *key |= type >= NAL_IRAP_FIRST && type <= NAL_IRAP_LAST;
  }
  if (status != FVV_END) return status;
  if (pictures != 1)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, chunk, 0,
                    "HEVC sample has %u slice segments that begin a picture, expected 1", pictures);
  return FVV_OK;
}

const fvv_codec_rules fvv_hevc_rules = {FVV_CODEC_HVC1, FVV_ISSUE_SAMPLE_HEVC, "HEVC",    "IRAP picture",
                                        record_inspect, codec_string,          bit_depth, sample_inspect};
