/* What encoder and decoder of delta frames share: the state of a sequence, a key mesh and the delta frames
 * after it, and the header of their payloads. */
#include "mesh/delta.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "mesh/mesh.h"
#include "mesh/normals.h"
#include "mesh/patched.h"

static fvv_status out_of_memory(const fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for a mesh sequence of %lu vertices",
                  (unsigned long)mesh->vertex_count);
}

/* What follows from the mesh of s, which is there. */
static fvv_status allocate(fvv_mesh_sequence *s) {
  const fvv_status status = fvv_delta_hierarchy_build(&s->mesh, &s->allocator, &s->hierarchy);
  if (status != FVV_OK) return status;
  const size_t vertices = s->mesh.vertex_count;
  s->place = fvv_allocate_array(&s->allocator, vertices, 3 * sizeof *s->place);
  s->motion = fvv_allocate_array(&s->allocator, vertices, 3 * sizeof *s->motion);
  s->now = fvv_allocate_array(&s->allocator, vertices, sizeof *s->now);
  s->before = fvv_allocate_array(&s->allocator, vertices, sizeof *s->before);
  s->last = fvv_allocate_zeroed(&s->allocator, vertices * 3);
  s->model_count = s->hierarchy.level_count + 1;
  s->models = fvv_allocate_array(&s->allocator, s->model_count, sizeof *s->models);
  if (!s->place || !s->motion || !s->now || !s->before || !s->last || !s->models) return FVV_ERROR_MEMORY;
  if (!s->mesh.normals) return FVV_OK;
  s->sent_normals = fvv_allocate_array(&s->allocator, vertices, 2 * sizeof *s->sent_normals);
  s->base_normals = fvv_allocate_array(&s->allocator, vertices, 3 * sizeof *s->base_normals);
  s->face_normals = fvv_allocate_array(&s->allocator, vertices, 3 * sizeof *s->face_normals);
  return s->sent_normals && s->base_normals && s->face_normals ? FVV_OK : FVV_ERROR_MEMORY;
}

/* All that s holds. */
static void release(fvv_mesh_sequence *s) {
  const fvv_allocator allocator = s->allocator;
  const size_t vertices = s->hierarchy.vertex_count;
  fvv_release(&allocator, s->place, vertices * 3 * sizeof *s->place);
  fvv_release(&allocator, s->motion, vertices * 3 * sizeof *s->motion);
  fvv_release(&allocator, s->now, vertices * sizeof *s->now);
  fvv_release(&allocator, s->before, vertices * sizeof *s->before);
  fvv_release(&allocator, s->last, vertices * 3);
  fvv_release(&allocator, s->sent_normals, vertices * 2 * sizeof *s->sent_normals);
  fvv_release(&allocator, s->base_normals, vertices * 3 * sizeof *s->base_normals);
  fvv_release(&allocator, s->face_normals, vertices * 3 * sizeof *s->face_normals);
  fvv_release(&allocator, s->models, s->model_count * sizeof *s->models);
  fvv_patched_clear(s);
  fvv_delta_hierarchy_free(&s->hierarchy);
  fvv_mesh_free(&s->mesh);
}

static void start(fvv_mesh_sequence *s) {
  for (uint32_t i = 0; i < s->mesh.vertex_count; i++) {
    const int32_t *from = s->mesh.lattice + 3 * (size_t)s->hierarchy.order[i];
    for (size_t a = 0; a < 3; a++) s->place[3 * (size_t)i + a] = from[a] * (1 << FVV_DELTA_FRACTION_BITS);
    s->before[i] = FVV_DELTA_NO_RESIDUALS;
  }
  /* The first stencil has weights of 0 on the first vertex. */
  memset(s->motion, 0, 3 * sizeof *s->motion);
  const size_t probabilities = sizeof *s->models / sizeof(fvv_probability);
  fvv_probability *p = (fvv_probability *)s->models;
  for (size_t i = 0; i < s->model_count * probabilities; i++) fvv_probability_reset(&p[i]);
  if (!s->sent_normals) return;
  memcpy(s->sent_normals, s->mesh.normals, (size_t)s->mesh.vertex_count * 2 * sizeof *s->sent_normals);
  fvv_normals_of_faces(&s->mesh, NULL, s->base_normals);
}

fvv_status fvv_mesh_sequence_open(const fvv_mesh *key, const fvv_allocator *allocator,
                                  fvv_mesh_sequence **sequence, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *sequence = NULL;
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  if (key->vertex_count < 3 || key->face_count < 1 || key->vertex_count > FVV_DELTA_VERTICES_MAX)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_COUNTS, 0, 0,
                    "a key mesh of %lu vertices and %lu faces", (unsigned long)key->vertex_count,
                    (unsigned long)key->face_count);
  fvv_status status = fvv_mesh_check(key, FVV_MESH_FROM_CALLER, &chosen, diagnostic);
  if (status != FVV_OK) return status;
  fvv_mesh_sequence *s = fvv_allocate_zeroed(&chosen, sizeof *s);
  if (!s) return out_of_memory(key, diagnostic);
  s->allocator = chosen;
  status = fvv_mesh_copy(key, &s->allocator, &s->mesh);
  if (status == FVV_OK) status = allocate(s);
  if (status != FVV_OK) {
    fvv_mesh_sequence_close(s);
    return out_of_memory(key, diagnostic);
  }
  start(s);
  *sequence = s;
  return FVV_OK;
}

void fvv_mesh_sequence_close(fvv_mesh_sequence *sequence) {
  if (!sequence) return;
  const fvv_allocator allocator = sequence->allocator;
  release(sequence);
  fvv_release(&allocator, sequence, sizeof *sequence);
}

/* What is known of vertices that stay goes with them, and contexts go on (clause 8.14). place: of each vertex
 * in the coding order of s. */
static void carry(fvv_mesh_sequence *s, const uint32_t *place, fvv_mesh_sequence *next) {
  const fvv_delta_hierarchy *h = &next->hierarchy;
  for (uint32_t i = 0; i < h->vertex_count; i++) {
    const uint32_t v = h->order[i];
    const size_t to = 3 * (size_t)i;
    if (v < s->kept_count) {
      const size_t from = place[s->kept[v]];
      memcpy(next->place + to, s->place + 3 * from, 3 * sizeof *s->place);
      memcpy(next->last + to, s->last + 3 * from, 3 * sizeof *s->last);
      next->before[i] = s->before[from];
    } else if (i >= h->points) {
      /* A vertex of the patch on the point of another goes with it: their border stays closed. */
      memcpy(next->place + to, next->place + 3 * (size_t)h->stencils[i].node[0], 3 * sizeof *s->place);
    }
  }
  fvv_mesh_sequence *const most = s->model_count > next->model_count ? s : next;
  fvv_mesh_sequence *const least = most == s ? next : s;
  memcpy(next->models, s->models, least->model_count * sizeof *s->models);
  if (most == next) return;
  fvv_delta_model *const models = s->models;
  const uint32_t count = s->model_count;
  s->models = next->models;
  s->model_count = next->model_count;
  next->models = models;
  next->model_count = count;
}

fvv_status fvv_delta_replace_mesh(fvv_mesh_sequence *s, fvv_mesh *mesh) {
  fvv_mesh_sequence next = {.allocator = s->allocator, .mesh = *mesh, .frame = s->frame};
  memset(mesh, 0, sizeof *mesh);
  fvv_status status = allocate(&next);
  const size_t vertices = s->mesh.vertex_count;
  uint32_t *place = NULL;
  if (status == FVV_OK) place = fvv_allocate_array(&s->allocator, vertices, sizeof *place);
  if (!place) {
    release(&next);
    s->broken = 1;
    return FVV_ERROR_MEMORY;
  }
  for (uint32_t i = 0; i < vertices; i++) place[s->hierarchy.order[i]] = i;
  start(&next);
  carry(s, place, &next);
  fvv_release(&s->allocator, place, vertices * sizeof *place);
  next.patch = s->patch;
  next.kept = s->kept;
  next.kept_count = s->kept_count;
  memset(&s->patch, 0, sizeof s->patch);
  s->kept = NULL;
  release(s);
  *s = next;
  return FVV_OK;
}

const fvv_mesh *fvv_mesh_sequence_mesh(const fvv_mesh_sequence *sequence) {
  return &sequence->mesh;
}

void fvv_delta_follow(fvv_mesh_sequence *sequence, uint32_t level, uint32_t step) {
  const uint32_t end = sequence->hierarchy.level_end[level];
  const int rounding = fvv_delta_rounding(step);
  for (uint32_t i = fvv_delta_level_begin(sequence, level); i < end; i++) {
    int32_t to[3];
    fvv_delta_predict(sequence, i, rounding, to);
    for (int a = 0; a < 3; a++) fvv_delta_move(sequence, i, a, to[a]);
    sequence->now[i] = FVV_DELTA_NO_RESIDUALS;
  }
}

fvv_status fvv_delta_read_header(const fvv_mesh_sequence *s, const uint8_t *payload, size_t size,
                                 const fvv_limits *limits, fvv_mesh_header *header,
                                 fvv_diagnostic *diagnostic) {
  const fvv_status status = fvv_mesh_peek(payload, size, limits, header, diagnostic);
  if (status != FVV_OK) return status;
  if (!fvv_mesh_follows(header->profile))
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, FVV_CHUNK_MESH, FVV_MESH_PROFILE,
                    "a mesh of profile %u begins a sequence, it does not go on with one", header->profile);
  if (header->texture_bits != s->mesh.texture_bits || header->normal_bits != s->mesh.normal_bits ||
      (header->profile == FVV_MESH_DELTA &&
       (header->vertex_count != s->mesh.vertex_count || header->face_count != s->mesh.face_count)))
    return fvv_fail(
        diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_KEY, FVV_CHUNK_MESH, FVV_MESH_VERTEX_COUNT,
        "%lu vertices, %lu faces, %u texture and %u normal bits, the mesh before has %lu, %lu, %u and %u",
        (unsigned long)header->vertex_count, (unsigned long)header->face_count, header->texture_bits,
        header->normal_bits, (unsigned long)s->mesh.vertex_count, (unsigned long)s->mesh.face_count,
        s->mesh.texture_bits, s->mesh.normal_bits);
  return FVV_OK;
}

fvv_status fvv_delta_check_number(const fvv_mesh_sequence *s, const uint8_t *payload, size_t size, size_t at,
                                  fvv_diagnostic *diagnostic) {
  fvv_cursor cursor = {payload, size, at, 0};
  const uint64_t number = fvv_cursor_uleb(&cursor);
  if (cursor.failed || number == (uint64_t)s->frame + 1) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_NUMBER, FVV_CHUNK_MESH, at,
                  "delta frame %llu behind frame %lu of the group: frames are missing",
                  (unsigned long long)number, (unsigned long)s->frame);
}

fvv_status fvv_delta_read_levels(const fvv_mesh_sequence *s, const uint8_t *payload, size_t size, size_t at,
                                 fvv_delta_frame *frame, fvv_diagnostic *diagnostic) {
  fvv_cursor cursor = {payload, size, at, 0};
  const fvv_status status = fvv_delta_check_number(s, payload, size, at, diagnostic);
  if (status != FVV_OK) return status;
  (void)fvv_cursor_uleb(&cursor);
  const uint64_t levels = fvv_cursor_uleb(&cursor);
  if (!cursor.failed && levels != s->hierarchy.level_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_LEVELS, FVV_CHUNK_MESH, at,
                    "%llu levels, the mesh before has %lu", (unsigned long long)levels,
                    (unsigned long)s->hierarchy.level_count);
  uint64_t all = 0;
  for (uint32_t k = 0; k < s->hierarchy.level_count && !cursor.failed; k++) {
    const uint64_t step = fvv_cursor_uleb(&cursor), bytes = fvv_cursor_uleb(&cursor);
    if (!cursor.failed && (step < 1 || step > FVV_DELTA_STEP_MAX))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_LEVELS, FVV_CHUNK_MESH, cursor.position,
                      "level %lu has a step of %llu, steps are 1 to 262143", (unsigned long)k,
                      (unsigned long long)step);
    frame->level[k].step = (uint32_t)step;
    frame->level[k].size = bytes <= size ? (size_t)bytes : size + 1;
    all += frame->level[k].size;
  }
  if (cursor.failed || all != size - cursor.position)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_SIZE, FVV_CHUNK_MESH, at,
                    "the levels' sizes do not add up to the payload's");
  size_t offset = cursor.position;
  for (uint32_t k = 0; k < s->hierarchy.level_count; k++) {
    frame->level[k].offset = offset;
    offset += frame->level[k].size;
  }
  return FVV_OK;
}
