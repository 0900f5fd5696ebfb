/* base/diagnostic.h: how a failure is recorded. The first error of a call wins. */
#ifndef FVV_BASE_DIAGNOSTIC_H
#define FVV_BASE_DIAGNOSTIC_H

#include "fvv/format.h"
#include "fvv/types.h"

/* MinGW-w64 has two sets of these functions: the base layer's are compiled with those of C99. */
#if defined(__MINGW32__) && !defined(__clang__)
#define FVV_PRINTF(text, first) __attribute__((format(gnu_printf, text, first)))
#elif defined(__GNUC__)
#define FVV_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define FVV_PRINTF(text, first)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Fills *diagnostic unless it is NULL or holds an error already; returns status, so that a function can end
 * with "return fvv_fail(...)". The message is one sentence without offset or issue number. */
fvv_status fvv_fail(fvv_diagnostic *diagnostic, fvv_status status, uint32_t issue, uint32_t chunk_type,
                    uint64_t offset, const char *format, ...) FVV_PRINTF(6, 7);

/* Every public call with a diagnostic begins with this. */
void fvv_diagnostic_clear(fvv_diagnostic *diagnostic);

/* Makes an offset within a payload absolute, and names the chunk when the callee did not. */
void fvv_diagnostic_rebase(fvv_diagnostic *diagnostic, uint64_t payload_offset, uint32_t chunk_type);

/* A four-character code as text; characters outside printable ASCII become '?'. out: 5 bytes. */
void fvv_type_text(uint32_t type, char out[5]);

#ifdef __cplusplus
}
#endif
#endif
