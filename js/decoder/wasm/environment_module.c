/* The module of environments (clause 18): the payload of a BACK in, its parts, pictures and lights out.
 * Meshes come one at a time, so that an environment of many parts costs no more than its largest. */
#include <stdlib.h>
#include <string.h>

#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "fvv/environment.h"
#include "module.h"
#include "wasm_structs.h"

static fvv_limits limits;
static fvv_diagnostic diagnostic;
static fvv_environment environment;
static fvv_mesh mesh;
static fvv_bytes positions, texture;
static wasm_environment published;
static wasm_part part_now;

FVVJS_EXPORT void *fvvback_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT const fvv_diagnostic *fvvback_diagnostic(void) {
  return &diagnostic;
}
FVVJS_EXPORT const wasm_environment *fvvback_data(void) {
  return &published;
}

static uint32_t codecs(void) {
  uint32_t all = 0;
  for (size_t i = 0; i < environment.part_count; i++)
    all |= fvvjs_mesh_codec(environment.parts[i].mesh[FVV_MESH_PROFILE]);
  return all;
}

/* fvv_status. payload has to stay in place. Numbers as in fvv_limits; 0 keeps the default. Once an instance.
 */
FVVJS_EXPORT int32_t fvvback_load(const uint8_t *payload, size_t size, uint32_t max_vertices,
                                  uint32_t max_faces, uint32_t max_dimension) {
  const fvv_allocator allocator = fvv_allocator_or_default(NULL);
  positions.allocator = texture.allocator = allocator;
  fvv_limits_default(&limits);
  if (max_vertices) limits.max_vertices = max_vertices;
  if (max_faces) limits.max_faces = max_faces;
  if (max_dimension) limits.max_dimension = max_dimension;
  const fvv_status status =
      fvv_environment_decode(payload, size, &limits, &allocator, &environment, &diagnostic);
  if (status != FVV_OK) return status;
  const wasm_environment made = {
      codecs(),
      (uint32_t)environment.part_count,
      {environment.pictures, (uint32_t)environment.picture_count},
      {environment.lights, (uint32_t)environment.light_count},
      {environment.lattice_origin[0], environment.lattice_origin[1], environment.lattice_origin[2]},
      environment.lattice_step};
  published = made;
  return FVV_OK;
}

static float *room(fvv_bytes *bytes, uint32_t count, uint32_t components) {
  uint64_t size;
  if (!fvv_multiply_u64(count, components * sizeof(float), &size) || size > SIZE_MAX) return NULL;
  return fvv_bytes_reserve(bytes, (size_t)size) == FVV_OK ? (float *)bytes->data : NULL;
}

/* Decodes a part. NULL: the diagnostic says why. Valid until the next call. */
FVVJS_EXPORT const wasm_part *fvvback_part(uint32_t i) {
  fvv_mesh_free(&mesh);
  memset(&diagnostic, 0, sizeof diagnostic);
  if (fvv_environment_mesh(&environment, i, &limits, NULL, &mesh, &diagnostic) != FVV_OK) return NULL;
  const fvv_environment_part *part = &environment.parts[i];
  float *points = room(&positions, mesh.vertex_count, 3);
  float *places = mesh.texture ? room(&texture, mesh.vertex_count, 2) : NULL;
  if (!points || (mesh.texture && !places)) {
    fvv_fail(&diagnostic, FVV_ERROR_MEMORY, 0, FVV_CHUNK_ENVIRONMENT, 0, "no memory for a part");
    return NULL;
  }
  fvv_lattice_to_floats(environment.lattice_origin, environment.lattice_step, mesh.lattice, mesh.vertex_count,
                        points);
  if (places) {
    fvv_texture_to_floats(mesh.texture_bits, mesh.texture, mesh.vertex_count, places);
    for (size_t k = 0; k < 2 * (size_t)mesh.vertex_count; k++)
      places[k] = (float)(part->texture_origin[k % 2] + part->texture_size[k % 2] * (double)places[k]);
  }
  const wasm_part made = {
      mesh.vertex_count, mesh.face_count, mesh.lattice,
      mesh.faces,        points,          places,
      part->picture,     part->flags,     {part->colour[0], part->colour[1], part->colour[2]}};
  part_now = made;
  return &part_now;
}
