/* mesh/draco_check.h and mesh/draco_bridge.h for the core: both are in the module of Draco, which JavaScript
 * fetches when a stream needs it. */
#include "base/diagnostic.h"
#include "mesh/draco_bridge.h"
#include "mesh/draco_check.h"

/* As fvv_draco_check; the module keeps data for what follows. */
__attribute__((import_module("fvv"), import_name("draco_check"))) extern int32_t
fvvjs_import_draco_check(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces, int texture,
                         int normals, fvv_diagnostic *diagnostic);

/* As fvv_draco_decode, of the data that were checked last. positions: vertices x 3; faces: faces x 3;
 * texture, normals: vertices x 2 or NULL. */
__attribute__((import_module("fvv"), import_name("draco_decode"))) extern int32_t
fvvjs_import_draco_decode(uint32_t vertices, uint32_t faces, int32_t *positions, uint32_t *indices,
                          uint32_t *texture, uint32_t *normals, fvv_diagnostic *diagnostic);

fvv_status fvv_draco_check(const uint8_t *data, size_t size, fvv_draco_counts declared, int texture,
                           int normals, const fvv_allocator *allocator, fvv_diagnostic *diagnostic) {
  (void)allocator;
  fvv_diagnostic why = {0};
  const fvv_status status = fvvjs_import_draco_check(data, (uint32_t)size, declared.vertices, declared.faces,
                                                     texture, normals, &why);
  return status == FVV_OK
             ? status
             : fvv_fail(diagnostic, status, why.issue, why.chunk_type, why.offset, "%s", why.message);
}

fvv_status fvv_draco_decode(const uint8_t *data, size_t size, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  (void)data, (void)size;
  fvv_diagnostic why = {0};
  const fvv_status status = fvvjs_import_draco_decode(mesh->vertex_count, mesh->face_count, mesh->positions,
                                                      mesh->faces, mesh->texture, mesh->normals, &why);
  return status == FVV_OK
             ? status
             : fvv_fail(diagnostic, status, why.issue, why.chunk_type, why.offset, "%s", why.message);
}

/* Encoders of the library refer to these; nothing here calls them. */
fvv_status fvv_draco_encode(const fvv_mesh *mesh, int level, fvv_draco_coding coding, fvv_bytes *bytes,
                            fvv_diagnostic *diagnostic) {
  (void)mesh, (void)level, (void)coding, (void)bytes, (void)diagnostic;
  return FVV_ERROR_STATE;
}
fvv_status fvv_draco_read_counts(const uint8_t *data, size_t size, fvv_draco_counts *counts,
                                 fvv_diagnostic *diagnostic) {
  (void)data, (void)size, (void)counts, (void)diagnostic;
  return FVV_ERROR_STATE;
}
