/* DCFG: what the payloads of a data track are (clause 21.1). */
#include "fvv/data.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/text.h"

static fvv_status check_text(const char *text, size_t size, const char *what, fvv_status status, size_t at,
                             fvv_diagnostic *diagnostic) {
  return fvv_text_check(text, size, what, status, FVV_CHUNK_DATA_CONFIG, at, diagnostic);
}

/* Texts of the right size. */
static fvv_status check_config(const fvv_data_config *c, fvv_status status, fvv_diagnostic *diagnostic) {
  const size_t at = FVV_DCFG_SIZE + c->record_size;
  if (!c->media_type_size)
    return fvv_fail(diagnostic, status, FVV_ISSUE_DATA_CONFIG_PAYLOAD, FVV_CHUNK_DATA_CONFIG,
                    FVV_DCFG_MEDIA_TYPE_SIZE, "the media type is empty");
  const fvv_status checked =
      check_text(c->media_type, c->media_type_size, "media type", status, at, diagnostic);
  if (checked < 0) return checked;
  return check_text(c->codec, c->codec_size, "codec", status, at + c->media_type_size, diagnostic);
}

fvv_status fvv_data_config_encode(const fvv_data_config *config, uint8_t *out, size_t capacity,
                                  size_t *written, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (config->media_type_size > UINT16_MAX || config->codec_size > UINT16_MAX ||
      config->record_size > UINT32_MAX)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_DATA_CONFIG_PAYLOAD, FVV_CHUNK_DATA_CONFIG, 0,
                    "media type, codec or record is too long");
  const fvv_status status = check_config(config, FVV_ERROR_ARGUMENT, diagnostic);
  if (status < 0) return status;
  *written = FVV_DCFG_SIZE + config->record_size + config->media_type_size + config->codec_size;
  if (capacity < *written) return FVV_ERROR_BUFFER_TOO_SMALL;
  fvv_put_u16(out + FVV_DCFG_MEDIA_TYPE_SIZE, (uint16_t)config->media_type_size);
  fvv_put_u16(out + FVV_DCFG_CODEC_SIZE, (uint16_t)config->codec_size);
  fvv_put_u32(out + FVV_DCFG_RECORD_SIZE, (uint32_t)config->record_size);
  uint8_t *p = out + FVV_DCFG_SIZE;
  if (config->record_size) memcpy(p, config->record, config->record_size);
  memcpy(p += config->record_size, config->media_type, config->media_type_size);
  if (config->codec_size) memcpy(p + config->media_type_size, config->codec, config->codec_size);
  return FVV_OK;
}

fvv_status fvv_data_config_decode(fvv_data_config *config, const uint8_t *payload, size_t size,
                                  const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(config, 0, sizeof *config);
  const uint32_t most = fvv_limits_or_default(limits).max_text;
  if (size < FVV_DCFG_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DATA_CONFIG_PAYLOAD, FVV_CHUNK_DATA_CONFIG, 0,
                    "payload of %zu bytes, expected at least %d", size, FVV_DCFG_SIZE);
  config->media_type_size = fvv_get_u16(payload + FVV_DCFG_MEDIA_TYPE_SIZE);
  config->codec_size = fvv_get_u16(payload + FVV_DCFG_CODEC_SIZE);
  config->record_size = fvv_get_u32(payload + FVV_DCFG_RECORD_SIZE);
  if ((uint64_t)FVV_DCFG_SIZE + config->record_size + config->media_type_size + config->codec_size > size)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DATA_CONFIG_PAYLOAD, FVV_CHUNK_DATA_CONFIG,
                    FVV_DCFG_RECORD_SIZE,
                    "payload of %zu bytes, expected at least %d, a record of %zu, a media type of %zu and a "
                    "codec of %zu",
                    size, FVV_DCFG_SIZE, config->record_size, config->media_type_size, config->codec_size);
  config->record = payload + FVV_DCFG_SIZE;
  config->media_type = (const char *)config->record + config->record_size;
  config->codec = config->media_type + config->media_type_size;
  if (config->media_type_size > most || config->codec_size > most)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_DATA_CONFIG, 0,
                    "media type of %zu and codec of %zu bytes, limit %u", config->media_type_size,
                    config->codec_size, (unsigned)most);
  return check_config(config, FVV_ERROR_INVALID, diagnostic);
}
