/* base/text.h: names and metadata are UTF-8. */
#ifndef FVV_BASE_TEXT_H
#define FVV_BASE_TEXT_H

#include "fvv/types.h"

#include <stddef.h>
#include <stdint.h>

/* 1 when the bytes are well-formed UTF-8 (Unicode 15, table 3-7) without NUL; else 0 and *bad, if not NULL,
 * is the offset of the first byte that is not. */
int fvv_text_valid(const uint8_t *text, size_t size, size_t *bad);

/* The same for a text at offset in a chunk of that type: FVV_OK, or status and a diagnostic with what and
 * FVV_ISSUE_TEXT. what: "camera name". */
fvv_status fvv_text_check(const char *text, size_t size, const char *what, fvv_status status, uint32_t type,
                          uint64_t offset, fvv_diagnostic *diagnostic);

#endif
