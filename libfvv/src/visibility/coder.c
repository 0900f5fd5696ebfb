/* VISI payloads: header and table, the order in which vertices are coded, and the coder itself
 * (clauses 17.1 and 17.3). */
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/range_coder.h"
#include "fvv/visibility.h"

/* The number of corners of a face that have been coded as hidden and as seen. */
typedef struct coded_corners {
  uint32_t count[2];
} coded_corners;

struct fvv_visibility_order {
  fvv_allocator allocator;
  uint32_t vertex_count, face_count;
  uint32_t *vertices; /* in order of coding */
  /* Faces around[first[v]] to around[first[v + 1] - 1] use vertex v, rising. */
  uint32_t *first, *around;
  coded_corners *corners; /* scratch: of each face */
};

static fvv_status read_header(const uint8_t *payload, size_t size, const fvv_limits *limits,
                              fvv_visibility_header *header, fvv_diagnostic *diagnostic) {
  if (size < FVV_VISI_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_PAYLOAD, FVV_CHUNK_VISIBILITY, size,
                    "payload has %zu bytes, expected at least %d", size, FVV_VISI_SIZE);
  header->threshold = payload[FVV_VISI_THRESHOLD];
  header->mesh_track = fvv_get_u16(payload + FVV_VISI_MESH_TRACK);
  header->vertex_count = fvv_get_u32(payload + FVV_VISI_VERTEX_COUNT);
  header->number = fvv_get_u32(payload + FVV_VISI_NUMBER);
  header->camera_count = fvv_get_u32(payload + FVV_VISI_CAMERA_COUNT);
  if (payload[FVV_VISI_RESERVED])
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_PAYLOAD, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_RESERVED, "reserved byte is %u, expected 0", payload[FVV_VISI_RESERVED]);
  /* Two bytes of the table for each camera. */
  if (!header->camera_count || header->camera_count > (size - FVV_VISI_SIZE) / 2)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_SIZE, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_CAMERA_COUNT,
                    "%lu cameras, expected at least one and a table of at most %zu bytes",
                    (unsigned long)header->camera_count, size - FVV_VISI_SIZE);
  if (header->camera_count > limits->max_cameras)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_VISIBILITY, FVV_VISI_CAMERA_COUNT,
                    "%lu cameras, limit %lu", (unsigned long)header->camera_count,
                    (unsigned long)limits->max_cameras);
  if (header->vertex_count > limits->max_vertices)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_VISIBILITY, FVV_VISI_VERTEX_COUNT,
                    "%lu vertices, limit %lu", (unsigned long)header->vertex_count,
                    (unsigned long)limits->max_vertices);
  return FVV_OK;
}

/* Fills streams, which has room for all, or skips the table when streams is NULL. */
static fvv_status read_table(const uint8_t *payload, size_t size, const fvv_visibility_header *header,
                             fvv_visibility_stream *streams, fvv_diagnostic *diagnostic) {
  fvv_cursor cursor = {payload, size, FVV_VISI_SIZE, 0};
  uint64_t camera = 0, all = 0;
  for (uint32_t i = 0; i < header->camera_count && !cursor.failed; i++) {
    const size_t place = cursor.position;
    const uint64_t more = fvv_cursor_uleb(&cursor), bytes = fvv_cursor_uleb(&cursor);
    if (cursor.failed) break;
    camera += more < FVV_NO_CAMERA ? more : FVV_NO_CAMERA;
    if (camera >= FVV_NO_CAMERA || (i && !more))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_CAMERA, FVV_CHUNK_VISIBILITY, place,
                      "camera %lu of the table is not above the one before, or is above 65534",
                      (unsigned long)i);
    const size_t taken = bytes <= size ? (size_t)bytes : size + 1;
    if (streams) streams[i] = (fvv_visibility_stream){(uint16_t)camera, (size_t)all, taken};
    all += taken;
  }
  if (cursor.failed || all > size - cursor.position)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_SIZE, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_SIZE, "sizes of the streams add up to more than the payload has");
  for (uint32_t i = 0; i < header->camera_count && streams; i++) streams[i].offset += cursor.position;
  return FVV_OK;
}

fvv_status fvv_visibility_peek(const uint8_t *payload, size_t size, const fvv_limits *limits,
                               fvv_visibility_header *header, fvv_visibility_stream *streams, size_t capacity,
                               fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *header = (fvv_visibility_header){0};
  const fvv_limits chosen = fvv_limits_or_default(limits);
  fvv_status status = read_header(payload, size, &chosen, header, diagnostic);
  if (status == FVV_OK && streams && capacity < header->camera_count)
    return fvv_fail(diagnostic, FVV_ERROR_BUFFER_TOO_SMALL, 0, FVV_CHUNK_VISIBILITY, FVV_VISI_CAMERA_COUNT,
                    "%lu cameras, the array has room for %zu", (unsigned long)header->camera_count, capacity);
  if (status == FVV_OK) status = read_table(payload, size, header, streams, diagnostic);
  if (status != FVV_OK && status != FVV_ERROR_BUFFER_TOO_SMALL) *header = (fvv_visibility_header){0};
  return status;
}

/* Breadth first over the surface: the next vertex lies at the rim of those already coded, so that as many of
 * its neighbours as possible are known. */

void fvv_visibility_order_close(fvv_visibility_order *order) {
  if (!order) return;
  const fvv_allocator a = order->allocator;
  fvv_release(&a, order->vertices, (size_t)order->vertex_count * sizeof *order->vertices);
  fvv_release(&a, order->first, ((size_t)order->vertex_count + 1) * sizeof *order->first);
  fvv_release(&a, order->around, 3 * (size_t)order->face_count * sizeof *order->around);
  fvv_release(&a, order->corners, (size_t)order->face_count * sizeof *order->corners);
  fvv_release(&a, order, sizeof *order);
}

static void list_faces_around(fvv_visibility_order *order, const uint32_t *faces) {
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
  for (size_t i = corners; i-- > 0;) order->around[--first[faces[i]]] = (uint32_t)(i / 3);
}

/* Appends a vertex that was not met yet. */
static uint32_t meet(fvv_visibility_order *order, uint8_t *met, uint32_t vertex, uint32_t end) {
  if (met[vertex]) return end;
  met[vertex] = 1;
  order->vertices[end] = vertex;
  return end + 1;
}

static fvv_status walk(fvv_visibility_order *order, const uint32_t *faces) {
  uint8_t *met = fvv_allocate_zeroed(&order->allocator, order->vertex_count);
  if (!met) return FVV_ERROR_MEMORY;
  uint32_t end = 0;
  for (uint32_t seed = 0; seed < order->vertex_count; seed++) {
    uint32_t i = end;
    for (end = meet(order, met, seed, end); i < end; i++) {
      const uint32_t v = order->vertices[i];
      for (uint32_t k = order->first[v]; k < order->first[v + 1]; k++)
        for (size_t c = 0; c < 3; c++) end = meet(order, met, faces[3 * (size_t)order->around[k] + c], end);
    }
  }
  fvv_release(&order->allocator, met, order->vertex_count);
  return FVV_OK;
}

fvv_status fvv_visibility_order_open(const fvv_mesh *mesh, const fvv_allocator *allocator,
                                     fvv_visibility_order **order, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *order = NULL;
  if (mesh->face_count >= UINT32_C(1) << 30)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, 0, 0,
                    "%lu faces, expected at most 2^30 - 1", (unsigned long)mesh->face_count);
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  fvv_visibility_order *o = fvv_allocate_zeroed(&chosen, sizeof *o);
  fvv_status status = FVV_ERROR_MEMORY;
  if (o) {
    o->allocator = chosen;
    o->vertex_count = mesh->vertex_count;
    o->face_count = mesh->face_count;
    o->vertices = fvv_allocate_array(&chosen, o->vertex_count, sizeof *o->vertices);
    o->first = fvv_allocate_array(&chosen, (size_t)o->vertex_count + 1, sizeof *o->first);
    o->around = fvv_allocate_array(&chosen, 3 * (size_t)o->face_count, sizeof *o->around);
    o->corners = fvv_allocate_array(&chosen, o->face_count, sizeof *o->corners);
    if (o->vertices && o->first && o->around && o->corners) {
      list_faces_around(o, mesh->faces);
      status = walk(o, mesh->faces);
    }
  }
  if (status == FVV_OK) {
    *order = o;
    return FVV_OK;
  }
  fvv_visibility_order_close(o);
  return fvv_fail(diagnostic, status, 0, 0, 0, "out of memory for visibility");
}

/* Weights of vertices that face a camera, by an adaptive range coder whose contexts count the neighbours that
 * are known (clause 17.3). They come in two passes: first on which side of a half each vertex lies, then how
 * far from it, where a vertex next to it lies on the other side. */

enum { CLASSES = 7, SIDES = 3, LEVELS = 3, LIKELY = 3 << 14 };

typedef struct visibility_model {
  fvv_probability seen[2][SIDES][CLASSES][CLASSES];       /* at a rim, former side, seen and hidden around */
  fvv_probability level[LEVELS + 1][CLASSES][LEVELS - 1]; /* former level, others around, level - 1 */
} visibility_model;

/* FVV_VERTEX_BACKFACING, HIDDEN or SEEN of a state, or of the level nearer to a half; backfacing for states
 * that do not exist. */
static inline uint32_t side_of(uint8_t state) {
  return !state || state > 2 * LEVELS ? FVV_VERTEX_BACKFACING : 2 - (state & 1u);
}
/* 1 for all or nothing, more for nearer to a half; 0 for backfacing vertices. */
static inline uint32_t level_of(uint8_t state) {
  return side_of(state) ? (state + 1u) / 2 : 0;
}

/* Each context begins with an estimate: as many seen and hidden as the least counts of its classes, and four
 * for the state of the frame before. There are too many of them to adapt in each frame. */
static void reset(visibility_model *model) {
  static const uint32_t least[CLASSES] = {0, 1, 2, 3, 4, 7, 10};
  for (uint32_t f = 0; f < SIDES; f++)
    for (uint32_t s = 0; s < CLASSES; s++)
      for (uint32_t h = 0; h < CLASSES; h++) {
        const uint32_t seen = 8 * least[s] + 1 + (f == FVV_VERTEX_SEEN ? 32 : 0);
        const uint32_t hidden = 8 * least[h] + 1 + (f == FVV_VERTEX_HIDDEN ? 32 : 0);
        fvv_probability *p = &model->seen[0][f][s][h];
        p->fast = p->slow = (uint16_t)((seen << 16) / (seen + hidden));
      }
  memcpy(model->seen[1], model->seen[0], sizeof model->seen[0]);
  for (uint32_t f = 0; f <= LEVELS; f++)
    for (uint32_t c = 0; c < CLASSES; c++)
      for (uint32_t k = 0; k < LEVELS - 1; k++) model->level[f][c][k] = (fvv_probability){LIKELY, LIKELY};
}

static inline uint32_t class_of(uint64_t count) {
  return count < 4 ? (uint32_t)count : count < 7 ? 4 : count < 10 ? 5 : 6;
}

/* The faces that use a vertex. */
typedef struct faces_around {
  const uint32_t *face;
  uint32_t count;
} faces_around;

static inline faces_around around_of(const fvv_visibility_order *order, uint32_t vertex) {
  return (faces_around){order->around + order->first[vertex],
                        order->first[vertex + 1] - order->first[vertex]};
}

/* The class of the number of vertices around that are known to be on a side, each counted once for every
 * common face. */
static uint32_t class_around(const fvv_visibility_order *order, faces_around around, uint32_t side) {
  uint64_t count = 0;
  for (uint32_t i = 0; i < around.count; i++)
    count += order->corners[around.face[i]].count[side - FVV_VERTEX_HIDDEN];
  return class_of(count);
}

/* Whether a neighbour does not face the camera. */
static int at_rim(const fvv_mesh *mesh, faces_around around, const uint8_t *known) {
  for (uint32_t i = 0; i < around.count; i++)
    for (size_t c = 0; c < 3; c++)
      if (!known[mesh->faces[3 * (size_t)around.face[i] + c]]) return 1;
  return 0;
}

static fvv_probability *side_context(visibility_model *model, const fvv_visibility_order *order,
                                     const fvv_mesh *mesh, faces_around around, const uint8_t *known,
                                     uint8_t former) {
  return &model->seen[at_rim(mesh, around, known)][side_of(former)][class_around(
      order, around, FVV_VERTEX_SEEN)][class_around(order, around, FVV_VERTEX_HIDDEN)];
}

/* Contexts of the level of a vertex, or NULL where it is the first: nothing lies between it and a vertex of
 * the other side. known: as note leaves it. */
static fvv_probability *level_contexts(visibility_model *model, const fvv_visibility_order *order,
                                       faces_around around, uint8_t known) {
  const uint32_t others = class_around(order, around, FVV_VERTEX_HIDDEN + FVV_VERTEX_SEEN - (known & 3u));
  return others ? model->level[known >> 2][others] : NULL;
}

/* Stores the side of a vertex and, until its level is known, the level that it had in the frame before if
 * it was on that side. */
static void note(fvv_visibility_order *order, faces_around around, uint32_t side, uint8_t former,
                 uint8_t *known) {
  *known = (uint8_t)(side | (side_of(former) == side ? level_of(former) << 2 : 0));
  for (uint32_t i = 0; i < around.count; i++)
    order->corners[around.face[i]].count[side - FVV_VERTEX_HIDDEN]++;
}

static int is_of(const fvv_visibility_order *order, const fvv_mesh *mesh) {
  return mesh->vertex_count == order->vertex_count && mesh->face_count == order->face_count;
}

fvv_status fvv_visibility_decode(fvv_visibility_order *order, const fvv_mesh *mesh,
                                 const fvv_visibility_header *header, const uint8_t *data, size_t size,
                                 const int32_t centre[3], const uint8_t *former, uint8_t *states,
                                 fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (!is_of(order, mesh) || header->vertex_count != order->vertex_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_MESH, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_VERTEX_COUNT, "visibility has %lu vertices, the mesh at its time has %lu",
                    (unsigned long)header->vertex_count, (unsigned long)order->vertex_count);
  /* Of each vertex whether it faces, then what note keeps: states may be former. */
  uint8_t *known = fvv_allocate(&order->allocator, order->vertex_count);
  if (!known) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory for visibility");
  fvv_visibility_facing(mesh, centre, header->threshold, known);
  memset(order->corners, 0, (size_t)order->face_count * sizeof *order->corners);
  visibility_model model;
  reset(&model);
  fvv_range_decoder d;
  fvv_range_decoder_init(&d, data, size);
  for (uint32_t i = 0; i < order->vertex_count && !fvv_range_decoder_failed(&d); i++) {
    const uint32_t vertex = order->vertices[i];
    const uint8_t before = former && header->number ? former[vertex] : FVV_VERTEX_BACKFACING;
    if (!known[vertex]) continue;
    const faces_around around = around_of(order, vertex);
    uint32_t side = FVV_VERTEX_HIDDEN;
    if (size)
      side += (uint32_t)fvv_range_decode(&d, side_context(&model, order, mesh, around, known, before));
    note(order, around, side, before, &known[vertex]);
  }
  for (uint32_t i = 0; i < order->vertex_count; i++) {
    const uint32_t vertex = order->vertices[i];
    states[vertex] = known[vertex] & 3;
    if (!known[vertex]) continue;
    fvv_probability *level = level_contexts(&model, order, around_of(order, vertex), known[vertex]);
    for (uint32_t k = 0; level && k < LEVELS - 1 && !fvv_range_decode(&d, &level[k]); k++)
      states[vertex] += 2;
  }
  fvv_release(&order->allocator, known, order->vertex_count);
  if (!size || fvv_range_decoder_finished(&d)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_STREAM, FVV_CHUNK_VISIBILITY, 0,
                  "stream of a camera has %zu bytes, its last vertex ends elsewhere", size);
}

/* Appends the bytes of a view, none when it sees nothing. known: room for what note keeps. */
static fvv_status encode_view(fvv_visibility_order *order, const fvv_mesh *mesh,
                              const fvv_visibility_header *header, const fvv_visibility_view *view,
                              uint8_t *known, fvv_bytes *data) {
  const size_t begin = data->size;
  fvv_visibility_facing(mesh, view->centre, header->threshold, known);
  memset(order->corners, 0, (size_t)order->face_count * sizeof *order->corners);
  visibility_model model;
  reset(&model);
  fvv_range_encoder e;
  fvv_range_encoder_init(&e, data);
  int some = 0;
  for (uint32_t i = 0; i < order->vertex_count; i++) {
    const uint32_t vertex = order->vertices[i];
    const uint8_t before = view->former && header->number ? view->former[vertex] : FVV_VERTEX_BACKFACING;
    if (!known[vertex]) continue;
    const faces_around around = around_of(order, vertex);
    const int seen = side_of(view->seen[vertex]) == FVV_VERTEX_SEEN;
    fvv_range_encode(&e, side_context(&model, order, mesh, around, known, before), seen);
    note(order, around, seen ? FVV_VERTEX_SEEN : FVV_VERTEX_HIDDEN, before, &known[vertex]);
    some |= seen;
  }
  for (uint32_t i = 0; i < order->vertex_count; i++) {
    const uint32_t vertex = order->vertices[i];
    uint8_t state = known[vertex] & 3;
    fvv_probability *level =
        state ? level_contexts(&model, order, around_of(order, vertex), known[vertex]) : NULL;
    const uint32_t wanted = level ? level_of(view->seen[vertex]) : 0;
    for (uint32_t k = 0; level && k < LEVELS - 1; k++) {
      const int here = wanted <= k + 1;
      fvv_range_encode(&e, &level[k], here);
      if (here) break;
      state += 2;
    }
    if (view->states) view->states[vertex] = state;
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
  uint8_t *known = fvv_allocate(&order->allocator, order->vertex_count);
  uint8_t fixed[FVV_VISI_SIZE];
  fixed[FVV_VISI_RESERVED] = 0;
  fixed[FVV_VISI_THRESHOLD] = header->threshold;
  fvv_put_u16(fixed + FVV_VISI_MESH_TRACK, header->mesh_track);
  fvv_put_u32(fixed + FVV_VISI_VERTEX_COUNT, order->vertex_count);
  fvv_put_u32(fixed + FVV_VISI_NUMBER, header->number);
  fvv_put_u32(fixed + FVV_VISI_CAMERA_COUNT, (uint32_t)view_count);
  fvv_status status = known ? fvv_bytes_append(payload, fixed, sizeof fixed) : FVV_ERROR_MEMORY;
  for (size_t i = 0; i < view_count && status == FVV_OK; i++) {
    const size_t begin = data.size;
    status = encode_view(order, mesh, header, &views[i], known, &data);
    if (status == FVV_OK)
      status = append_uleb(payload, (uint64_t)views[i].camera - (i ? views[i - 1].camera : 0));
    if (status == FVV_OK) status = append_uleb(payload, data.size - begin);
  }
  if (status == FVV_OK && data.size) status = fvv_bytes_append(payload, data.data, data.size);
  fvv_bytes_free(&data);
  fvv_release(&order->allocator, known, order->vertex_count);
  return status;
}

fvv_status fvv_visibility_encode(fvv_visibility_order *order, const fvv_mesh *mesh,
                                 const fvv_visibility_header *header, const fvv_visibility_view *views,
                                 size_t view_count, fvv_bytes *payload, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (!payload->allocator.resize) payload->allocator = order->allocator;
  payload->size = 0;
  if (!is_of(order, mesh))
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0,
                    "mesh has %lu vertices and %lu faces, expected %lu and %lu as the order was made for",
                    (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count,
                    (unsigned long)order->vertex_count, (unsigned long)order->face_count);
  if (!view_count)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "there are no views, expected at least one");
  for (size_t i = 0; i < view_count; i++)
    if (views[i].camera >= FVV_NO_CAMERA || (i && views[i].camera <= views[i - 1].camera))
      return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_VISIBILITY_CAMERA, 0, 0,
                      "camera %u is not above the one before, or is 65535", views[i].camera);
  const fvv_limits limits = fvv_limits_or_default(NULL);
  fvv_status status =
      fvv_readable_check(view_count, limits.max_cameras, "cameras", FVV_CHUNK_VISIBILITY, diagnostic);
  if (status == FVV_OK)
    status = fvv_readable_check(order->vertex_count, limits.max_vertices, "vertices", FVV_CHUNK_VISIBILITY,
                                diagnostic);
  if (status != FVV_OK) return status;
  status = encode_views(order, mesh, header, views, view_count, payload);
  return status == FVV_OK ? status : fvv_fail(diagnostic, status, 0, 0, 0, "out of memory for visibility");
}
