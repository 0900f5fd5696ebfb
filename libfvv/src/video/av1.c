/* video/av1.c: AV1 as MP4 stores it: configuration record, and temporal units as samples (clause 10.9).
 *
 * Read are the AV1 Codec ISO Media File Format Binding, the OBU headers of the AV1 bitstream specification
 * (clause 5.3) and the first bits of sequence and frame headers. The rest is up to decoders. */
#include "base/diagnostic.h"
#include "video/codecs.h"

#include <inttypes.h>
#include <stdio.h>

enum {
  OBU_SEQUENCE_HEADER = 1,
  OBU_TEMPORAL_DELIMITER = 2,
  OBU_FRAME_HEADER = 3,
  OBU_METADATA = 5,
  OBU_FRAME = 6,
  OBU_TILE_LIST = 8,
  HEADER_SIZE = 4
};

typedef struct obu {
  size_t offset; /* of its header */
  unsigned type;
  const uint8_t *payload;
  size_t size;
} obu;

/* How an error in a list of OBUs is reported. */
typedef struct list_report {
  fvv_status status;
  uint32_t issue, chunk;
  uint64_t base;
  fvv_diagnostic *diagnostic;
} list_report;

/* The next OBU: FVV_OK, FVV_END after the last. Each has a size field, so that a truncated list is
 * detected. */
static fvv_status next_obu(const list_report *to, fvv_cursor *cursor, obu *out) {
  const size_t offset = cursor->position;
  const uint8_t *header = fvv_cursor_take(cursor, 1);
  if (!header) return FVV_END;
  if (*header & 0x80 || !(*header & 2))
    return fvv_fail(to->diagnostic, to->status, to->issue, to->chunk, to->base + offset,
                    "OBU header is 0x%02x, expected its first bit to be 0 and obu_has_size_field 1", *header);
  if (*header & 4) fvv_cursor_take(cursor, 1);
  uint64_t size = 0;
  for (unsigned i = 0;; i++) { /* leb128() of clause 4.10.5 */
    const uint8_t *byte = fvv_cursor_take(cursor, 1);
    if (!byte || i == 8)
      return fvv_fail(to->diagnostic, to->status, to->issue, to->chunk, to->base + offset,
                      "the size of an OBU does not end within %s", byte ? "8 bytes" : "the sample or record");
    size |= (uint64_t)(*byte & 127) << 7 * i;
    if (!(*byte & 128)) break;
  }
  const size_t left = cursor->size - cursor->position;
  if (size > left)
    return fvv_fail(to->diagnostic, to->status, to->issue, to->chunk, to->base + offset,
                    "OBU of %" PRIu64 " bytes, expected at most %zu", size, left);
  *out = (obu){offset, *header >> 3 & 15u, fvv_cursor_take(cursor, (size_t)size), (size_t)size};
  return FVV_OK;
}

/* A sequence header of a stream, not of a single still picture whose frame headers have other fields. */
static fvv_status check_sequence(const list_report *to, const obu *sequence) {
  if (!sequence->size || sequence->payload[0] & 8)
    return fvv_fail(to->diagnostic, to->status, to->issue, to->chunk, to->base + sequence->offset,
                    "sequence header %s, expected one with reduced_still_picture_header 0",
                    sequence->size ? "of a still picture" : "of 0 bytes");
  return FVV_OK;
}

static fvv_status record_inspect(const fvv_record_report *to, const uint8_t *record, size_t size) {
  fvv_cursor cursor = {record, size, 0, 0};
  const uint8_t *p = fvv_cursor_take(&cursor, HEADER_SIZE);
  if (!p) return fvv_record_ends(to, &cursor, "its first 4 bytes");
  if (p[0] != 0x81) return fvv_record_wrong(to, 0, "marker and version", p[0], 0x81);
  if (p[1] >> 5 > 2) return fvv_record_wrong(to, 1, "seq_profile", p[1] >> 5, 2);
  /* twelve_bit needs high_bitdepth, and both need profile 2. */
  if (p[2] & 0x20 && (!(p[2] & 0x40) || p[1] >> 5 != 2)) return fvv_record_wrong(to, 2, "twelve_bit", 1, 0);
  if (p[3] >> 5) return fvv_record_wrong(to, 3, "the first 3 reserved bits", p[3] >> 5, 0);
  if (!(p[3] & 0x10) && p[3] & 15) return fvv_record_wrong(to, 3, "the last 4 reserved bits", p[3] & 15u, 0);
  const list_report list = {to->status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG, to->base,
                            to->diagnostic};
  obu unit = {0, 0, NULL, 0};
  fvv_status status;
  unsigned count = 0;
  for (; (status = next_obu(&list, &cursor, &unit)) == FVV_OK; count++) {
    const unsigned expected = count ? OBU_METADATA : OBU_SEQUENCE_HEADER;
    if (unit.type != expected)
      return fvv_record_wrong(to, unit.offset, "the type of an OBU", unit.type, expected);
    if (count) continue;
    status = check_sequence(&list, &unit);
    if (status != FVV_OK) return status;
    if (unit.payload[0] >> 5 != p[1] >> 5)
      return fvv_record_wrong(to, unit.offset, "seq_profile of the sequence header", unit.payload[0] >> 5,
                              p[1] >> 5);
  }
  if (status != FVV_END) return status;
  if (!count) return fvv_record_wrong(to, HEADER_SIZE, "the number of sequence headers", 0, 1);
  return FVV_OK;
}

static unsigned bit_depth(const uint8_t *record, size_t size) {
  (void)size;
  return record[2] & 0x40 ? record[2] & 0x20 ? 12 : 10 : 8;
}

static void codec_string(const uint8_t *record, char out[FVV_CODEC_STRING_CAPACITY]) {
  snprintf(out, FVV_CODEC_STRING_CAPACITY, "av01.%d.%02d%c.%02u", record[1] >> 5, record[1] & 31,
           record[2] & 0x80 ? 'H' : 'M', bit_depth(record, HEADER_SIZE));
}

/* Clause 2.4 of the binding: a sample is a sync sample when its first frame is a key frame that is shown and
 * a sequence header is before it. */
static fvv_status sample_inspect(const uint8_t *sample, size_t size, int *key, fvv_diagnostic *diagnostic) {
  const list_report list = {FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_AV1, FVV_CHUNK_VIDEO_PACKET, 0, diagnostic};
  fvv_cursor cursor = {sample, size, 0, 0};
  obu unit = {0, 0, NULL, 0};
  fvv_status status;
  unsigned frames = 0, shown = 0, sequences = 0;
  *key = 0;
  while ((status = next_obu(&list, &cursor, &unit)) == FVV_OK) {
    if (unit.type == OBU_TEMPORAL_DELIMITER || unit.type == OBU_TILE_LIST)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, list.issue, list.chunk, unit.offset,
                      "AV1 sample has a %s, expected none",
                      unit.type == OBU_TILE_LIST ? "tile list" : "temporal delimiter");
    if (unit.type == OBU_SEQUENCE_HEADER) {
      status = check_sequence(&list, &unit);
      if (status != FVV_OK) return status;
      sequences++;
    }
    if (unit.type != OBU_FRAME_HEADER && unit.type != OBU_FRAME) continue;
    if (!unit.size)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, list.issue, list.chunk, unit.offset,
                      "frame header of 0 bytes, expected at least 1");
    /* show_existing_frame; else frame_type, 0 for a key frame, and show_frame. */
    const unsigned bits = unit.payload[0];
    if (!frames++) *key = sequences && (bits & 0xf0) == 0x10;
    shown += bits & 0x90 ? 1 : 0;
  }
  if (status != FVV_END) return status;
  if (shown != 1)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, list.issue, list.chunk, 0,
                    "AV1 sample shows %u frames, expected 1", shown);
  return FVV_OK;
}

const fvv_codec_rules fvv_av1_rules = {
    FVV_CODEC_AV01, FVV_ISSUE_SAMPLE_AV1, "AV1",     "key frame after a sequence header",
    record_inspect, codec_string,         bit_depth, sample_inspect};
