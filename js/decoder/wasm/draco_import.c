/* mesh/draco_bridge.h for the core: Draco is a module of its own, which JavaScript fetches when a stream needs it. What
 * goes there has passed draco_check.c; counts and attributes of what comes back are checked in that module. */
#include "mesh/draco_bridge.h"

/* As fvv_draco_decode. positions: vertices x 3; faces: faces x 3; texture, normals: vertices x 2 or NULL. */
__attribute__((import_module("fvv"), import_name("draco"))) extern int32_t
fvvjs_import_draco(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces, int32_t *positions,
                   uint32_t *indices, uint32_t *texture, uint32_t *normals, fvv_diagnostic *diagnostic);

fvv_status fvv_draco_decode(const uint8_t *data, size_t size, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  return fvvjs_import_draco(data, (uint32_t)size, mesh->vertex_count, mesh->face_count, mesh->positions,
                            mesh->faces, mesh->texture, mesh->normals, diagnostic);
}

/* Encoders of the library refer to it; nothing here calls them. */
fvv_status fvv_draco_encode(const fvv_mesh *mesh, int level, fvv_draco_coding coding, fvv_bytes *bytes,
                            fvv_diagnostic *diagnostic) {
  (void)mesh, (void)level, (void)coding, (void)bytes, (void)diagnostic;
  return FVV_ERROR_STATE;
}
