/* The configuration of an audio track (ACFG, clause 20.1) and its packets (AUDI, clause 20.2). */
#include "fvv/audio.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/text.h"

enum {
  OPUS_HEAD = 19,       /* bytes without a mapping table, RFC 7845 clause 5.1 */
  OPUS_RATE = 48000,    /* samples per second, whatever the encoder had */
  OPUS_LONGEST = 5760,  /* samples of a packet: 120 ms */
  OPUS_SHORTEST = 120,  /* 2.5 ms */
  SILENT_CHANNEL = 255, /* in a mapping table */
  AAC_LC = 2,           /* audio object type, ISO/IEC 14496-3 */
  AAC_FRAME = 1024,     /* samples of an access unit */
  POSITION_SIZE = 3 * 8 /* bytes in AUDI with FVV_AUDIO_MOVES */
};

#define WRONG(issue, at, ...)                                                                                \
  return fvv_fail(diagnostic, status, FVV_ISSUE_##issue, FVV_CHUNK_AUDIO_CONFIG, at, __VA_ARGS__)

static uint32_t aac_rate(const uint8_t *record) {
  static const uint32_t rates[] = {96000, 88200, 64000, 48000, 44100, 32000, 24000,
                                   22050, 16000, 12000, 11025, 8000,  7350};
  const unsigned index = (unsigned)(record[0] & 7) << 1 | record[1] >> 7;
  return index < sizeof rates / sizeof *rates ? rates[index] : 0;
}

static unsigned aac_channels(const uint8_t *record) {
  const unsigned layout = record[1] >> 3 & 15;
  return layout == 7 ? 8 : layout <= 6 ? layout : 0;
}

int fvv_audio_codec_known(uint32_t codec) {
  return codec == FVV_CODEC_OPUS || codec == FVV_CODEC_MP4A;
}

uint32_t fvv_audio_sample_rate(const fvv_audio_config *config) {
  if (config->codec == FVV_CODEC_OPUS) return OPUS_RATE;
  return config->codec == FVV_CODEC_MP4A && config->record_size >= 2 ? aac_rate(config->record) : 0;
}

static fvv_status check_opus(const fvv_audio_config *c, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint8_t *r = c->record;
  if (c->packet_duration < OPUS_SHORTEST || c->packet_duration > OPUS_LONGEST ||
      c->packet_duration % OPUS_SHORTEST)
    WRONG(AUDIO_CONFIG_RANGE, FVV_ACFG_PACKET_DURATION,
          "packets of %" PRIu32 " samples, expected multiples of %d up to %d", c->packet_duration,
          OPUS_SHORTEST, OPUS_LONGEST);
  /* Versions up to 15 are compatible, RFC 7845 clause 5.1.1. */
  if (c->record_size < OPUS_HEAD || memcmp(r, "OpusHead", 8) != 0 || r[8] > 15)
    WRONG(AUDIO_RECORD, FVV_ACFG_SIZE, "Opus record of %zu bytes, expected 'OpusHead' of a version below 16",
          c->record_size);
  if (r[9] != c->channels)
    WRONG(AUDIO_RECORD, FVV_ACFG_SIZE + 9, "Opus record has %u channels, the track %u", r[9], c->channels);
  const size_t expected = r[18] ? OPUS_HEAD + 2 + (size_t)c->channels : OPUS_HEAD;
  if (r[18] > 1 || (!r[18] && c->channels > 2) || c->record_size != expected)
    WRONG(AUDIO_RECORD, FVV_ACFG_SIZE + 18,
          "Opus record of %zu bytes with mapping family %u, expected family 0 or 1 and %zu bytes",
          c->record_size, r[18], expected);
  if (!r[18]) return FVV_OK;
  const unsigned decoded = (unsigned)r[19] + r[20];
  if (!r[19] || r[20] > r[19] || decoded > SILENT_CHANNEL)
    WRONG(AUDIO_RECORD, FVV_ACFG_SIZE + 19,
          "Opus record has %u streams, %u of them coupled, expected 1 to 255 decoded channels", r[19], r[20]);
  for (unsigned i = 0; i < c->channels; i++)
    if (r[21 + i] >= decoded && r[21 + i] != SILENT_CHANNEL)
      WRONG(AUDIO_RECORD, FVV_ACFG_SIZE + 21 + (uint64_t)i,
            "channel %u of the Opus record is decoded channel %u of %u, expected a lower one or 255", i,
            r[21 + i], decoded);
  return FVV_OK;
}

static fvv_status check_aac(const fvv_audio_config *c, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint8_t *r = c->record;
  if (c->packet_duration != AAC_FRAME)
    WRONG(AUDIO_CONFIG_RANGE, FVV_ACFG_PACKET_DURATION, "packets of %" PRIu32 " samples, expected %d",
          c->packet_duration, AAC_FRAME);
  if (c->record_size < 2 || r[0] >> 3 != AAC_LC || !aac_rate(r))
    WRONG(AUDIO_RECORD, FVV_ACFG_SIZE,
          "AudioSpecificConfig of %zu bytes is not that of AAC-LC with a rate of the table", c->record_size);
  if (aac_channels(r) != c->channels)
    WRONG(AUDIO_RECORD, FVV_ACFG_SIZE + 1, "AudioSpecificConfig has %u channels, the track %u",
          aac_channels(r), c->channels);
  if (r[1] & 4)
    WRONG(AUDIO_RECORD, FVV_ACFG_SIZE + 1, "AudioSpecificConfig has frames of 960 samples, expected %d",
          AAC_FRAME);
  return FVV_OK;
}

static fvv_status check_config(const fvv_audio_config *c, fvv_status status, fvv_diagnostic *diagnostic) {
  if (!fvv_audio_codec_known(c->codec)) {
    char text[5];
    fvv_type_text(c->codec, text);
    return fvv_fail(diagnostic, status == FVV_ERROR_INVALID ? FVV_ERROR_UNSUPPORTED : status,
                    FVV_ISSUE_AUDIO_CODEC, FVV_CHUNK_AUDIO_CONFIG, 0,
                    "codec '%s' is not supported, expected 'opus' or 'mp4a'", text);
  }
  if (!c->channels || c->channels > 8)
    WRONG(AUDIO_CONFIG_RANGE, FVV_ACFG_CHANNELS, "%u channels, expected 1 to 8", c->channels);
  if (c->flags & FVV_AUDIO_MOVES && !(c->flags & FVV_AUDIO_PLACED))
    WRONG(AUDIO_CONFIG_RANGE, FVV_ACFG_FLAGS, "sound moves, but has no place");
  for (int i = 0; i < 3; i++)
    if (!isfinite(c->position[i]) || (!(c->flags & FVV_AUDIO_PLACED) && c->position[i] != 0))
      WRONG(AUDIO_CONFIG_RANGE, (uint64_t)(FVV_ACFG_POSITION + 8 * i),
            "position is %g, expected a finite number, and 0 without the flag", c->position[i]);
  return c->codec == FVV_CODEC_OPUS ? check_opus(c, status, diagnostic) : check_aac(c, status, diagnostic);
}

fvv_status fvv_audio_config_encode(const fvv_audio_config *config, uint8_t *out, size_t capacity,
                                   size_t *written, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_status status = FVV_ERROR_ARGUMENT;
  if (config->flags & ~(FVV_AUDIO_PLACED | FVV_AUDIO_MOVES) || config->language_size > UINT16_MAX ||
      config->record_size > UINT32_MAX)
    WRONG(AUDIO_CONFIG_PAYLOAD, FVV_ACFG_FLAGS, "flags, language or record are out of range");
  status = fvv_text_check(config->language, config->language_size, "language", status, FVV_CHUNK_AUDIO_CONFIG,
                          FVV_ACFG_SIZE + config->record_size, diagnostic);
  if (status == FVV_OK) status = check_config(config, FVV_ERROR_ARGUMENT, diagnostic);
  if (status < 0) return status;
  *written = FVV_ACFG_SIZE + config->record_size + config->language_size;
  if (capacity < *written) return FVV_ERROR_BUFFER_TOO_SMALL;
  memset(out, 0, FVV_ACFG_SIZE);
  fvv_put_u32(out + FVV_ACFG_CODEC, config->codec);
  out[FVV_ACFG_CHANNELS] = config->channels;
  out[FVV_ACFG_FLAGS] = config->flags;
  fvv_put_u16(out + FVV_ACFG_LANGUAGE_SIZE, (uint16_t)config->language_size);
  fvv_put_u32(out + FVV_ACFG_RECORD_SIZE, (uint32_t)config->record_size);
  fvv_put_u32(out + FVV_ACFG_PACKET_DURATION, config->packet_duration);
  fvv_put_u32(out + FVV_ACFG_PREROLL, config->preroll);
  for (int i = 0; i < 3; i++) fvv_put_f64(out + FVV_ACFG_POSITION + 8 * i, config->position[i]);
  memcpy(out + FVV_ACFG_SIZE, config->record, config->record_size);
  if (config->language_size)
    memcpy(out + FVV_ACFG_SIZE + config->record_size, config->language, config->language_size);
  return FVV_OK;
}

fvv_status fvv_audio_config_decode(fvv_audio_config *config, const uint8_t *payload, size_t size,
                                   const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  const fvv_status status = FVV_ERROR_INVALID;
  const fvv_limits limit = fvv_limits_or_default(limits);
  fvv_diagnostic_clear(diagnostic);
  memset(config, 0, sizeof *config);
  if (size < FVV_ACFG_SIZE)
    WRONG(AUDIO_CONFIG_PAYLOAD, 0, "payload of %zu bytes, expected at least %d", size, FVV_ACFG_SIZE);
  config->codec = fvv_get_u32(payload + FVV_ACFG_CODEC);
  config->channels = payload[FVV_ACFG_CHANNELS];
  config->flags = payload[FVV_ACFG_FLAGS];
  config->language_size = fvv_get_u16(payload + FVV_ACFG_LANGUAGE_SIZE);
  config->record_size = fvv_get_u32(payload + FVV_ACFG_RECORD_SIZE);
  config->packet_duration = fvv_get_u32(payload + FVV_ACFG_PACKET_DURATION);
  config->preroll = fvv_get_u32(payload + FVV_ACFG_PREROLL);
  for (int i = 0; i < 3; i++) config->position[i] = fvv_get_f64(payload + FVV_ACFG_POSITION + 8 * i);
  if ((uint64_t)FVV_ACFG_SIZE + config->record_size + config->language_size > size)
    WRONG(AUDIO_CONFIG_PAYLOAD, FVV_ACFG_RECORD_SIZE,
          "payload of %zu bytes, expected at least %d and a record of %zu and a language of %zu", size,
          FVV_ACFG_SIZE, config->record_size, config->language_size);
  if (config->flags & ~(FVV_AUDIO_PLACED | FVV_AUDIO_MOVES) || fvv_get_u32(payload + FVV_ACFG_RESERVED))
    WRONG(AUDIO_CONFIG_PAYLOAD, FVV_ACFG_FLAGS, "reserved bits or bytes are not 0");
  config->record = payload + FVV_ACFG_SIZE;
  config->language = (const char *)config->record + config->record_size;
  if (config->language_size > limit.max_text)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_AUDIO_CONFIG,
                    FVV_ACFG_LANGUAGE_SIZE, "language of %zu bytes, limit %" PRIu32, config->language_size,
                    limit.max_text);
  const fvv_status text =
      fvv_text_check(config->language, config->language_size, "language", status, FVV_CHUNK_AUDIO_CONFIG,
                     FVV_ACFG_SIZE + config->record_size, diagnostic);
  return text < 0 ? text : check_config(config, status, diagnostic);
}

#undef WRONG
#define WRONG(issue, at, ...)                                                                                \
  return fvv_fail(diagnostic, status, FVV_ISSUE_##issue, FVV_CHUNK_AUDIO, at, __VA_ARGS__)

static size_t table_offset(const fvv_audio_config *config) {
  return FVV_AUDI_SIZE + (config->flags & FVV_AUDIO_MOVES ? POSITION_SIZE : 0);
}

static fvv_status check_chunk(const fvv_audio_config *config, const fvv_audio_chunk *chunk, fvv_status status,
                              fvv_diagnostic *diagnostic) {
  if (!chunk->packet_count || chunk->preroll_count >= chunk->packet_count)
    WRONG(AUDIO_PAYLOAD, FVV_AUDI_PACKET_COUNT,
          "%" PRIu32 " packets, %" PRIu32 " of them pre-roll: expected one more at least",
          chunk->packet_count, chunk->preroll_count);
  for (int i = 0; i < 3; i++)
    if (!isfinite(chunk->position[i]) || (!(config->flags & FVV_AUDIO_MOVES) && chunk->position[i] != 0))
      WRONG(AUDIO_PAYLOAD, (uint64_t)(FVV_AUDI_SIZE + 8 * i), "position is %g, expected a finite number",
            chunk->position[i]);
  return FVV_OK;
}

fvv_status fvv_audio_encode(const fvv_audio_config *config, const fvv_audio_chunk *chunk,
                            const fvv_audio_packet *packets, uint8_t *out, size_t capacity, size_t *written,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_status status = FVV_ERROR_ARGUMENT;
  const fvv_status checked = check_chunk(config, chunk, status, diagnostic);
  if (checked < 0) return checked;
  const size_t table = table_offset(config);
  uint64_t size = table + 2 * (uint64_t)chunk->packet_count;
  for (uint32_t i = 0; i < chunk->packet_count; i++) {
    if (!packets[i].size || packets[i].size > UINT16_MAX)
      WRONG(AUDIO_PAYLOAD, table + 2 * (uint64_t)i, "packet %" PRIu32 " has %zu bytes, expected 1 to 65535",
            i, packets[i].size);
    size += packets[i].size;
  }
  if (size > SIZE_MAX) return FVV_ERROR_MEMORY;
  *written = (size_t)size;
  if (capacity < size) return FVV_ERROR_BUFFER_TOO_SMALL;
  fvv_put_i64(out + FVV_AUDI_START, chunk->start);
  fvv_put_u32(out + FVV_AUDI_PACKET_COUNT, chunk->packet_count);
  fvv_put_u32(out + FVV_AUDI_PREROLL_COUNT, chunk->preroll_count);
  if (config->flags & FVV_AUDIO_MOVES)
    for (int i = 0; i < 3; i++) fvv_put_f64(out + FVV_AUDI_SIZE + 8 * i, chunk->position[i]);
  uint8_t *p = out + table;
  for (uint32_t i = 0; i < chunk->packet_count; i++, p += 2) fvv_put_u16(p, (uint16_t)packets[i].size);
  for (uint32_t i = 0; i < chunk->packet_count; p += packets[i++].size)
    memcpy(p, packets[i].data, packets[i].size);
  return FVV_OK;
}

fvv_status fvv_audio_decode(const fvv_audio_config *config, const uint8_t *payload, size_t size,
                            fvv_audio_chunk *chunk, fvv_audio_packet *packets, size_t capacity,
                            fvv_diagnostic *diagnostic) {
  const fvv_status status = FVV_ERROR_INVALID;
  const size_t table = table_offset(config);
  fvv_diagnostic_clear(diagnostic);
  memset(chunk, 0, sizeof *chunk);
  if (size < table) WRONG(AUDIO_PAYLOAD, 0, "payload of %zu bytes, expected at least %zu", size, table);
  chunk->start = fvv_get_i64(payload + FVV_AUDI_START);
  chunk->packet_count = fvv_get_u32(payload + FVV_AUDI_PACKET_COUNT);
  chunk->preroll_count = fvv_get_u32(payload + FVV_AUDI_PREROLL_COUNT);
  if (config->flags & FVV_AUDIO_MOVES)
    for (int i = 0; i < 3; i++) chunk->position[i] = fvv_get_f64(payload + FVV_AUDI_SIZE + 8 * i);
  const fvv_status checked = check_chunk(config, chunk, status, diagnostic);
  if (checked < 0) return checked;
  uint64_t at = table + 2 * (uint64_t)chunk->packet_count;
  if (at > size)
    WRONG(AUDIO_PAYLOAD, FVV_AUDI_PACKET_COUNT, "%" PRIu32 " packets in a payload of %zu bytes",
          chunk->packet_count, size);
  for (uint32_t i = 0; i < chunk->packet_count; i++) {
    const size_t packet = fvv_get_u16(payload + table + 2 * (size_t)i);
    if (!packet || packet > size - at)
      WRONG(AUDIO_PAYLOAD, table + 2 * (uint64_t)i, "packet %" PRIu32 " has %zu bytes, expected 1 to %zu", i,
            packet, (size_t)(size - at));
    if (i < capacity) {
      packets[i].data = payload + at;
      packets[i].size = packet;
    }
    at += packet;
  }
  return chunk->packet_count > capacity ? FVV_ERROR_BUFFER_TOO_SMALL : FVV_OK;
}

/* |value| * a * b in 128 bits, the low half first. */
static void product(int64_t value, uint32_t a, uint32_t b, uint64_t out[2]) {
  const uint64_t magnitude = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
  uint32_t limbs[4] = {(uint32_t)magnitude, (uint32_t)(magnitude >> 32), 0, 0};
  const uint32_t factors[2] = {a, b};
  for (int f = 0; f < 2; f++) {
    uint64_t carry = 0;
    for (int i = 0; i < 4; i++) {
      carry += (uint64_t)limbs[i] * factors[f];
      limbs[i] = (uint32_t)carry;
      carry >>= 32;
    }
  }
  out[0] = (uint64_t)limbs[1] << 32 | limbs[0];
  out[1] = (uint64_t)limbs[3] << 32 | limbs[2];
}

/* Whether a tick of the scene is before, at or after a sample: -1, 0 or 1. */
static int compare(int64_t tick, fvv_rational base, int64_t sample, uint32_t rate) {
  if ((tick < 0) != (sample < 0)) return tick < 0 ? -1 : 1;
  uint64_t a[2], b[2];
  product(tick, base.numerator, rate, a);
  product(sample, base.denominator, 1, b);
  const int order = a[1] != b[1] ? (a[1] < b[1] ? -1 : 1) : a[0] != b[0] ? (a[0] < b[0] ? -1 : 1) : 0;
  return tick < 0 ? -order : order;
}

/* start + packets * duration; 0: that is no time. */
static int add(int64_t start, uint32_t packets, uint32_t duration, int64_t *sum) {
  const uint64_t samples = (uint64_t)packets * duration;
  if (samples > (uint64_t)INT64_MAX || start > INT64_MAX - (int64_t)samples) return 0;
  *sum = start + (int64_t)samples;
  return 1;
}

fvv_status fvv_audio_follow(fvv_audio_place *place, const fvv_audio_config *config,
                            fvv_rational scene_time_base, const fvv_audio_chunk *chunk, int key, int64_t time,
                            int64_t group_end, fvv_diagnostic *diagnostic) {
  const fvv_status status = FVV_ERROR_INVALID;
  const uint32_t rate = fvv_audio_sample_rate(config);
  int64_t first, last, end;
  fvv_diagnostic_clear(diagnostic);
  if (!add(chunk->start, chunk->preroll_count, config->packet_duration, &first) ||
      !add(chunk->start, chunk->packet_count - 1, config->packet_duration, &last) ||
      !add(chunk->start, chunk->packet_count, config->packet_duration, &end))
    WRONG(AUDIO_TIME, FVV_AUDI_START, "start is %" PRId64 ", beyond the range of times", chunk->start);
  if (place->has_end && key)
    WRONG(AUDIO_TIME, 0, "a chunk that is not the first of its track in the group has the key flag");
  if (place->has_end && chunk->preroll_count)
    WRONG(AUDIO_TIME, FVV_AUDI_PREROLL_COUNT, "%" PRIu32 " pre-roll packets in a chunk that is not the first",
          chunk->preroll_count);
  if (place->has_end && chunk->start != place->end)
    WRONG(AUDIO_TIME, FVV_AUDI_START, "start is %" PRId64 ", expected %" PRId64 " as the chunk before ends",
          chunk->start, place->end);
  if (compare(time, scene_time_base, first, rate) > 0)
    WRONG(AUDIO_TIME, FVV_AUDI_START, "first sample %" PRId64 " is before the chunk's time %" PRId64, first,
          time);
  if (compare(group_end, scene_time_base, last, rate) <= 0)
    WRONG(AUDIO_TIME, FVV_AUDI_START, "packet at sample %" PRId64 " is not before the group's end %" PRId64,
          last, group_end);
  place->has_end = 1;
  place->end = end;
  return FVV_OK;
}
