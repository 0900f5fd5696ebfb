/* container/records.h: the payloads that the container itself writes: the list of groups in INDX and the
 * list of chunks in GEND. */
#ifndef FVV_CONTAINER_RECORDS_H
#define FVV_CONTAINER_RECORDS_H

#include "base/memory.h"
#include "container/header.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The list of a stream's groups, as INDX carries it (clause 7.1). */

typedef struct fvv_index_entry {
  fvv_group_info group;
  uint32_t chain_crc;
  uint32_t end_size; /* bytes of the GEND chunk; 0: the group has none */
} fvv_index_entry;

/* A configuration block that groups name. */
typedef struct fvv_index_block {
  uint64_t offset;
  uint32_t size, digest;
} fvv_index_block;

/* The most bytes that a payload of this type may have; for INDX those that max_groups groups take. */
uint64_t fvv_payload_limit(const fvv_limits *limits, uint32_t type);

/* payload of an INDX chunk, replacing what out holds. entries: fvv_index_entry; blocks: fvv_index_block,
 * those of the entries in order. */
FVV_MUST_USE fvv_status fvv_index_encode(const fvv_bytes *entries, const fvv_bytes *blocks, fvv_bytes *out);
/* The opposite. index_offset: where the INDX header is; all groups lie before it. */
FVV_MUST_USE fvv_status fvv_index_decode(const uint8_t *payload, size_t size, uint64_t index_offset,
                                         const fvv_limits *limits, fvv_bytes *entries, fvv_bytes *blocks,
                                         fvv_diagnostic *diagnostic);

/* The list of a group's chunks, as GEND carries it (clause 6.3). Writer and reader build
 * the same table from the headers that pass; the reader compares bytes. */

/* Distinct (type, track, flags) in one group: bounds the search for a row. */
enum { FVV_MAX_GROUP_KINDS = 1024 };

typedef struct fvv_group_table {
  uint32_t sequence;
  uint32_t chunk_count; /* GRUP included */
  uint32_t chain_crc;
  uint32_t frame_count;
  uint32_t kind_count;
  uint32_t last_kind;
  int64_t frame_time; /* of the last chunk of a track */
  int64_t last_time;  /* of the last chunk; the group's start before the first */
  fvv_bytes kinds;    /* rows of FVV_GEND_KIND_SIZE bytes */
  fvv_bytes entries;  /* the table after the rows */
} fvv_group_table;

void fvv_group_table_init(fvv_group_table *table, const fvv_allocator *allocator);
void fvv_group_table_free(fvv_group_table *table);
/* Starts over with a GRUP chunk. */
void fvv_group_table_begin(fvv_group_table *table, const fvv_chunk_header *group, uint32_t sequence);
/* 0: the chunk would be of one kind more than a group may have. */
int fvv_group_table_has_room(const fvv_group_table *table, const fvv_chunk_header *header);
/* makes_frame: the chunk makes its time a frame. FVV_ERROR_LIMIT: more kinds than a group may have. */
FVV_MUST_USE fvv_status fvv_group_table_add(fvv_group_table *table, const fvv_chunk_header *header,
                                            int makes_frame);
/* The GEND payload for what was added, replacing what out holds. */
FVV_MUST_USE fvv_status fvv_group_table_encode(const fvv_group_table *table, fvv_bytes *out);

/* Lists the chunks of a GEND payload: out receives an array of fvv_chunk_info with absolute offsets,
 * group_offset being the GRUP header's; checks every bound, that the chunks fill group_size and that the
 * payload is whole. Which of them make frames is for the caller, who knows the tracks. */
FVV_MUST_USE fvv_status fvv_group_table_decode(const uint8_t *payload, size_t size, uint64_t group_offset,
                                               int64_t group_start, uint64_t chunks_size,
                                               const fvv_limits *limits, fvv_bytes *out,
                                               fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
