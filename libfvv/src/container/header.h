/* container/header.h: the 32 bytes before every payload (clause 4), and the registered types. */
#ifndef FVV_CONTAINER_HEADER_H
#define FVV_CONTAINER_HEADER_H

#include "base/layout.h"
#include "fvv/container.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where a type may be (clause 3.3). */
typedef enum fvv_place {
  FVV_PLACE_UNKNOWN = 0, /* not in the registry */
  FVV_PLACE_CONFIGURATION,
  FVV_PLACE_GROUP, /* GRUP and GEND */
  FVV_PLACE_FRAME,
  FVV_PLACE_END /* INDX and FOOT */
} fvv_place;
/* TILE with the key flag is a chunk of frames, without it one of the configuration. */
fvv_place fvv_chunk_place(uint32_t type, uint8_t flags);
/* Registered flags of a known type; chunks of frames may have FVV_FLAG_KEY as well. */
uint8_t fvv_chunk_flags(uint32_t type);
/* The kind of track that carries a frame type, 0 for types without such a rule. */
uint8_t fvv_chunk_track_kind(uint32_t type);
/* Whether a chunk makes its time a frame (clause 11): 1, 0, or -1 if its track decides. */
int fvv_type_makes_frame(uint32_t type);
/* A kind that this version has no chunks for: the track is ignored. */
int fvv_kind_is_foreign(uint8_t kind);
/* kind, flags: of the track that the chunk names, 0 if it is not known. */
int fvv_makes_frame(uint32_t type, uint8_t kind, uint8_t flags);

/* Fills header_crc too. */
void fvv_header_write(fvv_chunk_header *header, uint8_t out[FVV_CHUNK_HEADER_SIZE]);
/* 1 when the CRC of the header matches and its type is printable, else 0. */
int fvv_header_read(fvv_chunk_header *header, const uint8_t bytes[FVV_CHUNK_HEADER_SIZE]);
/* Stricter, for scanning: bytes whose CRC matches by chance must also look like a header (clause 7.4). */
int fvv_header_plausible(const fvv_chunk_header *header, uint64_t max_payload);
/* Continues a chain CRC (digest of a block, chain of a group) with bytes 0 to 27 of a header. Not with all
 * 32: a CRC over bytes that end with their own CRC does not depend on them. */
uint32_t fvv_header_chain(uint32_t crc, const fvv_chunk_header *header);
/* Header, payload and padding. size < 2^63. */
uint64_t fvv_chunk_extent(uint64_t size);

/* The 24 bytes at the beginning (clause 3.1, 3.2). FVV_ERROR_INVALID with issue SIGNATURE: no fvv stream;
 * FVV_ERROR_UNSUPPORTED: it needs a newer reader; FVV_ERROR_DAMAGED, other FVV_ERROR_INVALID: what follows
 * may still be read. */
fvv_status fvv_file_header_check(const uint8_t bytes[FVV_FILE_HEADER_SIZE], fvv_diagnostic *diagnostic);

/* Rules of a single header: flags, and fields that its type does not use (clauses 4.2, 4.6). */
fvv_status fvv_header_check(const fvv_chunk_header *header, uint64_t offset, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
