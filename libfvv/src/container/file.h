/* container/file.h: the fields of fvv_file, for code that needs more than its public functions. */
#ifndef FVV_CONTAINER_FILE_H
#define FVV_CONTAINER_FILE_H

#include "container/records.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A configuration block that was requested. */
typedef struct fvv_file_block {
  uint64_t offset;
  uint32_t crc;       /* digest as in GRUP */
  int ended;          /* a chunk that does not belong to the block follows: nothing is missing */
  fvv_bytes chunks;   /* fvv_chunk_info */
  fvv_diagnostic why; /* not ended: what follows the last intact chunk */
} fvv_file_block;

struct fvv_file {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_input input;
  fvv_index_state index_state;
  fvv_bytes entries; /* fvv_index_entry, by offset */
  fvv_bytes tables;  /* fvv_bytes * for each entry, of fvv_chunk_info; NULL: not loaded */
  fvv_bytes listed;  /* fvv_index_block, by offset: those of the index, or found by scanning */
  fvv_bytes blocks;  /* fvv_file_block *, that were read */
  fvv_bytes damage;  /* fvv_diagnostic */
  fvv_bytes scanned; /* rebuilt: fvv_chunk_info of every intact frame chunk, by offset */
  fvv_bytes buffer;  /* the chunk read last */
};

/* Reads the chunk at offset into the buffer and checks all of it. */
FVV_MUST_USE fvv_status fvv_file_load(fvv_file *file, uint64_t offset, fvv_chunk_header *header,
                                      fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
