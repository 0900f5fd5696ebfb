/* base/memory.h: the caller's allocator and limits, and a block that grows as its bytes arrive. */
#ifndef FVV_BASE_MEMORY_H
#define FVV_BASE_MEMORY_H

#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The given allocator, or malloc's when NULL or without resize. */
fvv_allocator fvv_allocator_or_default(const fvv_allocator *allocator);

/* NULL for size 0 as well: ask for at least one byte. Memory is not cleared. */
void *fvv_allocate(const fvv_allocator *allocator, size_t size);
/* count * size, NULL when that overflows. */
void *fvv_allocate_array(const fvv_allocator *allocator, size_t count, size_t size);
void *fvv_allocate_zeroed(const fvv_allocator *allocator, size_t size);
void fvv_release(const fvv_allocator *allocator, void *pointer, size_t size);

/* Makes room for extra more bytes; capacity at least doubles, so that appending is linear. */
FVV_MUST_USE fvv_status fvv_bytes_reserve(fvv_bytes *bytes, size_t extra);
FVV_MUST_USE fvv_status fvv_bytes_append(fvv_bytes *bytes, const void *source, size_t size);

/* The number as unsigned LEB128. */
FVV_MUST_USE fvv_status fvv_bytes_append_uleb(fvv_bytes *bytes, uint64_t value);

/* A copy of the caller's limits, defaults for fields that its struct_size does not reach; NULL: all defaults.
 */
fvv_limits fvv_limits_or_default(const fvv_limits *limits);

/* For encoders: FVV_ERROR_INPUT with FVV-7001 when readers with default limits would refuse what is encoded.
 * most: the limit. what: what is counted, as in "bytes of a camera name". */
FVV_MUST_USE fvv_status fvv_readable_check(uint64_t count, uint64_t most, const char *what,
                                           uint32_t chunk_type, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
