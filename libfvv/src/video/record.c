/* video/record.c: see record.h. */
#include "video/record.h"
#include "base/diagnostic.h"

fvv_status fvv_record_wrong(const fvv_record_report *to, size_t offset, const char *what, unsigned found,
                            unsigned expected) {
  return fvv_fail(to->diagnostic, to->status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG,
                  to->base + offset, "%s record: %s is %u, expected %u", to->codec, what, found, expected);
}

fvv_status fvv_record_ends(const fvv_record_report *to, const fvv_cursor *cursor, const char *in) {
  return fvv_fail(to->diagnostic, to->status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG,
                  to->base + cursor->position, "%s record of %zu bytes ends within %s", to->codec,
                  cursor->size, in);
}

fvv_status fvv_record_parameter_sets(const fvv_record_report *to, fvv_cursor *cursor,
                                     const fvv_parameter_sets *sets) {
  for (unsigned i = 0; i < sets->count; i++) {
    const uint8_t *length = fvv_cursor_take(cursor, 2);
    if (!length) return fvv_record_ends(to, cursor, "the length of a parameter set");
    const size_t size = (size_t)length[0] << 8 | length[1], offset = cursor->position;
    if (size < sets->least)
      return fvv_record_wrong(to, offset - 2, "the length of a parameter set", (unsigned)size,
                              (unsigned)sets->least);
    const uint8_t *unit = fvv_cursor_take(cursor, size);
    if (!unit) return fvv_record_ends(to, cursor, "a parameter set");
    if (unit[0] & 0x80) return fvv_record_wrong(to, offset, "the forbidden bit of a parameter set", 1, 0);
    const unsigned type = (unsigned)unit[0] >> sets->shift & sets->mask;
    if (type != sets->type)
      return fvv_record_wrong(to, offset, "the type of a parameter set", type, sets->type);
  }
  return FVV_OK;
}
