/* The module of Draco: libfvv's check of bitstreams, its bridge to the decoder, and room for one mesh. */
#include <stdlib.h>
#include <string.h>

#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/memory.h"
#include "mesh/draco_bridge.h"
#include "mesh/draco_check.h"

#define FVVJS_EXPORT __attribute__((visibility("default"), used))

static fvv_mesh mesh;
static fvv_diagnostic diagnostic;

FVVJS_EXPORT void *fvvdraco_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT void fvvdraco_free(void *pointer) {
  free(pointer);
}

static void *array(uint32_t count, uint32_t components) {
  uint64_t size;
  return fvv_multiply_u64(count, 4 * components, &size) && size <= SIZE_MAX ? malloc((size_t)size) : NULL;
}

FVVJS_EXPORT void fvvdraco_release(void) {
  free(mesh.positions);
  free(mesh.faces);
  free(mesh.texture);
  free(mesh.normals);
  memset(&mesh, 0, sizeof mesh);
}

/* fvv_status, as fvv_draco_check. */
FVVJS_EXPORT int32_t fvvdraco_check(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                                    int has_texture, int has_normals) {
  const fvv_draco_counts counts = {vertices, faces};
  const fvv_allocator allocator = fvv_allocator_or_default(NULL);
  memset(&diagnostic, 0, sizeof diagnostic);
  return fvv_draco_check(data, size, counts, has_texture, has_normals, &allocator, &diagnostic);
}

/* fvv_status. What came out lies where fvvdraco_array says, until fvvdraco_release. */
FVVJS_EXPORT int32_t fvvdraco_decode(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                                     int has_texture, int has_normals) {
  fvvdraco_release();
  memset(&diagnostic, 0, sizeof diagnostic);
  mesh.vertex_count = vertices;
  mesh.face_count = faces;
  mesh.positions = array(vertices, 3);
  mesh.faces = array(faces, 3);
  mesh.texture = has_texture ? array(vertices, 2) : NULL;
  mesh.normals = has_normals ? array(vertices, 2) : NULL;
  if (!mesh.positions || !mesh.faces || (has_texture && !mesh.texture) || (has_normals && !mesh.normals))
    return fvv_fail(&diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for Draco");
  return fvv_draco_decode(data, size, &mesh, &diagnostic);
}

/* 0: positions, 1: faces, 2: texture, 3: normals. */
FVVJS_EXPORT const void *fvvdraco_array(int which) {
  const void *const arrays[] = {mesh.positions, mesh.faces, mesh.texture, mesh.normals};
  return which >= 0 && which < 4 ? arrays[which] : NULL;
}
FVVJS_EXPORT const fvv_diagnostic *fvvdraco_diagnostic(void) {
  return &diagnostic;
}
