/* background/background.h: the rules of clause 18 that decoder and encoder share. */
#ifndef FVV_BACKGROUND_BACKGROUND_H
#define FVV_BACKGROUND_BACKGROUND_H

#include "base/diagnostic.h"
#include "base/layout.h"
#include "fvv/background.h"

/* All rules that concern one entry. offset: of the entry in the payload, or of the file of a picture. */
FVV_MUST_USE fvv_status fvv_light_check(const fvv_light *light, uint64_t offset, fvv_diagnostic *diagnostic);
FVV_MUST_USE fvv_status fvv_background_picture_check(const fvv_background_picture *picture, uint64_t offset,
                                                     fvv_diagnostic *diagnostic);

/* A breach of a rule of this clause, which ends the call: issue without its prefix, offset in the payload. */
#define WRONG(issue, offset, ...)                                                                            \
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_##issue, FVV_CHUNK_BACKGROUND, offset, __VA_ARGS__)

#endif
