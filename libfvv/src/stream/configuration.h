/* stream/configuration.h: builds a configuration from the chunks of its block. */
#ifndef FVV_STREAM_CONFIGURATION_H
#define FVV_STREAM_CONFIGURATION_H

#include "base/memory.h"
#include "fvv/stream.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fvv_configuration_builder {
  fvv_configuration view; /* complete after fvv_configuration_complete */
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_bytes tracks, cameras, videos, sounds, datas, metadata;
  fvv_bytes layouts; /* tile_layout of each TILE chunk */
  fvv_bytes stopped; /* uint16_t: tracks whose configuration is not known or wrong, and that are left out */
  int textured;      /* a TEXR came, good or not */
  int has_more;      /* more than SCEN and TRAK came */
  fvv_bytes copies;  /* copied payloads: names and records point into them */
} fvv_configuration_builder;

void fvv_configuration_init(fvv_configuration_builder *builder, const fvv_limits *limits,
                            const fvv_allocator *allocator);
void fvv_configuration_free(fvv_configuration_builder *builder);
/* Takes one chunk of configuration; SCEN starts over. Offsets of diagnostics are absolute: offset is the
 * header's. */
FVV_MUST_USE fvv_status fvv_configuration_add(fvv_configuration_builder *builder,
                                              const fvv_chunk_header *header, const uint8_t *payload,
                                              uint64_t offset, fvv_diagnostic *diagnostic);
/* Whether the block stays good although fvv_configuration_add failed: the chunk is ancillary, or its video is
 * of a kind that is not known. The track that it configures is then left out (clause 5). */
int fvv_configuration_survives(const fvv_chunk_header *header, fvv_status status);
/* Reports audio tracks without ACFG, or data tracks without DCFG, which are left out: the block stays good.
 * After fvv_configuration_complete. */
FVV_MUST_USE fvv_status fvv_configuration_check_silent(const fvv_configuration_builder *builder,
                                                       uint64_t offset, fvv_diagnostic *diagnostic);
/* Checks what concerns several chunks (issues 2106, 2201 to 2204, 4102, 4103) and fills view. */
FVV_MUST_USE fvv_status fvv_configuration_complete(fvv_configuration_builder *builder, uint64_t offset,
                                                   fvv_diagnostic *diagnostic);
/* Checks a layout of a track against its configuration: cameras, their pictures, the frame. Offsets of
 * diagnostics are relative to the payload of TILE. */
FVV_MUST_USE fvv_status fvv_configuration_check_tiles(const fvv_configuration *configuration,
                                                      const fvv_video_layout *video, const fvv_tile *tiles,
                                                      size_t count, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
