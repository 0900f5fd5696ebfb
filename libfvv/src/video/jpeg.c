/* video/jpeg.c: the frame header of a JPEG file (ITU-T T.81 annex B) and the segments before it, read before
 * a decoder sees the file. */
#include "video/codecs.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

#include <inttypes.h>

enum { TEM = 0x01, SOF0 = 0xc0, DHT = 0xc4, JPG = 0xc8, DAC = 0xcc, SOF15 = 0xcf, RST0 = 0xd0, SOI = 0xd8 };
enum { EOI = 0xd9, SOS = 0xda, FRAME_HEADER = 8 /* bytes without the components */ };

static unsigned get_be16(const uint8_t *p) {
  return (unsigned)p[0] << 8 | p[1];
}

static fvv_status check_frame(uint32_t width, uint32_t height, const uint8_t *segment, unsigned length,
                              uint64_t offset, fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_SAMPLE_JPEG, type = FVV_CHUNK_VIDEO_PACKET;
  const unsigned components = length >= FRAME_HEADER ? segment[7] : 0;
  if (length < FRAME_HEADER || length != FRAME_HEADER + 3 * components)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, offset,
                    "JPEG frame header has %u bytes for %u components, expected 8 and 3 for each", length,
                    components);
  if (segment[2] != 8)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, offset + 2,
                    "JPEG has %d bits per sample, expected 8", segment[2]);
  if (components != 1 && components != 3)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, offset + 7,
                    "JPEG has %u components, expected 1 or 3", components);
  const unsigned found_height = get_be16(segment + 3), found_width = get_be16(segment + 5);
  if (found_width != width || found_height != height)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, offset + 3,
                    "JPEG has %u x %u pixels, expected %" PRIu32 " x %" PRIu32, found_width, found_height,
                    width, height);
  return FVV_OK;
}

static int is_frame(uint8_t marker) {
  return marker >= SOF0 && marker <= SOF15 && marker != DHT && marker != JPG && marker != DAC;
}

fvv_status fvv_jpeg_inspect(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                            fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_SAMPLE_JPEG, type = FVV_CHUNK_VIDEO_PACKET;
  if (size < 4 || sample[0] != 0xff || sample[1] != SOI)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, 0,
                    "JPEG of %zu bytes does not begin with SOI", size);
  if (sample[size - 2] != 0xff || sample[size - 1] != EOI)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, size - 2,
                    "JPEG of %zu bytes does not end with EOI", size);
  /* EOI is left out: a segment that claims its bytes is too long. */
  fvv_cursor cursor = {sample, size - 2, 2, 0};
  for (;;) {
    const uint8_t *p = fvv_cursor_take(&cursor, 1);
    if (!p || *p != 0xff)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, cursor.position - !!p,
                      "JPEG has no marker where one is expected, and no frame header before");
    while (p && *p == 0xff) p = fvv_cursor_take(&cursor, 1); /* fill bytes */
    const uint8_t marker = p ? *p : 0;
    if (marker == TEM) continue;
    if (marker < SOF0 || (marker >= RST0 && marker <= SOS))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, cursor.position - !!p,
                      "JPEG has marker 0x%02x before its frame header", marker);
    const uint64_t offset = cursor.position;
    const uint8_t *segment = fvv_cursor_take(&cursor, 2);
    const unsigned length = segment ? get_be16(segment) : 0;
    if (length < 2 || !fvv_cursor_take(&cursor, length - 2))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, offset,
                      "JPEG segment 0x%02x of %u bytes does not end before EOI", marker, length);
    if (is_frame(marker)) return check_frame(width, height, segment, length, offset, diagnostic);
  }
}
