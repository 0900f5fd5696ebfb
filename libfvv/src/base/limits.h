/* base/limits.h: what a reader is willing to hold. */
#ifndef FVV_BASE_LIMITS_H
#define FVV_BASE_LIMITS_H

#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A copy of the caller's limits, defaults for fields that its struct_size does not reach; NULL: all defaults.
 */
fvv_limits fvv_limits_or_default(const fvv_limits *limits);

#ifdef __cplusplus
}
#endif
#endif
