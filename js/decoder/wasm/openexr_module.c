/* The module of OpenEXR: what can be told of such a picture without decoding it. */
#include "base/diagnostic.h"
#include "codec_module.h"
#include "video/oexr.h"

/* fvv_status, as fvv_oexr_inspect. */
FVVJS_EXPORT int32_t fvvcodec_check(const uint8_t *data, uint32_t size, uint32_t width, uint32_t height) {
  fvv_diagnostic_clear(&fvvcodec_diagnostic);
  return fvv_oexr_inspect(width, height, data, size, &fvvcodec_diagnostic);
}
