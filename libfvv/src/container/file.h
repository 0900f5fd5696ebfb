/* container/file.h: random access to a stream's groups and chunks through the index, which is rebuilt by
 * scanning when there is none. fvv_stream is the public handle; what fvv/stream.h says of its functions holds
 * here. */
#ifndef FVV_CONTAINER_FILE_H
#define FVV_CONTAINER_FILE_H

#include "container/records.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What TRAK says of a track that the container itself uses. */
typedef struct fvv_file_track {
  uint16_t id;
  uint8_t kind, flags;
} fvv_file_track;

/* A configuration block that was requested. */
typedef struct fvv_file_block {
  uint64_t offset;
  uint32_t crc;       /* digest as in GRUP */
  int ended;          /* a chunk that does not belong to the block follows: nothing is missing */
  fvv_bytes chunks;   /* fvv_chunk_info */
  fvv_bytes tracks;   /* fvv_file_track */
  fvv_diagnostic why; /* not ended: what follows the last intact chunk */
} fvv_file_block;

/* The chunks of a group, each list of fvv_chunk_info by offset. */
typedef struct fvv_file_table {
  fvv_bytes chunks;
  fvv_bytes unlisted; /* found by scanning: of these the header alone is intact, or they are of an unknown
                         type and follow damage */
} fvv_file_table;

typedef struct fvv_file {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_input input;
  fvv_index_state index_state;
  fvv_bytes entries;      /* fvv_index_entry, by offset */
  fvv_bytes tables;       /* fvv_file_table * for each entry; NULL: not loaded */
  fvv_bytes listed;       /* fvv_index_block, by offset: those of the index, or found by scanning */
  fvv_bytes blocks;       /* fvv_file_block *, that were read */
  fvv_bytes damage;       /* fvv_diagnostic */
  fvv_file_table scanned; /* rebuilt: of all groups */
  fvv_bytes buffer;       /* the chunk read last */
} fvv_file;

FVV_MUST_USE fvv_status fvv_file_open(const fvv_input *input, const fvv_limits *limits,
                                      const fvv_allocator *allocator, fvv_file **file,
                                      fvv_diagnostic *diagnostic);
void fvv_file_close(fvv_file *file);
fvv_index_state fvv_file_index_state(const fvv_file *file);
size_t fvv_file_damage_count(const fvv_file *file);
const fvv_diagnostic *fvv_file_damage(const fvv_file *file, size_t i);
size_t fvv_file_group_count(const fvv_file *file);
const fvv_group_info *fvv_file_group(const fvv_file *file, size_t i);
FVV_MUST_USE fvv_status fvv_file_group_chunks(fvv_file *file, size_t group, const fvv_chunk_info **chunks,
                                              size_t *count, fvv_diagnostic *diagnostic);
/* What is known of chunks that fvv_file_group_chunks, which was called for the group, does not list. */
void fvv_file_unlisted_chunks(const fvv_file *file, size_t group, const fvv_chunk_info **chunks,
                              size_t *count);
/* fvv_stream_configuration_chunks */
FVV_MUST_USE fvv_status fvv_file_configuration(fvv_file *file, size_t group, const fvv_chunk_info **chunks,
                                               size_t *count, fvv_diagnostic *diagnostic);
FVV_MUST_USE fvv_status fvv_file_read_chunk(fvv_file *file, const fvv_chunk_info *info,
                                            const uint8_t **payload, fvv_diagnostic *diagnostic);

/* Which chunks of one group make their times frames: {file, group} at first. The configuration is read when a
 * type alone does not say it. */
typedef struct fvv_frame_rule {
  fvv_file *file;
  size_t group;
  int looked;
  fvv_file_block *block; /* NULL: lost */
} fvv_frame_rule;

/* Whether a chunk of the group makes its time a frame (clause 11). Of a group whose configuration is lost
 * only types say it. */
int fvv_file_makes_frame(fvv_frame_rule *rule, const fvv_chunk_info *chunk);

/* The first of count items that rise by offset, their first member, whose offset is not below that. */
size_t fvv_first_from(const void *items, size_t count, size_t item_size, uint64_t offset);
/* The block of a group in the list; NULL: it was lost. */
const fvv_index_block *fvv_file_listed_block(const fvv_file *f, const fvv_group_info *group);
void fvv_file_release_block(fvv_file *f, fvv_file_block *block);

/* Reads the chunk at offset into the buffer and checks all of it. */
FVV_MUST_USE fvv_status fvv_file_load(fvv_file *file, uint64_t offset, fvv_chunk_header *header,
                                      fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
