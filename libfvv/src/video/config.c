/* The configuration of a video track (VCFG, clause 10.1) and its samples: what all codecs share, and which
 * codec's rules apply. */
#include <inttypes.h>
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/text.h"
#include "video/codecs.h"

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

/* Big-endian, as everything in MP4. */
static uint32_t get_be32(const uint8_t *p) {
  return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

fvv_status fvv_nal_next(fvv_nal_walk *walk, const uint8_t **unit, size_t *size) {
  const uint32_t type = FVV_CHUNK_VIDEO_PACKET;
  const size_t position = walk->position, left = walk->size - position;
  if (!walk->size)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, 0,
                    "%s sample has 0 bytes, expected a NAL unit", walk->codec);
  if (!left) return FVV_END;
  if (left < 4)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, position,
                    "%zu bytes follow the last NAL unit, expected none or a 4-byte length", left);
  const uint32_t length = get_be32(walk->sample + position);
  if (length < walk->least || length > left - 4)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, position,
                    "NAL unit of %" PRIu32 " bytes, expected %zu to %zu", length, walk->least, left - 4);
  const uint8_t header = walk->sample[position + 4];
  if (header & 0x80)
    return fvv_fail(walk->diagnostic, FVV_ERROR_INVALID, walk->issue, type, position + 4,
                    "NAL unit header is 0x%02x, expected its first bit to be 0", header);
  *unit = walk->sample + position + 4;
  *size = length;
  walk->position = position + 4 + (size_t)length;
  return FVV_OK;
}

static fvv_status unknown_codec(uint32_t codec, fvv_status status, uint32_t type,
                                fvv_diagnostic *diagnostic) {
  char text[5];
  fvv_type_text(codec, text);
  return fvv_fail(diagnostic, status, FVV_ISSUE_VIDEO_CODEC, type, 0,
                  "codec '%s' is not supported, expected 'jpeg', 'avc1', 'hvc1', 'vp09', 'av01' or 'oexr'",
                  text);
}

/* Codecs whose samples are files of their own: without a record, every one a key. */
typedef struct still_rules {
  uint32_t codec, sample_issue;
  const char *name;
  int bit_depth;
  fvv_status (*inspect)(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                        fvv_diagnostic *diagnostic);
} still_rules;

/* NULL for all others. */
static const still_rules *still_rules_of(uint32_t codec) {
  static const still_rules all[] = {{FVV_CODEC_JPEG, FVV_ISSUE_SAMPLE_JPEG, "JPEG", 8, fvv_jpeg_inspect},
                                    {FVV_CODEC_OEXR, FVV_ISSUE_SAMPLE_OEXR, "OpenEXR", 16, fvv_oexr_inspect}};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if (all[i].codec == codec) return &all[i];
  return NULL;
}

/* NULL for JPEG and OpenEXR, which have no record, and for codecs that are not known. */
static const fvv_codec_rules *rules_of(uint32_t codec) {
  static const fvv_codec_rules *const all[] = {&fvv_avc_rules, &fvv_hevc_rules, &fvv_vp9_rules,
                                               &fvv_av1_rules};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if (all[i]->codec == codec) return all[i];
  return NULL;
}

static fvv_status check_ranges(const fvv_video_config *config, fvv_status status,
                               fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_VIDEO_RANGE, type = FVV_CHUNK_VIDEO_CONFIG;
  if (!config->width || !config->height)
    return fvv_fail(diagnostic, status, issue, type, FVV_VCFG_WIDTH,
                    "frame is %" PRIu32 " x %" PRIu32 ", expected at least 1 x 1", config->width,
                    config->height);
  if (config->bit_depth < 8 || config->bit_depth > 16)
    return fvv_fail(diagnostic, status, issue, type, FVV_VCFG_BIT_DEPTH, "bit depth is %d, expected 8 to 16",
                    config->bit_depth);
  if (config->full_range > 1)
    return fvv_fail(diagnostic, status, issue, type, FVV_VCFG_FULL_RANGE,
                    "full range flag is %d, expected 0 or 1", config->full_range);
  return FVV_OK;
}

static fvv_status unknown_content(uint8_t shows, fvv_status status, fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, status, FVV_ISSUE_VIDEO_CODEC, FVV_CHUNK_VIDEO_CONFIG, FVV_VCFG_SHOWS,
                  "kind of content is %d, expected 0 or 1", shows);
}

static fvv_status check_still(const still_rules *rules, const fvv_video_config *config, fvv_status status,
                              fvv_diagnostic *diagnostic) {
  if (!config->record_size && !config->codec_string_size) return FVV_OK;
  return fvv_fail(diagnostic, status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG, FVV_VCFG_RECORD_SIZE,
                  "record and codec string have %zu and %zu bytes, expected none for %s", config->record_size,
                  config->codec_string_size, rules->name);
}

static fvv_status check_still_ranges(const still_rules *rules, const fvv_video_config *config,
                                     fvv_status status, fvv_diagnostic *diagnostic) {
  if (config->bit_depth != rules->bit_depth)
    return fvv_fail(diagnostic, status, FVV_ISSUE_VIDEO_RANGE, FVV_CHUNK_VIDEO_CONFIG, FVV_VCFG_BIT_DEPTH,
                    "bit depth is %d, %s has %d", config->bit_depth, rules->name, rules->bit_depth);
  /* H.273: linear light, RGB, full range. */
  if (config->codec == FVV_CODEC_OEXR &&
      (config->transfer_characteristics != 8 || config->matrix_coefficients != 0 || config->full_range != 1))
    return fvv_fail(diagnostic, status, FVV_ISSUE_VIDEO_RANGE, FVV_CHUNK_VIDEO_CONFIG,
                    FVV_VCFG_TRANSFER_CHARACTERISTICS,
                    "transfer, matrix and full range are %d, %d and %d, OpenEXR has 8, 0 and 1",
                    config->transfer_characteristics, config->matrix_coefficients, config->full_range);
  return FVV_OK;
}

/* The sample entry's name is case-sensitive, hexadecimal digits are not. */
static int same_string(const char *expected, const char *found, size_t size) {
  if (strlen(expected) != size) return 0;
  for (size_t i = 0; i < size; i++) {
    const unsigned char pair[] = {(unsigned char)expected[i], (unsigned char)found[i]};
    unsigned char folded[2];
    for (size_t k = 0; k < 2; k++)
      folded[k] =
          (unsigned char)(i >= 5 && pair[k] >= 'A' && pair[k] <= 'F' ? pair[k] + ('a' - 'A') : pair[k]);
    if (folded[0] != folded[1]) return 0;
  }
  return 1;
}

static fvv_status check_record(const fvv_codec_rules *rules, const fvv_video_config *config,
                               fvv_status status, fvv_diagnostic *diagnostic) {
  const fvv_record_report to = {rules->name, status, FVV_VCFG_SIZE, diagnostic};
  const fvv_status result = rules->record_inspect(&to, config->record, config->record_size);
  if (result != FVV_OK) return result;
  const unsigned depth = rules->bit_depth(config->record, config->record_size);
  if (depth && depth != config->bit_depth)
    return fvv_fail(diagnostic, status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG, FVV_VCFG_BIT_DEPTH,
                    "bit depth is %d, but %u in the %s record", config->bit_depth, depth, rules->name);
  char expected[FVV_CODEC_STRING_CAPACITY];
  rules->codec_string(config->record, expected);
  if (!same_string(expected, config->codec_string, config->codec_string_size))
    return fvv_fail(diagnostic, status, FVV_ISSUE_VIDEO_RECORD, FVV_CHUNK_VIDEO_CONFIG,
                    FVV_VCFG_SIZE + (uint64_t)config->record_size,
                    "codec string of %zu bytes does not match the record, expected '%s'",
                    config->codec_string_size, expected);
  return FVV_OK;
}

static fvv_status check_config(const fvv_video_config *config, fvv_status status,
                               fvv_diagnostic *diagnostic) {
  const still_rules *still = still_rules_of(config->codec);
  fvv_status result = check_ranges(config, status, diagnostic);
  if (result == FVV_OK && still) result = check_still_ranges(still, config, status, diagnostic);
  if (result != FVV_OK) return result;
  result = fvv_text_check(config->codec_string, config->codec_string_size, "codec string", status,
                          FVV_CHUNK_VIDEO_CONFIG, FVV_VCFG_SIZE + (uint64_t)config->record_size, diagnostic);
  if (result != FVV_OK) return result;
  return still ? check_still(still, config, status, diagnostic)
               : check_record(rules_of(config->codec), config, status, diagnostic);
}

static int is_known(uint32_t codec) {
  return still_rules_of(codec) || rules_of(codec);
}

fvv_status fvv_video_config_encode(const fvv_video_config *config, uint8_t *out, size_t capacity,
                                   size_t *written, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *written = 0;
  if (!is_known(config->codec))
    return unknown_codec(config->codec, FVV_ERROR_INPUT, FVV_CHUNK_VIDEO_CONFIG, diagnostic);
  if (config->shows > FVV_SHOWS_ATLAS) return unknown_content(config->shows, FVV_ERROR_INPUT, diagnostic);
  const fvv_limits limits = fvv_limits_or_default(NULL);
  const uint32_t side = config->width > config->height ? config->width : config->height;
  fvv_status status = check_config(config, FVV_ERROR_INPUT, diagnostic);
  if (status == FVV_OK)
    status = fvv_readable_check(side, limits.max_dimension, "pixels to a side of a video frame",
                                FVV_CHUNK_VIDEO_CONFIG, diagnostic);
  if (status == FVV_OK)
    status = fvv_readable_check(FVV_VCFG_SIZE + (uint64_t)config->record_size + config->codec_string_size,
                                limits.max_payload, "bytes of a video configuration", FVV_CHUNK_VIDEO_CONFIG,
                                diagnostic);
  if (status != FVV_OK) return status;
  *written = FVV_VCFG_SIZE + config->record_size + config->codec_string_size;
  if (capacity < *written)
    return fvv_fail(diagnostic, FVV_ERROR_BUFFER_TOO_SMALL, 0, FVV_CHUNK_VIDEO_CONFIG, 0,
                    "the record needs %zu bytes, the buffer has %zu", *written, capacity);
  memset(out, 0, FVV_VCFG_SIZE);
  fvv_put_u32(out + FVV_VCFG_CODEC, config->codec);
  fvv_put_u32(out + FVV_VCFG_WIDTH, config->width);
  fvv_put_u32(out + FVV_VCFG_HEIGHT, config->height);
  out[FVV_VCFG_SHOWS] = config->shows;
  out[FVV_VCFG_BIT_DEPTH] = config->bit_depth;
  out[FVV_VCFG_COLOUR_PRIMARIES] = config->colour_primaries;
  out[FVV_VCFG_TRANSFER_CHARACTERISTICS] = config->transfer_characteristics;
  out[FVV_VCFG_MATRIX_COEFFICIENTS] = config->matrix_coefficients;
  out[FVV_VCFG_FULL_RANGE] = config->full_range;
  fvv_put_u32(out + FVV_VCFG_RECORD_SIZE, (uint32_t)config->record_size);
  fvv_put_u16(out + FVV_VCFG_CODEC_STRING_SIZE, (uint16_t)config->codec_string_size);
  uint8_t *tail = out + FVV_VCFG_SIZE;
  if (config->record_size) memcpy(tail, config->record, config->record_size);
  if (config->codec_string_size)
    memcpy(tail + config->record_size, config->codec_string, config->codec_string_size);
  return FVV_OK;
}

fvv_status fvv_video_config_decode(fvv_video_config *config, const uint8_t *payload, size_t size,
                                   const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_VIDEO_PAYLOAD, type = FVV_CHUNK_VIDEO_CONFIG;
  const fvv_limits allowed = fvv_limits_or_default(limits);
  fvv_diagnostic_clear(diagnostic);
  if (size < FVV_VCFG_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, 0,
                    "payload has %zu bytes, expected at least %d", size, FVV_VCFG_SIZE);
  const uint32_t record_size = fvv_get_u32(payload + FVV_VCFG_RECORD_SIZE);
  const uint16_t string_size = fvv_get_u16(payload + FVV_VCFG_CODEC_STRING_SIZE);
  if ((uint64_t)record_size + string_size != size - FVV_VCFG_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, type, FVV_VCFG_RECORD_SIZE,
                    "record of %" PRIu32 " and codec string of %d bytes declared, %zu bytes follow",
                    record_size, string_size, size - FVV_VCFG_SIZE);
  fvv_video_config c = {0};
  c.codec = fvv_get_u32(payload + FVV_VCFG_CODEC);
  if (!is_known(c.codec)) return unknown_codec(c.codec, FVV_ERROR_UNSUPPORTED, type, diagnostic);
  if (payload[FVV_VCFG_SHOWS] > FVV_SHOWS_ATLAS)
    return unknown_content(payload[FVV_VCFG_SHOWS], FVV_ERROR_UNSUPPORTED, diagnostic);
  c.width = fvv_get_u32(payload + FVV_VCFG_WIDTH);
  c.height = fvv_get_u32(payload + FVV_VCFG_HEIGHT);
  if (c.width > allowed.max_dimension || c.height > allowed.max_dimension)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, type, FVV_VCFG_WIDTH,
                    "frame of %" PRIu32 " x %" PRIu32 " pixels, at most %" PRIu32 " a side are allowed",
                    c.width, c.height, allowed.max_dimension);
  c.shows = payload[FVV_VCFG_SHOWS];
  c.bit_depth = payload[FVV_VCFG_BIT_DEPTH];
  c.colour_primaries = payload[FVV_VCFG_COLOUR_PRIMARIES];
  c.transfer_characteristics = payload[FVV_VCFG_TRANSFER_CHARACTERISTICS];
  c.matrix_coefficients = payload[FVV_VCFG_MATRIX_COEFFICIENTS];
  c.full_range = payload[FVV_VCFG_FULL_RANGE];
  c.record = payload + FVV_VCFG_SIZE;
  c.record_size = record_size;
  c.codec_string = (const char *)payload + FVV_VCFG_SIZE + record_size;
  c.codec_string_size = string_size;
  const fvv_status status = check_config(&c, FVV_ERROR_INVALID, diagnostic);
  if (status == FVV_OK) *config = c;
  return status;
}

fvv_status fvv_video_codec_string(uint32_t codec, const uint8_t *record, size_t size,
                                  char out[FVV_CODEC_STRING_CAPACITY], fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  out[0] = 0;
  const fvv_codec_rules *rules = rules_of(codec);
  if (!rules) {
    char text[5];
    fvv_type_text(codec, text);
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_VIDEO_CODEC, FVV_CHUNK_VIDEO_CONFIG, 0,
                    "codec '%s' has no record, expected 'avc1', 'hvc1', 'vp09' or 'av01'", text);
  }
  const fvv_record_report to = {rules->name, FVV_ERROR_INVALID, 0, diagnostic};
  const fvv_status status = rules->record_inspect(&to, record, size);
  if (status == FVV_OK) rules->codec_string(record, out);
  return status;
}

fvv_status fvv_video_sample_inspect(const fvv_video_config *config, const uint8_t *sample, size_t size,
                                    int *key, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *key = 1;
  const still_rules *still = still_rules_of(config->codec);
  if (still) return still->inspect(config->width, config->height, sample, size, diagnostic);
  const fvv_codec_rules *rules = rules_of(config->codec);
  return rules ? rules->sample_inspect(sample, size, key, diagnostic)
               : unknown_codec(config->codec, FVV_ERROR_UNSUPPORTED, FVV_CHUNK_VIDEO_PACKET, diagnostic);
}

fvv_status fvv_video_sample_check(const fvv_video_config *config, int key, const uint8_t *sample, size_t size,
                                  fvv_diagnostic *diagnostic) {
  int found;
  const fvv_status status = fvv_video_sample_inspect(config, sample, size, &found, diagnostic);
  if (status != FVV_OK || found == !!key) return status;
  const still_rules *still = still_rules_of(config->codec);
  if (still)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, still->sample_issue, FVV_CHUNK_VIDEO_PACKET, 0,
                    "%s sample is not marked as a key sample, expected every one to be", still->name);
  const fvv_codec_rules *rules = rules_of(config->codec);
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, rules->sample_issue, FVV_CHUNK_VIDEO_PACKET, 0,
                  "%s %s sample: %s %s, expected %s", key ? "key" : "non-key", rules->name,
                  found ? "found a" : "found no", rules->key_picture, key ? "one" : "none");
}
