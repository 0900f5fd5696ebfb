/* What libfvv's check of a Draco bitstream has found (codec_module.c), for Draco's decoder of the same bytes
 * (draco_connectivity.h). */
#ifndef FVV_WASM_DRACO_CHECKED_H
#define FVV_WASM_DRACO_CHECKED_H

#include "mesh/draco_check.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fvvcodec_checked {
  const uint8_t *data;
  uint32_t size;
  fvv_draco_symbols symbols;
} fvvcodec_checked;

extern fvvcodec_checked fvvcodec_last_check;

#ifdef __cplusplus
}
#endif

#endif
