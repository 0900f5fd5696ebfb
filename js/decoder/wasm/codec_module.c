#include "codec_module.h"

#include <stdlib.h>

#include "base/diagnostic.h"

fvv_diagnostic fvvcodec_diagnostic;

FVVJS_EXPORT void *fvvcodec_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT void fvvcodec_free(void *pointer) {
  free(pointer);
}
FVVJS_EXPORT const fvv_diagnostic *fvvcodec_why(void) {
  return &fvvcodec_diagnostic;
}
