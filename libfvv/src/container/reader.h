/* container/reader.h: what the checker and fvv_frames need of the push reader beyond fvv/container.h. */
#ifndef FVV_CONTAINER_READER_H
#define FVV_CONTAINER_READER_H

#include "fvv/container.h"

#ifdef __cplusplus
extern "C" {
#endif

/* reader remembers the intact configuration blocks that former has read, the last four, and former forgets
 * them. A group whose own block is damaged or lost is intact when one of them has the digest that it names
 * (clause 7.4). Both have the same allocator. */
void fvv_reader_inherit(fvv_reader *reader, fvv_reader *former);

/* Whether the headers of all chunks of the group, up to the last event, are known and follow the rules. Of
 * damaged chunks only the payload is lost then. */
int fvv_reader_lists_group(const fvv_reader *reader);

#ifdef __cplusplus
}
#endif
#endif
