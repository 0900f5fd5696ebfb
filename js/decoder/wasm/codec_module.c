/* The modules of codecs (codec_imports.c), one for each value of FVVJS_CODEC: bytes in, a diagnostic out, and
 * for codecs of meshes the arrays of one mesh. JavaScript copies between their memories and the core's. */
#include <stdlib.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "draco_checked.h"
#include "mesh/draco_bridge.h"
#include "mesh/draco_check.h"
#include "mesh/fast.h"
#include "mesh/mesh.h"
#include "module.h"
#include "video/codecs.h"

/* Of the last call. */
static fvv_diagnostic diagnostic;

FVVJS_EXPORT void *fvvcodec_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT void fvvcodec_free(void *pointer) {
  free(pointer);
}
FVVJS_EXPORT const fvv_diagnostic *fvvcodec_why(void) {
  return &diagnostic;
}

#if FVVJS_CODEC == 4 /* OpenEXR: what can be known of such a picture without decoding it */

/* fvv_status, as fvv_oexr_inspect. */
FVVJS_EXPORT int32_t fvvcodec_check(const uint8_t *data, uint32_t size, uint32_t width, uint32_t height) {
  fvv_diagnostic_clear(&diagnostic);
  return fvv_oexr_inspect(width, height, data, size, &diagnostic);
}

#else /* meshes */

/* The decoded mesh. Valid until the next one, or fvvcodec_release. */
static fvv_mesh mesh;

FVVJS_EXPORT void fvvcodec_release(void) {
  fvv_mesh_free(&mesh);
}

/* Clears the diagnostic and makes room in mesh. */
static fvv_status prepare(uint32_t vertices, uint32_t faces, int has_texture, int has_normals) {
  fvvcodec_release();
  fvv_diagnostic_clear(&diagnostic);
  mesh.allocator = fvv_allocator_or_default(NULL);
  mesh.vertex_count = vertices;
  mesh.face_count = faces;
  /* No codec needs to know how many bits there are, only whether there are any. */
  mesh.texture_bits = has_texture ? FVV_TEXTURE_BITS_MAX : 0;
  mesh.normal_bits = has_normals ? FVV_NORMAL_BITS_MAX : 0;
  if (fvv_mesh_allocate(&mesh)) return FVV_OK;
  return fvv_fail(&diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory to decode a mesh");
}

/* 0: lattice, 1: faces, 2: texture, 3: normals. */
FVVJS_EXPORT const void *fvvcodec_array(int which) {
  const void *const arrays[] = {mesh.lattice, mesh.faces, mesh.texture, mesh.normals};
  return which >= 0 && which < 4 ? arrays[which] : NULL;
}

#if FVVJS_CODEC == 1 /* Draco: libfvv's check of bitstreams and its bridge to the decoder */

fvvcodec_checked fvvcodec_last_check;

static void forget_check(void) {
  fvvcodec_checked *const last = &fvvcodec_last_check;
  const fvv_allocator allocator = fvv_allocator_or_default(NULL);
  fvv_release(&allocator, last->symbols.values, (size_t)last->symbols.count + 1);
  memset(last, 0, sizeof *last);
}

/* fvv_status, as fvv_draco_check. */
FVVJS_EXPORT int32_t fvvcodec_check(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                                    int has_texture, int has_normals) {
  const fvv_draco_counts counts = {vertices, faces};
  const fvv_allocator allocator = fvv_allocator_or_default(NULL);
  fvvcodec_checked *const last = &fvvcodec_last_check;
  fvv_diagnostic_clear(&diagnostic);
  forget_check();
  const fvv_status status =
      fvv_draco_check(data, size, counts, has_texture, has_normals, &allocator, &last->symbols, &diagnostic);
  if (status == FVV_OK) last->data = data;
  if (status == FVV_OK) last->size = size;
  return status;
}

/* Of nothing but the bytes that the last check let through. */
static fvv_status decode(const uint8_t *data, uint32_t size) {
  if (!data || data != fvvcodec_last_check.data || size != fvvcodec_last_check.size)
    return fvv_fail(&diagnostic, FVV_ERROR_STATE, 0, 0, 0, "a Draco bitstream has not been checked");
  const fvv_status status = fvv_draco_decode(data, size, &mesh, &diagnostic);
  forget_check();
  return status;
}

#else /* fast meshes: libfvv's check of their streams, and meshoptimizer */

static fvv_status decode(const uint8_t *data, uint32_t size) {
  const fvv_mesh_header header = {FVV_MESH_FAST, mesh.vertex_count, mesh.face_count,
                                  size,          mesh.texture_bits, mesh.normal_bits};
  return fvv_fast_decode(data, &header, &mesh, &diagnostic);
}

#endif

/* fvv_status; the arrays are where fvvcodec_array says. */
FVVJS_EXPORT int32_t fvvcodec_decode(const uint8_t *data, uint32_t size, uint32_t vertices, uint32_t faces,
                                     int has_texture, int has_normals) {
  const fvv_status status = prepare(vertices, faces, has_texture, has_normals);
  return status == FVV_OK ? decode(data, size) : status;
}

#endif
