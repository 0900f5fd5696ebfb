/* What the core and the module of environments leave to modules of their own, which JavaScript fetches when a
 * stream needs them: the codecs of single meshes, and the look into OpenEXR files, of which few streams are
 * made. */
#include "base/diagnostic.h"
#include "mesh/draco_bridge.h"
#include "mesh/draco_check.h"
#include "mesh/fast.h"
#include "video/codecs.h"

#define IMPORT(name) __attribute__((import_module("fvv"), import_name(name))) extern int32_t

/* As fvv_draco_check; the module keeps data for what follows. */
IMPORT("draco_check")
fvvjs_import_draco_check(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces, int texture,
                         int normals, fvv_diagnostic *diagnostic);

/* As fvv_draco_decode, of the data that were checked last. lattice: vertices x 3; faces: faces x 3;
 * texture, normals: vertices x 2 or NULL. */
IMPORT("draco_decode")
fvvjs_import_draco_decode(uint32_t vertices, uint32_t faces, int32_t *lattice, uint32_t *indices,
                          uint32_t *texture, uint32_t *normals, fvv_diagnostic *diagnostic);

/* As fvv_fast_decode. */
IMPORT("fast_decode")
fvvjs_import_fast_decode(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                         int32_t *lattice, uint32_t *indices, uint32_t *texture, uint32_t *normals,
                         fvv_diagnostic *diagnostic);

/* As fvv_oexr_inspect. */
IMPORT("openexr_check")
fvvjs_import_openexr_check(const uint8_t *data, uint32_t size, uint32_t width, uint32_t height,
                           fvv_diagnostic *diagnostic);

/* The first error of a call wins, wherever it comes from. */
static fvv_status pass_on(fvv_status status, const fvv_diagnostic *why, fvv_diagnostic *diagnostic) {
  if (status == FVV_OK) return FVV_OK;
  return fvv_fail(diagnostic, status, why->issue, why->chunk_type, why->offset, "%s", why->message);
}

fvv_status fvv_draco_check(const uint8_t *data, size_t size, fvv_draco_counts declared, int texture,
                           int normals, const fvv_allocator *allocator, fvv_draco_symbols *symbols,
                           fvv_diagnostic *diagnostic) {
  (void)allocator, (void)symbols;
  fvv_diagnostic why = {0};
  return pass_on(fvvjs_import_draco_check(data, (uint32_t)size, declared.vertices, declared.faces, texture,
                                          normals, &why),
                 &why, diagnostic);
}

fvv_status fvv_draco_decode(const uint8_t *data, size_t size, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  (void)data, (void)size;
  fvv_diagnostic why = {0};
  return pass_on(fvvjs_import_draco_decode(mesh->vertex_count, mesh->face_count, mesh->lattice, mesh->faces,
                                           mesh->texture, mesh->normals, &why),
                 &why, diagnostic);
}

fvv_status fvv_fast_decode(const uint8_t *data, const fvv_mesh_header *header, fvv_mesh *mesh,
                           fvv_diagnostic *diagnostic) {
  fvv_diagnostic why = {0};
  return pass_on(fvvjs_import_fast_decode(data, (uint32_t)header->data_size, header->vertex_count,
                                          header->face_count, mesh->lattice, mesh->faces, mesh->texture,
                                          mesh->normals, &why),
                 &why, diagnostic);
}

fvv_status fvv_oexr_inspect(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic why = {0};
  return pass_on(fvvjs_import_openexr_check(sample, (uint32_t)size, width, height, &why), &why, diagnostic);
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
