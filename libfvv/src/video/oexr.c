/* video/oexr.c: header, offset table and heads of the blocks of an OpenEXR file, read before a decoder sees
 * the file (OpenEXR's "File Layout", version 2). Clause 10.12 allows one kind: one part, scan lines, half B G
 * R. */
#include "video/codecs.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

#include <inttypes.h>
#include <string.h>

enum { LONGEST_NAME = 31, VERSION = 2, HALF = 1, PIXEL_SIZE = 6, BLOCK_HEAD = 8, CHANNELS_SIZE = 55 };
static const uint8_t magic[4] = {0x76, 0x2f, 0x31, 0x01};

/* Attributes that are read. size: of the value, 0: any. */
enum {
  CHANNELS,
  COMPRESSION,
  DATA_WINDOW,
  DISPLAY_WINDOW,
  LINE_ORDER,
  ASPECT,
  CENTRE,
  WINDOW_WIDTH,
  REQUIRED
};
enum { TYPE = REQUIRED, BLOCK_COUNT, TILES, KNOWN };
static const struct {
  const char *name, *type;
  uint32_t size;
} known[KNOWN] = {{"channels", "chlist", CHANNELS_SIZE},
                  {"compression", "compression", 1},
                  {"dataWindow", "box2i", 16},
                  {"displayWindow", "box2i", 16},
                  {"lineOrder", "lineOrder", 1},
                  {"pixelAspectRatio", "float", 4},
                  {"screenWindowCenter", "v2f", 8},
                  {"screenWindowWidth", "float", 4},
                  {"type", "string", 13},
                  {"chunkCount", "int", 4},
                  {"tiles", "", 0}};

/* Index: OpenEXR's number of the compression. 0 lines: not allowed. */
static const uint16_t lines_of_block[] = {1, 0, 1, 16, 32};

typedef struct oexr_file {
  fvv_cursor cursor;
  uint32_t width, height;
  unsigned found;      /* bit i: known[i] was there */
  uint8_t compression; /* valid */
  int64_t block_count; /* chunkCount; -1: there is none */
  uint64_t count_offset;
  fvv_diagnostic *diagnostic;
} oexr_file;

#define BROKEN(file, offset, ...)                                                                            \
  fvv_fail((file)->diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_OEXR, FVV_CHUNK_VIDEO_PACKET, offset,     \
           __VA_ARGS__)

static fvv_status ends(const oexr_file *file, const char *in) {
  return BROKEN(file, file->cursor.position, "OpenEXR file of %zu bytes ends within %s", file->cursor.size,
                in);
}

static int32_t get_i32(const uint8_t *p) {
  const uint32_t bits = fvv_get_u32(p);
  int32_t value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* Bytes up to a NUL, at most LONGEST_NAME; NULL when there is none so near. */
static const char *take_name(fvv_cursor *cursor) {
  const uint8_t *start = cursor->data + cursor->position;
  const size_t left = cursor->size - cursor->position;
  const size_t most = left < LONGEST_NAME + 1 ? left : LONGEST_NAME + 1;
  const uint8_t *end = memchr(start, 0, most);
  if (!end) return NULL;
  cursor->position += (size_t)(end - start) + 1;
  return (const char *)start;
}

/* The channel list of half B, G, R at every pixel: a channel is its name with NUL, type, pLinear with three
 * bytes of padding, and two samplings; a NUL ends the list. */
static fvv_status check_channels(const oexr_file *file, const uint8_t *p, uint64_t offset) {
  for (int i = 0; i < 3; i++, p += 18, offset += 18) {
    if (p[0] != (uint8_t) "BGR"[i] || p[1])
      return BROKEN(file, offset, "OpenEXR channel %d is not %c: expected B, G and R alone", i, "BGR"[i]);
    if (fvv_get_u32(p + 2) != HALF)
      return BROKEN(file, offset + 2, "OpenEXR channel %c is of type %" PRIu32 ", expected 1 (half)",
                    "BGR"[i], fvv_get_u32(p + 2));
    if (fvv_get_u32(p + 10) != 1 || fvv_get_u32(p + 14) != 1)
      return BROKEN(file, offset + 10,
                    "OpenEXR channel %c is sampled %" PRId32 " x %" PRId32 ", expected 1 x 1", "BGR"[i],
                    get_i32(p + 10), get_i32(p + 14));
  }
  return *p ? BROKEN(file, offset, "OpenEXR has a channel after B, G and R") : FVV_OK;
}

static fvv_status check_window(const oexr_file *file, int attribute, const uint8_t *p, uint64_t offset) {
  const int64_t right = get_i32(p + 8), bottom = get_i32(p + 12);
  if (get_i32(p) || get_i32(p + 4) || right != (int64_t)file->width - 1 ||
      bottom != (int64_t)file->height - 1)
    return BROKEN(file, offset,
                  "OpenEXR %s is (%" PRId32 ", %" PRId32 ") to (%" PRId64 ", %" PRId64
                  "), expected (0, 0) to (%" PRId64 ", %" PRId64 ")",
                  known[attribute].name, get_i32(p), get_i32(p + 4), right, bottom, (int64_t)file->width - 1,
                  (int64_t)file->height - 1);
  return FVV_OK;
}

static fvv_status check_value(oexr_file *file, int attribute, const uint8_t *p, uint64_t offset) {
  switch (attribute) {
  case CHANNELS:
    return check_channels(file, p, offset);
  case COMPRESSION:
    file->compression = *p;
    if (*p >= sizeof lines_of_block / sizeof *lines_of_block || !lines_of_block[*p])
      return BROKEN(file, offset, "OpenEXR compression is %d, expected 0, 2, 3 or 4", *p);
    return FVV_OK;
  case DATA_WINDOW:
  case DISPLAY_WINDOW:
    return check_window(file, attribute, p, offset);
  case LINE_ORDER:
    return *p ? BROKEN(file, offset, "OpenEXR line order is %d, expected 0", *p) : FVV_OK;
  case TYPE:
    return memcmp(p, "scanlineimage", 13) ? BROKEN(file, offset, "OpenEXR type is not 'scanlineimage'")
                                          : FVV_OK;
  case BLOCK_COUNT:
    file->block_count = get_i32(p);
    file->count_offset = offset;
    return file->block_count < 0 ? BROKEN(file, offset, "OpenEXR chunkCount is negative") : FVV_OK;
  case TILES:
    return BROKEN(file, offset, "OpenEXR has tiles, expected scan lines");
  default:
    return FVV_OK;
  }
}

static fvv_status read_attribute(oexr_file *file) {
  fvv_cursor *cursor = &file->cursor;
  const uint64_t start = cursor->position;
  const char *name = take_name(cursor), *type = name ? take_name(cursor) : NULL;
  if (!type || !*type)
    return BROKEN(file, start, "OpenEXR attribute has no name and type of 1 to %d bytes", LONGEST_NAME);
  const uint64_t at = cursor->position;
  const uint8_t *length = fvv_cursor_take(cursor, 4);
  if (!length) return ends(file, "the size of an attribute");
  const uint32_t size = fvv_get_u32(length);
  const uint8_t *value = fvv_cursor_take(cursor, size);
  if (!value)
    return BROKEN(file, at, "OpenEXR attribute has %" PRIu32 " bytes, the sample has %zu left", size,
                  cursor->size - cursor->position);
  for (int i = 0; i < KNOWN; i++) {
    if (strcmp(name, known[i].name)) continue;
    if (file->found >> i & 1) return BROKEN(file, start, "OpenEXR has attribute %s twice", known[i].name);
    file->found |= 1u << i;
    if (i != TILES && (strcmp(type, known[i].type) || size != known[i].size))
      return BROKEN(file, at, "OpenEXR attribute %s is not a %s of %" PRIu32 " bytes", known[i].name,
                    known[i].type, known[i].size);
    return check_value(file, i, value, at + 4);
  }
  return FVV_OK;
}

static fvv_status read_header(oexr_file *file) {
  fvv_cursor *cursor = &file->cursor;
  const uint8_t *head = fvv_cursor_take(cursor, 8);
  if (!head || memcmp(head, magic, sizeof magic))
    return BROKEN(file, 0, "OpenEXR file of %zu bytes does not begin with its magic number", cursor->size);
  if (fvv_get_u32(head + 4) != VERSION)
    return BROKEN(file, 4,
                  "OpenEXR version word is 0x%" PRIx32 ", expected 2: one part of scan lines, short names",
                  fvv_get_u32(head + 4));
  while (cursor->position < cursor->size && cursor->data[cursor->position]) {
    const fvv_status status = read_attribute(file);
    if (status != FVV_OK) return status;
  }
  if (!fvv_cursor_take(cursor, 1)) return ends(file, "its header");
  for (int i = 0; i < REQUIRED; i++)
    if (!(file->found >> i & 1))
      return BROKEN(file, cursor->position, "OpenEXR has no attribute %s", known[i].name);
  return FVV_OK;
}

/* Blocks follow each other from the table to the end of the sample. */
static fvv_status check_blocks(oexr_file *file) {
  fvv_cursor *cursor = &file->cursor;
  const uint32_t lines = lines_of_block[file->compression];
  const uint64_t line_size = (uint64_t)file->width * PIXEL_SIZE;
  const uint64_t count = ((uint64_t)file->height + lines - 1) / lines;
  if (file->block_count >= 0 && (uint64_t)file->block_count != count)
    return BROKEN(file, file->count_offset, "OpenEXR chunkCount is %" PRId64 ", expected %" PRIu64,
                  file->block_count, count);
  const uint64_t table_offset = cursor->position;
  if (count > (cursor->size - cursor->position) / 8) return ends(file, "its offset table");
  const uint8_t *table = fvv_cursor_take(cursor, (size_t)(8 * count));
  for (uint64_t i = 0; i < count; i++) {
    const uint64_t offset = cursor->position, first = i * lines;
    const uint64_t rows = file->height - first < lines ? file->height - first : lines;
    if (fvv_get_u64(table + 8 * i) != offset)
      return BROKEN(file, table_offset + 8 * i,
                    "OpenEXR block %" PRIu64 " is at %" PRIu64 " by the table, expected at %" PRIu64, i,
                    fvv_get_u64(table + 8 * i), offset);
    const uint8_t *head = fvv_cursor_take(cursor, BLOCK_HEAD);
    if (!head) return ends(file, "the head of a block");
    if (fvv_get_u32(head) != first)
      return BROKEN(file, offset, "OpenEXR block %" PRIu64 " begins with line %" PRId32 ", expected %" PRIu64,
                    i, get_i32(head), first);
    const uint32_t size = fvv_get_u32(head + 4);
    if (!size || size > rows * line_size || (!file->compression && size != rows * line_size))
      return BROKEN(file, offset + 4, "OpenEXR block %" PRIu64 " has %" PRIu32 " bytes, expected %s%" PRIu64,
                    i, size, file->compression ? "1 to " : "", rows * line_size);
    if (!fvv_cursor_take(cursor, size)) return ends(file, "a block");
  }
  if (cursor->position != cursor->size)
    return BROKEN(file, cursor->position, "OpenEXR file has %zu bytes after its last block",
                  cursor->size - cursor->position);
  return FVV_OK;
}

fvv_status fvv_oexr_inspect(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                            fvv_diagnostic *diagnostic) {
  oexr_file file = {{sample, size, 0, 0}, width, height, 0, 0, -1, 0, diagnostic};
  const fvv_status status = read_header(&file);
  return status == FVV_OK ? check_blocks(&file) : status;
}
