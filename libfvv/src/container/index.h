/* container/index.h: the list of a stream's groups, as INDX carries it (clause 7.1). */
#ifndef FVV_CONTAINER_INDEX_H
#define FVV_CONTAINER_INDEX_H

#include "base/memory.h"
#include "container/header.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fvv_index_entry {
  fvv_group_info group;
  uint32_t chain_crc;
  uint32_t end_size; /* bytes of the GEND chunk; 0: the group has none */
} fvv_index_entry;

/* payload of an INDX chunk for count entries, replacing what out holds. */
FVV_MUST_USE fvv_status fvv_index_encode(const fvv_index_entry *entries, size_t count, fvv_bytes *out);
/* entries: an array of fvv_index_entry. index_offset: where the INDX header stands; all groups lie before it.
 */
FVV_MUST_USE fvv_status fvv_index_decode(const uint8_t *payload, size_t size, uint64_t index_offset,
                                         const fvv_limits *limits, fvv_bytes *entries,
                                         fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
