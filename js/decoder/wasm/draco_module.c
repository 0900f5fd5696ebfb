/* The module of Draco: libfvv's check of bitstreams and its bridge to the decoder. */
#include "base/diagnostic.h"
#include "base/memory.h"
#include "codec_module.h"
#include "mesh/draco_bridge.h"
#include "mesh/draco_check.h"

/* fvv_status, as fvv_draco_check. */
FVVJS_EXPORT int32_t fvvcodec_check(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                                    int has_texture, int has_normals) {
  const fvv_draco_counts counts = {vertices, faces};
  const fvv_allocator allocator = fvv_allocator_or_default(NULL);
  fvv_diagnostic_clear(&fvvcodec_diagnostic);
  return fvv_draco_check(data, size, counts, has_texture, has_normals, &allocator, &fvvcodec_diagnostic);
}

/* fvv_status. What came out lies where fvvcodec_array says. */
FVVJS_EXPORT int32_t fvvcodec_decode(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                                     int has_texture, int has_normals) {
  const fvv_status status = fvvcodec_prepare(vertices, faces, has_texture, has_normals);
  return status == FVV_OK ? fvv_draco_decode(data, size, &fvvcodec_mesh, &fvvcodec_diagnostic) : status;
}
