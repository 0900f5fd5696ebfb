/* What can be told of a picture file without decoding it (clause 18.3). JPEG files are judged as samples of
 * video are; of PNG files (ISO/IEC 15948) signature, IHDR and IEND. */
#include <string.h>

#include "background/background.h"
#include "video/jpeg.h"

enum { SIGNATURE_SIZE = 8, IHDR_SIZE = 25 /* with length, type and CRC */, IEND_SIZE = 12 };
static const uint8_t signature[SIGNATURE_SIZE] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
static const uint8_t ihdr[8] = {0, 0, 0, 13, 'I', 'H', 'D', 'R'};
static const uint8_t iend[IEND_SIZE] = {0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};

static uint32_t get_be32(const uint8_t *p) {
  return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static int is_png(const uint8_t *data, size_t size) {
  return size >= SIGNATURE_SIZE + IHDR_SIZE + IEND_SIZE && !memcmp(data, signature, sizeof signature) &&
         !memcmp(data + SIGNATURE_SIZE, ihdr, sizeof ihdr) &&
         !memcmp(data + size - IEND_SIZE, iend, sizeof iend);
}

fvv_status fvv_background_picture_check(const fvv_background_picture *picture, uint64_t offset,
                                        fvv_diagnostic *diagnostic) {
  if (picture->codec > FVV_PICTURE_PNG)
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_BACKGROUND_CODEC, FVV_CHUNK_BACKGROUND,
                    offset, "picture of codec %u, known are 0 and 1", picture->codec);
  if (picture->codec == FVV_PICTURE_JPEG) {
    fvv_diagnostic why = {0};
    if (fvv_jpeg_inspect(picture->width, picture->height, picture->data, picture->size, &why) != FVV_OK)
      WRONG(BACKGROUND_PICTURE, offset + why.offset, "%.150s", why.message);
    return FVV_OK;
  }
  if (!is_png(picture->data, picture->size))
    WRONG(BACKGROUND_PICTURE, offset, "PNG of %zu bytes lacks signature, IHDR or IEND", picture->size);
  const uint32_t width = get_be32(picture->data + 16), height = get_be32(picture->data + 20);
  if (!width || !height || width != picture->width || height != picture->height)
    WRONG(BACKGROUND_PICTURE, offset + 16, "PNG has %lu x %lu pixels, expected %lu x %lu",
          (unsigned long)width, (unsigned long)height, (unsigned long)picture->width,
          (unsigned long)picture->height);
  return FVV_OK;
}

/* The size in the first frame header; 0 when there is none. What is odd about the file fvv_jpeg_inspect says.
 */
static void find_jpeg_size(fvv_background_picture *picture) {
  const uint8_t *p = picture->data;
  size_t at = 2;
  picture->width = picture->height = 0;
  while (at + 9 <= picture->size) {
    const uint8_t marker = p[at + 1];
    if (p[at] != 0xff) return;
    if (marker == 0xff || marker == 0x01) {
      at += marker == 0xff ? 1 : 2;
      continue;
    }
    if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) {
      picture->height = (uint32_t)p[at + 5] << 8 | p[at + 6];
      picture->width = (uint32_t)p[at + 7] << 8 | p[at + 8];
      return;
    }
    at += 2 + ((size_t)p[at + 2] << 8 | p[at + 3]);
  }
}

fvv_status fvv_background_picture_inspect(fvv_background_picture *picture, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (is_png(picture->data, picture->size)) {
    picture->codec = FVV_PICTURE_PNG;
    picture->width = get_be32(picture->data + 16);
    picture->height = get_be32(picture->data + 20);
  } else {
    picture->codec = FVV_PICTURE_JPEG;
    find_jpeg_size(picture);
  }
  const fvv_status status = fvv_background_picture_check(picture, 0, diagnostic);
  if (diagnostic && status == FVV_ERROR_INVALID) diagnostic->status = FVV_ERROR_INPUT;
  return status == FVV_ERROR_INVALID ? FVV_ERROR_INPUT : status;
}
