/* Room for the mesh that a codec module decodes. */
#include "base/diagnostic.h"
#include "base/memory.h"
#include "codec_module.h"
#include "mesh/storage.h"

fvv_mesh fvvcodec_mesh;

FVVJS_EXPORT void fvvcodec_release(void) {
  fvv_mesh_free(&fvvcodec_mesh);
}

fvv_status fvvcodec_prepare(uint32_t vertices, uint32_t faces, int has_texture, int has_normals) {
  fvvcodec_release();
  fvv_diagnostic_clear(&fvvcodec_diagnostic);
  fvvcodec_mesh.allocator = fvv_allocator_or_default(NULL);
  fvvcodec_mesh.vertex_count = vertices;
  fvvcodec_mesh.face_count = faces;
  /* No codec asks how many bits there are, only whether there are any. */
  fvvcodec_mesh.texture_bits = has_texture ? FVV_TEXTURE_BITS_MAX : 0;
  fvvcodec_mesh.normal_bits = has_normals ? FVV_NORMAL_BITS_MAX : 0;
  if (fvv_mesh_allocate(&fvvcodec_mesh)) return FVV_OK;
  return fvv_fail(&fvvcodec_diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory to decode a mesh");
}

/* 0: positions, 1: faces, 2: texture, 3: normals. */
FVVJS_EXPORT const void *fvvcodec_array(int which) {
  const void *const arrays[] = {fvvcodec_mesh.positions, fvvcodec_mesh.faces, fvvcodec_mesh.texture,
                                fvvcodec_mesh.normals};
  return which >= 0 && which < 4 ? arrays[which] : NULL;
}
