/* video/codecs.h: the interface of the codecs in this folder, and the iteration over NAL units that two of
 * them share. */
#ifndef FVV_VIDEO_CODECS_H
#define FVV_VIDEO_CODECS_H

#include "base/bytes.h"
#include "fvv/video.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How an error is reported: base is added to offsets in the record. */
typedef struct fvv_record_report {
  const char *codec; /* "H.264" */
  fvv_status status;
  uint64_t base;
  fvv_diagnostic *diagnostic;
} fvv_record_report;

fvv_status fvv_record_wrong(const fvv_record_report *to, size_t offset, const char *what, unsigned found,
                            unsigned expected);
fvv_status fvv_record_ends(const fvv_record_report *to, const fvv_cursor *cursor, const char *in);
/* Parameter sets with 2-byte big-endian lengths before them, as avcC and hvcC hold them. The type of a unit
 * is its first byte >> shift & mask; each has at least least bytes. */
typedef struct fvv_parameter_sets {
  unsigned count, type, shift, mask;
  size_t least;
} fvv_parameter_sets;
fvv_status fvv_record_parameter_sets(const fvv_record_report *to, fvv_cursor *cursor,
                                     const fvv_parameter_sets *sets);

/* One codec's rules. */
typedef struct fvv_codec_rules {
  uint32_t codec, sample_issue;
  const char *name, *key_picture; /* "H.264", "IDR picture" */
  fvv_status (*record_inspect)(const fvv_record_report *to, const uint8_t *record, size_t size);
  /* Of a record that is well formed. codec_string ends with NUL; its digits A to F may have either case. */
  void (*codec_string)(const uint8_t *record, char out[FVV_CODEC_STRING_CAPACITY]);
  unsigned (*bit_depth)(const uint8_t *record, size_t size); /* 0: not in the record */
  /* Reports with sample_issue. *key: whether the sample opens with a key picture. */
  fvv_status (*sample_inspect)(const uint8_t *sample, size_t size, int *key, fvv_diagnostic *diagnostic);
} fvv_codec_rules;

extern const fvv_codec_rules fvv_avc_rules, fvv_hevc_rules, fvv_vp9_rules, fvv_av1_rules;

typedef struct fvv_nal_walk {
  const uint8_t *sample;
  size_t size, position;
  size_t least; /* bytes of a unit */
  uint32_t issue;
  const char *codec;
  fvv_diagnostic *diagnostic;
} fvv_nal_walk;

/* The next unit: FVV_OK, FVV_END after the last, FVV_ERROR_INVALID with issue. A sample has at least one
 * unit. */
fvv_status fvv_nal_next(fvv_nal_walk *walk, const uint8_t **unit, size_t *size);

/* The rules of clause 10.4 for a sample: FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_JPEG. */
fvv_status fvv_jpeg_inspect(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                            fvv_diagnostic *diagnostic);

/* The rules of clause 10.12 for a sample: FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_OEXR. */
fvv_status fvv_oexr_inspect(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                            fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
