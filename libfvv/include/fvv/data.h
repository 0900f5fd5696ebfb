/* fvv/data.h: tracks of timed payloads that the format does not look into (DCFG, DATA): captions, marks,
 * splats. Spec: spec/fvv.md clause 21. The payload of a DATA chunk is what fvv_stream_read_chunk and
 * fvv_frames give. */
#ifndef FVV_DATA_H
#define FVV_DATA_H

#include "fvv/format.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* DCFG. Pointers are borrowed; texts are not terminated. */
typedef struct fvv_data_config {
  const char *media_type; /* RFC 6838, "text/vtt"; not empty */
  size_t media_type_size; /* up to 65,535 bytes, as codec_size */
  const char *codec;      /* what the media type leaves open, as in RFC 6381; may be empty */
  size_t codec_size;
  const uint8_t *record; /* what a decoder needs before the first payload; may be empty */
  size_t record_size;
} fvv_data_config;

/* As for fvv_scene_encode in fvv/container.h: sizes are exact, diagnostic may be NULL. Errors:
 * FVV_ISSUE_DATA_CONFIG_PAYLOAD, FVV_ISSUE_TEXT; decoding also FVV_ISSUE_LIMIT. */
FVV_API FVV_MUST_USE fvv_status fvv_data_config_encode(const fvv_data_config *config, uint8_t *out,
                                                       size_t capacity, size_t *written,
                                                       fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_data_config_decode(fvv_data_config *config, const uint8_t *payload,
                                                       size_t size, const fvv_limits *limits,
                                                       fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
