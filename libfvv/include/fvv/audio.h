/* fvv/audio.h: what an audio track is (ACFG) and its packets (AUDI). Spec: spec/fvv.md clause 20. No samples
 * here: see fvv_media. */
#ifndef FVV_AUDIO_H
#define FVV_AUDIO_H

#include "fvv/format.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ACFG. codec: FVV_CODEC_OPUS or FVV_CODEC_MP4A. record: of Opus the identification header of RFC 7845 clause
 * 5.1 ("OpusHead"), of AAC the AudioSpecificConfig: both as WebCodecs takes them. A tick of the track is one
 * sample. Pointers are borrowed. */
typedef struct fvv_audio_config {
  uint32_t codec;
  uint8_t channels;         /* 1 ... 8, of the decoded sound */
  uint8_t flags;            /* FVV_AUDIO_PLACED, FVV_AUDIO_MOVES */
  uint32_t packet_duration; /* samples that a packet decodes to, per channel */
  uint32_t preroll;         /* packets to decode before the output is right */
  double position[3];       /* metres, world axes; 0 without FVV_AUDIO_PLACED */
  const uint8_t *record;
  size_t record_size;
  const char *language; /* BCP 47, not terminated; may be empty */
  size_t language_size;
} fvv_audio_config;

/* As for fvv_scene_encode in fvv/container.h: sizes are exact, diagnostic may be NULL. Errors:
 * FVV_ISSUE_AUDIO_CONFIG_PAYLOAD, FVV_ISSUE_AUDIO_CODEC, FVV_ISSUE_AUDIO_CONFIG_RANGE,
 * FVV_ISSUE_AUDIO_RECORD, FVV_ISSUE_TEXT. */
FVV_API FVV_MUST_USE fvv_status fvv_audio_config_encode(const fvv_audio_config *config, uint8_t *out,
                                                        size_t capacity, size_t *written,
                                                        fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_audio_config_decode(fvv_audio_config *config, const uint8_t *payload,
                                                        size_t size, const fvv_limits *limits,
                                                        fvv_diagnostic *diagnostic);
/* Whether this library checks the packets of a codec. fvv_audio_config_decode fills *config also when it
 * returns FVV_ERROR_UNSUPPORTED for one that it does not know. */
FVV_API int fvv_audio_codec_known(uint32_t codec);
/* Samples per second by the record; 0 for other codecs. */
FVV_API uint32_t fvv_audio_sample_rate(const fvv_audio_config *config);

/* AUDI. The output of packet i begins at start + i * packet_duration; the first preroll_count packets repeat
 * the end of the group before. */
typedef struct fvv_audio_chunk {
  int64_t start; /* ticks of the track; the codec's delay is subtracted */
  uint32_t packet_count, preroll_count;
  double position[3]; /* metres, with FVV_AUDIO_MOVES; else 0 */
} fvv_audio_chunk;

/* 1 to 65,535 bytes. */
typedef struct fvv_audio_packet {
  const uint8_t *data;
  size_t size;
} fvv_audio_packet;

/* Errors: FVV_ISSUE_AUDIO_PAYLOAD. */
FVV_API FVV_MUST_USE fvv_status fvv_audio_encode(const fvv_audio_config *config, const fvv_audio_chunk *chunk,
                                                 const fvv_audio_packet *packets, uint8_t *out,
                                                 size_t capacity, size_t *written,
                                                 fvv_diagnostic *diagnostic);
/* packets: room for capacity of them, which point into payload. FVV_ERROR_BUFFER_TOO_SMALL: *chunk is set and
 * has more packets; no chunk has more than size / 3. */
FVV_API FVV_MUST_USE fvv_status fvv_audio_decode(const fvv_audio_config *config, const uint8_t *payload,
                                                 size_t size, fvv_audio_chunk *chunk,
                                                 fvv_audio_packet *packets, size_t capacity,
                                                 fvv_diagnostic *diagnostic);

/* Where an audio track is in its group. Zero-initialise it where a group begins. */
typedef struct fvv_audio_place {
  int has_end;
  int64_t end; /* ticks of the track: of the chunks so far */
} fvv_audio_place;

/* Checks key flag and times of the next chunk of a track in its group (clause 20.2) and moves on. key:
 * whether it has the key flag; time: of the chunk header; group_end: of the group, both in ticks of the
 * scene. FVV_ISSUE_AUDIO_TIME. */
FVV_API FVV_MUST_USE fvv_status fvv_audio_follow(fvv_audio_place *place, const fvv_audio_config *config,
                                                 fvv_rational scene_time_base, const fvv_audio_chunk *chunk,
                                                 int key, int64_t time, int64_t group_end,
                                                 fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
