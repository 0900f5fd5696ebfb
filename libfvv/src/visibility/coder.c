/* Bits of elements that face a camera, by an adaptive range coder whose contexts count what is known around
 * (clause 17.3). One walk serves encoder and decoder, so that they cannot differ. */
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/range_coder.h"
#include "visibility/order.h"

enum { CLASSES = 7, FORMER_STATES = 3 };

typedef struct visibility_model {
  fvv_probability seen[FORMER_STATES][CLASSES][CLASSES]; /* former state, seen around, hidden around */
} visibility_model;

/* Contexts begin with what they say: as many seen and hidden as the least counts of their classes, and four
 * each for the state of the frame before. There are too many of them to learn that anew in each frame. */
static void reset(visibility_model *model) {
  static const uint32_t least[CLASSES] = {0, 1, 2, 3, 4, 7, 10};
  for (uint32_t f = 0; f < FORMER_STATES; f++)
    for (uint32_t s = 0; s < CLASSES; s++)
      for (uint32_t h = 0; h < CLASSES; h++) {
        const uint32_t seen = 8 * least[s] + 1 + (f == FVV_ELEMENT_SEEN ? 32 : 0);
        const uint32_t hidden = 8 * least[h] + 1 + (f == FVV_ELEMENT_HIDDEN ? 32 : 0);
        fvv_probability *p = &model->seen[f][s][h];
        p->fast = p->slow = (uint16_t)((seen << 16) / (seen + hidden));
      }
}

static inline uint32_t class_of(uint64_t count) {
  return count < 4 ? (uint32_t)count : count < 7 ? 4 : count < 10 ? 5 : 6;
}

/* The places that an element touches. */
typedef struct touched_places {
  const uint32_t *place;
  uint32_t count;
} touched_places;

static inline touched_places places_of(const fvv_visibility_order *order, const fvv_mesh *mesh,
                                       uint32_t element) {
  if (order->domain == FVV_VISIBILITY_FACES) return (touched_places){mesh->faces + 3 * (size_t)element, 3};
  return (touched_places){order->touched + order->first[element],
                          order->first[element + 1] - order->first[element]};
}

static inline fvv_probability *context_of(visibility_model *model, const fvv_visibility_order *order,
                                          touched_places touched, uint8_t former) {
  uint64_t seen = 0, hidden = 0;
  for (uint32_t i = 0; i < touched.count; i++) {
    seen += order->places[touched.place[i]].seen;
    hidden += order->places[touched.place[i]].hidden;
  }
  return &model->seen[former < FORMER_STATES ? former : 0][class_of(seen)][class_of(hidden)];
}

static inline void note(fvv_visibility_order *order, touched_places touched, int seen) {
  for (uint32_t i = 0; i < touched.count; i++)
    if (seen)
      order->places[touched.place[i]].seen++;
    else
      order->places[touched.place[i]].hidden++;
}

static fvv_status check_mesh(const fvv_visibility_order *order, const fvv_mesh *mesh,
                             fvv_diagnostic *diagnostic) {
  if (mesh->vertex_count == order->vertex_count && mesh->face_count == order->face_count) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0,
                  "a mesh of %lu vertices and %lu faces, the order is that of one of %lu and %lu",
                  (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count,
                  (unsigned long)order->vertex_count, (unsigned long)order->face_count);
}

fvv_status fvv_visibility_decode(fvv_visibility_order *order, const fvv_mesh *mesh,
                                 const fvv_visibility_header *header, const uint8_t *data, size_t size,
                                 const int32_t centre[3], const uint8_t *former, uint8_t *states,
                                 fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_status status = check_mesh(order, mesh, diagnostic);
  if (status != FVV_OK) return status;
  if (header->domain != order->domain || header->element_count != order->element_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_MESH, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_ELEMENT_COUNT, "visibility of %lu elements of domain %u, the mesh has %lu",
                    (unsigned long)header->element_count, header->domain,
                    (unsigned long)order->element_count);
  /* A copy, as states may be former. */
  uint8_t *facing = fvv_allocate(&order->allocator, order->element_count);
  if (!facing) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for visibility");
  fvv_visibility_facing(mesh, order->domain, centre, header->threshold, facing);
  memset(order->places, 0, (size_t)order->place_count * sizeof *order->places);
  visibility_model model;
  reset(&model);
  fvv_range_decoder d;
  fvv_range_decoder_init(&d, data, size);
  for (uint32_t i = 0; i < order->element_count; i++) {
    const uint32_t element = order->elements[i];
    const uint8_t before = former && header->number ? former[element] : FVV_ELEMENT_AVERSE;
    states[element] = FVV_ELEMENT_AVERSE;
    if (!facing[element]) continue;
    int seen = 0;
    if (size) {
      const touched_places touched = places_of(order, mesh, element);
      seen = fvv_range_decode(&d, context_of(&model, order, touched, before));
      note(order, touched, seen);
      if (fvv_range_decoder_failed(&d)) break;
    }
    states[element] = seen ? FVV_ELEMENT_SEEN : FVV_ELEMENT_HIDDEN;
  }
  fvv_release(&order->allocator, facing, order->element_count);
  if (!size || fvv_range_decoder_finished(&d)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_STREAM, FVV_CHUNK_VISIBILITY, 0,
                  "the %zu bytes of a camera do not end with its last element", size);
}

/* Appends the bytes of a view, none when it sees nothing. */
static fvv_status encode_view(fvv_visibility_order *order, const fvv_mesh *mesh,
                              const fvv_visibility_header *header, const fvv_visibility_view *view,
                              uint8_t *facing, fvv_bytes *data) {
  const size_t begin = data->size;
  fvv_visibility_facing(mesh, order->domain, view->centre, header->threshold, facing);
  memset(order->places, 0, (size_t)order->place_count * sizeof *order->places);
  visibility_model model;
  reset(&model);
  fvv_range_encoder e;
  fvv_range_encoder_init(&e, data);
  int some = 0;
  for (uint32_t i = 0; i < order->element_count; i++) {
    const uint32_t element = order->elements[i];
    const uint8_t before = view->former && header->number ? view->former[element] : FVV_ELEMENT_AVERSE;
    const int seen = facing[element] && view->seen[element];
    if (view->states)
      view->states[element] = seen ? FVV_ELEMENT_SEEN : facing[element] ? FVV_ELEMENT_HIDDEN : 0;
    if (!facing[element]) continue;
    const touched_places touched = places_of(order, mesh, element);
    fvv_range_encode(&e, context_of(&model, order, touched, before), seen);
    note(order, touched, seen);
    some |= seen;
  }
  const fvv_status status = fvv_range_encoder_finish(&e);
  if (!some) data->size = begin;
  return status;
}

static fvv_status append_uleb(fvv_bytes *bytes, uint64_t value) {
  uint8_t coded[10];
  return fvv_bytes_append(bytes, coded, fvv_put_uleb(coded, value));
}

static fvv_status encode_views(fvv_visibility_order *order, const fvv_mesh *mesh,
                               const fvv_visibility_header *header, const fvv_visibility_view *views,
                               size_t view_count, fvv_bytes *payload) {
  fvv_bytes data = {NULL, 0, 0, order->allocator};
  uint8_t *facing = fvv_allocate(&order->allocator, order->element_count);
  uint8_t fixed[FVV_VISI_SIZE];
  fixed[FVV_VISI_DOMAIN] = order->domain;
  fixed[FVV_VISI_THRESHOLD] = header->threshold;
  fvv_put_u16(fixed + FVV_VISI_MESH_TRACK, header->mesh_track);
  fvv_put_u32(fixed + FVV_VISI_ELEMENT_COUNT, order->element_count);
  fvv_put_u32(fixed + FVV_VISI_NUMBER, header->number);
  fvv_put_u32(fixed + FVV_VISI_CAMERA_COUNT, (uint32_t)view_count);
  fvv_status status = facing ? fvv_bytes_append(payload, fixed, sizeof fixed) : FVV_ERROR_MEMORY;
  for (size_t i = 0; i < view_count && status == FVV_OK; i++) {
    const size_t begin = data.size;
    status = encode_view(order, mesh, header, &views[i], facing, &data);
    if (status == FVV_OK)
      status = append_uleb(payload, (uint64_t)views[i].camera - (i ? views[i - 1].camera : 0));
    if (status == FVV_OK) status = append_uleb(payload, data.size - begin);
  }
  if (status == FVV_OK && data.size) status = fvv_bytes_append(payload, data.data, data.size);
  fvv_bytes_free(&data);
  fvv_release(&order->allocator, facing, order->element_count);
  return status;
}

fvv_status fvv_visibility_encode(fvv_visibility_order *order, const fvv_mesh *mesh,
                                 const fvv_visibility_header *header, const fvv_visibility_view *views,
                                 size_t view_count, fvv_bytes *payload, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (!payload->allocator.resize) payload->allocator = order->allocator;
  payload->size = 0;
  fvv_status status = check_mesh(order, mesh, diagnostic);
  if (status != FVV_OK) return status;
  if (header->domain != order->domain || !view_count)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0,
                    "domain %u with an order of domain %u, %zu views", header->domain, order->domain,
                    view_count);
  for (size_t i = 0; i < view_count; i++)
    if (views[i].camera >= FVV_NO_CAMERA || (i && views[i].camera <= views[i - 1].camera))
      return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_VISIBILITY_CAMERA, 0, 0,
                      "camera %u: cameras rise, and none is 65535", views[i].camera);
  status = encode_views(order, mesh, header, views, view_count, payload);
  return status == FVV_OK ? status : fvv_fail(diagnostic, status, 0, 0, 0, "no memory for visibility");
}
