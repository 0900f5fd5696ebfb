#include "mesh/storage.h"

#include <string.h>

#include "base/memory.h"

int fvv_mesh_allocate(fvv_mesh *mesh) {
  const fvv_allocator *allocator = &mesh->allocator;
  mesh->positions = fvv_allocate_array(allocator, mesh->vertex_count, 3 * sizeof *mesh->positions);
  mesh->faces = fvv_allocate_array(allocator, mesh->face_count, 3 * sizeof *mesh->faces);
  if (mesh->texture_bits)
    mesh->texture = fvv_allocate_array(allocator, mesh->vertex_count, 2 * sizeof *mesh->texture);
  if (mesh->normal_bits)
    mesh->normals = fvv_allocate_array(allocator, mesh->vertex_count, 2 * sizeof *mesh->normals);
  return mesh->positions && mesh->faces && (mesh->texture || !mesh->texture_bits) &&
         (mesh->normals || !mesh->normal_bits);
}

void fvv_mesh_free(fvv_mesh *mesh) {
  if (mesh->allocator.resize) {
    const size_t vertices = mesh->vertex_count, faces = mesh->face_count;
    fvv_release(&mesh->allocator, mesh->positions, vertices * 3 * sizeof *mesh->positions);
    fvv_release(&mesh->allocator, mesh->faces, faces * 3 * sizeof *mesh->faces);
    fvv_release(&mesh->allocator, mesh->texture, vertices * 2 * sizeof *mesh->texture);
    fvv_release(&mesh->allocator, mesh->normals, vertices * 2 * sizeof *mesh->normals);
  }
  memset(mesh, 0, sizeof *mesh);
}

fvv_status fvv_mesh_copy(const fvv_mesh *mesh, const fvv_allocator *allocator, fvv_mesh *copy) {
  memset(copy, 0, sizeof *copy);
  copy->allocator = fvv_allocator_or_default(allocator);
  copy->vertex_count = mesh->vertex_count;
  copy->face_count = mesh->face_count;
  copy->texture_bits = mesh->texture_bits;
  copy->normal_bits = mesh->normal_bits;
  if (!fvv_mesh_allocate(copy)) {
    fvv_mesh_free(copy);
    return FVV_ERROR_MEMORY;
  }
  const size_t vertices = mesh->vertex_count;
  memcpy(copy->positions, mesh->positions, vertices * 3 * sizeof *mesh->positions);
  memcpy(copy->faces, mesh->faces, (size_t)mesh->face_count * 3 * sizeof *mesh->faces);
  if (copy->texture) memcpy(copy->texture, mesh->texture, vertices * 2 * sizeof *mesh->texture);
  if (copy->normals) memcpy(copy->normals, mesh->normals, vertices * 2 * sizeof *mesh->normals);
  return FVV_OK;
}
