/* Breadth first over the surface: what is coded next lies at the rim of what is known, so that as much as can
 * be is known around it. */
#include "visibility/order.h"

#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "mesh/topology.h"

void fvv_visibility_order_close(fvv_visibility_order *order) {
  if (!order) return;
  const fvv_allocator a = order->allocator;
  fvv_release(&a, order->elements, (size_t)order->element_count * sizeof *order->elements);
  fvv_release(&a, order->first, ((size_t)order->vertex_count + 1) * sizeof *order->first);
  fvv_release(&a, order->touched, 3 * (size_t)order->face_count * sizeof *order->touched);
  fvv_release(&a, order->places, (size_t)order->place_count * sizeof *order->places);
  fvv_release(&a, order, sizeof *order);
}

/* Appends an element that was not met yet. */
static uint32_t meet(fvv_visibility_order *order, uint8_t *met, uint32_t element, uint32_t end) {
  if (met[element]) return end;
  met[element] = 1;
  order->elements[end] = element;
  return end + 1;
}

static uint32_t spread_faces(fvv_visibility_order *order, const fvv_topology *topology, uint8_t *met,
                             uint32_t from, uint32_t end) {
  for (uint32_t i = from; i < end; i++)
    for (size_t c = 0; c < 3; c++) {
      const uint32_t twin = topology->twin[3 * (size_t)order->elements[i] + c];
      if (twin != FVV_NO_TWIN) end = meet(order, met, twin / 3, end);
    }
  return end;
}

static uint32_t spread_vertices(fvv_visibility_order *order, const uint32_t *faces, uint8_t *met,
                                uint32_t from, uint32_t end) {
  for (uint32_t i = from; i < end; i++) {
    const uint32_t v = order->elements[i];
    for (uint32_t k = order->first[v]; k < order->first[v + 1]; k++)
      for (size_t c = 0; c < 3; c++) end = meet(order, met, faces[3 * (size_t)order->touched[k] + c], end);
  }
  return end;
}

static void list_faces_of_vertices(fvv_visibility_order *order, const uint32_t *faces) {
  uint32_t *const first = order->first;
  const size_t corners = 3 * (size_t)order->face_count;
  memset(first, 0, ((size_t)order->vertex_count + 1) * sizeof *first);
  for (size_t i = 0; i < corners; i++) first[faces[i]]++;
  uint32_t end = 0;
  for (uint32_t v = 0; v <= order->vertex_count; v++) {
    end += first[v];
    first[v] = end;
  }
  /* From the back, so that each list rises and first ends up where the lists begin. */
  for (size_t i = corners; i-- > 0;) order->touched[--first[faces[i]]] = (uint32_t)(i / 3);
}

static fvv_status walk(fvv_visibility_order *order, const fvv_mesh *mesh) {
  uint8_t *met = fvv_allocate_zeroed(&order->allocator, order->element_count);
  fvv_topology topology = {0};
  fvv_status status = met ? FVV_OK : FVV_ERROR_MEMORY;
  if (status == FVV_OK && order->domain == FVV_VISIBILITY_FACES)
    status = fvv_topology_build(mesh->faces, mesh->face_count, &order->allocator, &topology);
  uint32_t end = 0;
  for (uint32_t element = 0; element < order->element_count && status == FVV_OK; element++) {
    const uint32_t from = end;
    end = meet(order, met, element, end);
    end = order->domain == FVV_VISIBILITY_FACES ? spread_faces(order, &topology, met, from, end)
                                                : spread_vertices(order, mesh->faces, met, from, end);
  }
  fvv_topology_free(&topology);
  fvv_release(&order->allocator, met, order->element_count);
  return status;
}

fvv_status fvv_visibility_order_open(const fvv_mesh *mesh, uint8_t domain, const fvv_allocator *allocator,
                                     fvv_visibility_order **order, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *order = NULL;
  if (domain > FVV_VISIBILITY_SHARES)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_VISIBILITY_DOMAIN, 0, 0,
                    "domain %u, known are 0 to 2", domain);
  if (mesh->face_count >= UINT32_C(1) << 30)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, 0, 0, "%lu faces, at most 2^30 - 1",
                    (unsigned long)mesh->face_count);
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  fvv_visibility_order *o = fvv_allocate_zeroed(&chosen, sizeof *o);
  fvv_status status = FVV_ERROR_MEMORY;
  if (o) {
    const int vertices = domain != FVV_VISIBILITY_FACES;
    o->allocator = chosen;
    o->domain = domain;
    o->vertex_count = mesh->vertex_count;
    o->face_count = mesh->face_count;
    o->element_count = vertices ? mesh->vertex_count : mesh->face_count;
    o->place_count = vertices ? mesh->face_count : mesh->vertex_count;
    o->elements = fvv_allocate_array(&chosen, o->element_count, sizeof *o->elements);
    o->places = fvv_allocate_array(&chosen, o->place_count, sizeof *o->places);
    if (vertices) {
      o->first = fvv_allocate_array(&chosen, (size_t)o->vertex_count + 1, sizeof *o->first);
      o->touched = fvv_allocate_array(&chosen, 3 * (size_t)o->face_count, sizeof *o->touched);
    }
    if (o->elements && o->places && (!vertices || (o->first && o->touched))) {
      if (vertices) list_faces_of_vertices(o, mesh->faces);
      status = walk(o, mesh);
    }
  }
  if (status == FVV_OK) {
    *order = o;
    return FVV_OK;
  }
  fvv_visibility_order_close(o);
  return fvv_fail(diagnostic, status, 0, 0, 0, "no memory for visibility");
}
