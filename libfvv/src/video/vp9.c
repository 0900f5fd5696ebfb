/* video/vp9.c: VP9 as MP4 stores it: configuration record, and frames or superframes (clause 10.8).
 *
 * Only the record (VP Codec ISO Media File Format Binding), the first bits of the uncompressed header (VP9
 * bitstream specification, clause 6.2) and the superframe index (annex B) are read. The rest is up to
 * decoders. */
#include "base/diagnostic.h"
#include "video/codecs.h"

#include <inttypes.h>
#include <stdio.h>

enum { RECORD_SIZE = 12, SYNC_CODE = 0x498342 };

static fvv_status record_inspect(const fvv_record_report *to, const uint8_t *record, size_t size) {
  /* Version and flags of the full box, and no codecInitializationData. */
  static const struct {
    size_t offset;
    uint8_t value;
    const char *what;
  } fixed[] = {{0, 1, "the version"},
               {1, 0, "the first byte of the flags"},
               {2, 0, "the second byte of the flags"},
               {3, 0, "the third byte of the flags"},
               {10, 0, "the first byte of codecInitializationDataSize"},
               {11, 0, "the second byte of codecInitializationDataSize"}};
  if (size != RECORD_SIZE) return fvv_record_wrong(to, 0, "the number of bytes", (unsigned)size, RECORD_SIZE);
  for (size_t i = 0; i < sizeof fixed / sizeof *fixed; i++)
    if (record[fixed[i].offset] != fixed[i].value)
      return fvv_record_wrong(to, fixed[i].offset, fixed[i].what, record[fixed[i].offset], fixed[i].value);
  const unsigned profile = record[4], depth = record[6] >> 4, subsampling = record[6] >> 1 & 7u;
  if (profile > 3) return fvv_record_wrong(to, 4, "the profile", profile, 3);
  if (profile < 2 && depth != 8)
    return fvv_record_wrong(to, 6, "the bit depth of a profile below 2", depth, 8);
  if (profile >= 2 && depth != 10 && depth != 12)
    return fvv_record_wrong(to, 6, "the bit depth of a profile above 1", depth, depth < 11 ? 10 : 12);
  /* 0 and 1 are 4:2:0, 2 and 3 have more chroma: profiles 1 and 3. */
  if (subsampling > 3 || subsampling >> 1 != (profile & 1))
    return fvv_record_wrong(to, 6, "the chroma subsampling", subsampling, 2 * (profile & 1));
  return FVV_OK;
}

static void codec_string(const uint8_t *record, char out[FVV_CODEC_STRING_CAPACITY]) {
  snprintf(out, FVV_CODEC_STRING_CAPACITY, "vp09.%02d.%02d.%02d", record[4], record[5], record[6] >> 4);
}

static unsigned bit_depth(const uint8_t *record, size_t size) {
  (void)size;
  return record[6] >> 4;
}

static fvv_status wrong(fvv_diagnostic *diagnostic, size_t offset, const char *what, unsigned found,
                        unsigned expected) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_VP9, FVV_CHUNK_VIDEO_PACKET, offset,
                  "VP9 sample: %s is %u, expected %u", what, found, expected);
}

/* The frame of size bytes at position; size > 0. */
static fvv_status frame_inspect(const uint8_t *sample, size_t position, size_t size, int *key, int *shown,
                                fvv_diagnostic *diagnostic) {
  const uint8_t *p = sample + position;
  if (p[0] >> 6 != 2) return wrong(diagnostic, position, "the frame marker", p[0] >> 6, 2);
  const unsigned profile = (p[0] >> 5 & 1u) | (p[0] >> 4 & 1u) << 1;
  /* Profile 3 has a reserved bit before show_existing_frame, frame_type, show_frame and
   * error_resilient_mode. */
  if (profile == 3 && p[0] & 8) return wrong(diagnostic, position, "the reserved bit of profile 3", 1, 0);
  const unsigned flags = profile == 3 ? p[0] & 7u : p[0] >> 1 & 7u;
  const int existing = flags >> 2 & 1;
  *key = !existing && !(flags >> 1 & 1);
  *shown = existing || (flags & 1);
  if (!*key) return FVV_OK;
  if (size < 5) return wrong(diagnostic, position, "the number of bytes of a key frame", (unsigned)size, 5);
  const uint32_t next = (uint32_t)p[1] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 8 | p[4];
  const unsigned code = (profile == 3 ? next << 1 : next) >> 8;
  if (code != SYNC_CODE) return wrong(diagnostic, position + 1, "the sync code", code, SYNC_CODE);
  return FVV_OK;
}

/* Annex B: the index of a superframe ends the sample, its first byte repeated as its last. 0: none. */
static size_t index_size(const uint8_t *sample, size_t size) {
  const unsigned marker = sample[size - 1];
  if (marker >> 5 != 6) return 0;
  const size_t bytes = 2 + (size_t)((marker >> 3 & 3) + 1) * ((marker & 7) + 1);
  return size >= bytes && sample[size - bytes] == marker ? bytes : 0;
}

static fvv_status sample_inspect(const uint8_t *sample, size_t size, int *key, fvv_diagnostic *diagnostic) {
  *key = 0;
  if (!size) return wrong(diagnostic, 0, "the number of bytes", 0, 1);
  const size_t index = index_size(sample, size), data = size - index;
  const size_t width = (sample[size - 1] >> 3 & 3u) + 1;
  const unsigned frames = index ? (sample[size - 1] & 7u) + 1 : 1;
  size_t position = 0;
  int key_frame = 0, shown = 0;
  for (unsigned i = 0; i < frames; i++) {
    uint64_t length = index ? 0 : size;
    for (size_t b = 0; index && b < width; b++) length |= (uint64_t)sample[data + 1 + i * width + b] << 8 * b;
    if (!length || length > data - position)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_VP9, FVV_CHUNK_VIDEO_PACKET,
                      index ? data + 1 + i * width : 0,
                      "frame %u of a superframe has %" PRIu64 " bytes, expected 1 to %zu", i, length,
                      data - position);
    const fvv_status status = frame_inspect(sample, position, (size_t)length, &key_frame, &shown, diagnostic);
    if (status != FVV_OK) return status;
    if (i == 0) *key = key_frame;
    if (shown != (i + 1 == frames))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_VP9, FVV_CHUNK_VIDEO_PACKET, position,
                      "frame %u of %u in a VP9 sample is %s, expected the last alone to be shown", i, frames,
                      shown ? "shown" : "not shown");
    position += (size_t)length;
  }
  if (position != data)
    return wrong(diagnostic, position, "the number of bytes between the last frame and the superframe index",
                 (unsigned)(data - position), 0);
  return FVV_OK;
}

const fvv_codec_rules fvv_vp9_rules = {FVV_CODEC_VP09, FVV_ISSUE_SAMPLE_VP9, "VP9",     "key frame",
                                       record_inspect, codec_string,         bit_depth, sample_inspect};
