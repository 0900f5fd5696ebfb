/* The module of fast meshes: libfvv's check of their streams, and meshoptimizer. */
#include "codec_module.h"
#include "mesh/fast_decode.h"

/* fvv_status, as fvv_fast_decode. What came out lies where fvvcodec_array says. */
FVVJS_EXPORT int32_t fvvcodec_decode(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                                     int has_texture, int has_normals) {
  const fvv_status status = fvvcodec_prepare(vertices, faces, has_texture, has_normals);
  fvv_mesh *mesh = &fvvcodec_mesh;
  const fvv_mesh_header header = {FVV_MESH_FAST, vertices,           faces,
                                  size,          mesh->texture_bits, mesh->normal_bits};
  return status == FVV_OK ? fvv_fast_decode(data, &header, mesh, &fvvcodec_diagnostic) : status;
}
