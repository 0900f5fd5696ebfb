/* container/chunk_order.h: which chunk may follow which (clauses 3.3, 4.4 to 7.2), as one state machine. The
 * writer applies it before it writes a chunk, the reader before it reports one. */
#ifndef FVV_CONTAINER_CHUNK_ORDER_H
#define FVV_CONTAINER_CHUNK_ORDER_H

#include "container/records.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fvv_configuration_state {
  FVV_CONFIGURATION_NONE, /* not seen yet */
  FVV_CONFIGURATION_GOOD,
  FVV_CONFIGURATION_LOST,   /* bytes were lost in the block; a group's digest may still prove it whole */
  FVV_CONFIGURATION_BROKEN, /* a chunk of the block broke a rule */
  FVV_CONFIGURATION_UNSEEN  /* the reader joined after it: nothing is known */
} fvv_configuration_state;

typedef struct fvv_chunk_order_track {
  uint16_t id;
  uint8_t kind;
  uint8_t flags;    /* FVV_TRACK_FLAG_... */
  uint8_t seen;     /* a chunk of its kind was in this group */
  uint8_t laid_out; /* a TILE was in this group */
  int64_t last_time;
  int64_t layout_time; /* of the TILE */
} fvv_chunk_order_track;

/* Intact configuration blocks that are remembered: a group may name any of them (clause 7.4). */
enum { FVV_KNOWN_BLOCKS = 4 };

typedef struct fvv_known_block {
  int used;
  uint32_t digest;
  fvv_bytes tracks; /* fvv_chunk_order_track */
} fvv_known_block;

typedef struct fvv_chunk_order {
  fvv_limits limits;
  fvv_allocator allocator;
  fvv_configuration_state configuration;
  int in_block; /* a configuration block is open: SCEN came, GRUP not yet */
  int in_group;
  int suspect; /* something was lost or wrong since the last GRUP or SCEN: further errors would only repeat it
                */
  int listed;  /* the headers of all chunks of the group that was read last are known and follow the rules;
                  payloads may be damaged */
  int gaps;    /* anything was lost or wrong, or the reader joined late: totals can't be compared */
  int hole;    /* the same since the last GRUP: numbers of groups that are missing are no further problem */
  int joined;  /* the stream began elsewhere: its index and footer describe more than what comes */
  int joining; /* joined, and no group has come yet: it may have any number */
  int index_seen, footer_seen;
  int block_has_more; /* the block holds more than SCEN and TRAK: no TRAK may follow */
  int scene_seen;
  uint8_t next_counter;
  fvv_scene scene; /* of the first block */
  uint32_t configuration_crc, next_sequence, index_crc;
  uint64_t configuration_offset, group_offset, index_offset;
  int64_t group_start, group_end, last_end;
  fvv_group_table table;
  fvv_bytes tracks; /* fvv_chunk_order_track */
  fvv_known_block known[FVV_KNOWN_BLOCKS];
  size_t next_known; /* that is replaced next */
  fvv_bytes blocks;  /* fvv_index_block, that groups name */
  fvv_bytes groups;  /* fvv_index_entry, complete groups only */
  fvv_bytes scratch;
} fvv_chunk_order;

void fvv_chunk_order_init(fvv_chunk_order *order, const fvv_limits *limits, const fvv_allocator *allocator);
void fvv_chunk_order_free(fvv_chunk_order *order);

/* The counter that the next chunk of this type has. */
uint8_t fvv_chunk_order_counter(const fvv_chunk_order *order, uint32_t type);

/* Whether an intact chunk at offset may come now. Changes nothing but scratch space and, after damage,
 * whether the group is listed. FVV_ERROR_INVALID: a rule is broken, and the diagnostic names it;
 * FVV_ERROR_DAMAGED: the chunk is good, but something before it is missing; FVV_ERROR_UNSUPPORTED,
 * FVV_ERROR_LIMIT, FVV_ERROR_MEMORY: reading cannot go on. */
FVV_MUST_USE fvv_status fvv_chunk_order_check(fvv_chunk_order *order, const fvv_chunk_header *header,
                                              const uint8_t *payload, uint64_t offset,
                                              fvv_diagnostic *diagnostic);
/* Takes the chunk, broken rules or not. Only memory and limits can fail. */
FVV_MUST_USE fvv_status fvv_chunk_order_apply(fvv_chunk_order *order, const fvv_chunk_header *header,
                                              const uint8_t *payload, uint64_t offset);
/* Bytes were lost: the open group and an unfinished block are no longer valid. */
void fvv_chunk_order_lost(fvv_chunk_order *order);
/* The same for the payload of a chunk alone: the header is intact. Only memory can fail. */
FVV_MUST_USE fvv_status fvv_chunk_order_damaged(fvv_chunk_order *order, const fvv_chunk_header *header,
                                                uint64_t offset);
/* A chunk broke a rule: its group, or its configuration block, is no longer valid. */
void fvv_chunk_order_broken(fvv_chunk_order *order, const fvv_chunk_header *header);
/* Something before the chunk that was applied last is missing; the chunk itself is good. */
void fvv_chunk_order_missing(fvv_chunk_order *order);
/* order remembers the configuration blocks that former knew, which forgets them. */
void fvv_chunk_order_inherit(fvv_chunk_order *order, fvv_chunk_order *former);
/* The open group ends without GEND: its end is lost. */
void fvv_chunk_order_abandon_group(fvv_chunk_order *order);
/* No damage since the open group began, and its configuration is not damaged. */
int fvv_chunk_order_group_intact(const fvv_chunk_order *order);

/* Index of everything so far, and the footer that fits it. */
FVV_MUST_USE fvv_status fvv_chunk_order_index(const fvv_chunk_order *order, fvv_bytes *payload);
void fvv_footer_write(uint64_t index_offset, uint64_t file_size, uint32_t index_crc, uint8_t *payload);

#ifdef __cplusplus
}
#endif
#endif
