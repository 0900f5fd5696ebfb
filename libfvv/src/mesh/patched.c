/* Patched frames: delta frames in which a mesh of its own replaces some faces, for all frames that follow
 * (clause 8.14). */
#include "mesh/patched.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "mesh/delta.h"
#include "mesh/mesh.h"

/* What a reader finds wrong in a patch is at its offset in the chunk. */
static fvv_status in_patch(const fvv_patched_parts *parts, fvv_status status, fvv_diagnostic *diagnostic) {
  if (diagnostic && status != FVV_OK && status != FVV_ERROR_MEMORY) diagnostic->offset += parts->patch;
  return status;
}

static fvv_status check_patch(const uint8_t *patch, const fvv_mesh_header *header, const fvv_limits *limits,
                              fvv_patched_parts *parts, fvv_diagnostic *diagnostic) {
  const unsigned attributes =
      (header->texture_bits ? FVV_MESH_HAS_TEXTURE : 0) | (header->normal_bits ? FVV_MESH_HAS_NORMALS : 0);
  if (parts->patch_size >= FVV_MESH_SIZE) {
    const uint8_t profile = patch[FVV_MESH_PROFILE];
    if (profile != FVV_MESH_RAW && profile != FVV_MESH_DRACO && profile != FVV_MESH_FAST)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_MESH, FVV_CHUNK_MESH,
                      parts->patch + FVV_MESH_PROFILE, "a patch of profile %u, expected 0, 1 or 4", profile);
    if (patch[FVV_MESH_ATTRIBUTES] != attributes || patch[FVV_MESH_TEXTURE_BITS] != header->texture_bits ||
        patch[FVV_MESH_NORMAL_BITS] != header->normal_bits)
      return fvv_fail(
          diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_MESH, FVV_CHUNK_MESH,
          parts->patch + FVV_MESH_ATTRIBUTES,
          "a patch with attributes 0x%x, %u texture and %u normal bits, its frame has 0x%x, %u and %u",
          patch[FVV_MESH_ATTRIBUTES], patch[FVV_MESH_TEXTURE_BITS], patch[FVV_MESH_NORMAL_BITS], attributes,
          header->texture_bits, header->normal_bits);
  }
  return in_patch(parts, fvv_mesh_peek(patch, parts->patch_size, limits, &parts->header, diagnostic),
                  diagnostic);
}

fvv_status fvv_patched_split(const uint8_t *data, const fvv_mesh_header *header, const fvv_limits *limits,
                             fvv_patched_parts *parts, fvv_diagnostic *diagnostic) {
  memset(parts, 0, sizeof *parts);
  fvv_cursor cursor = {data, header->data_size, 0, 0};
  const uint64_t absent = fvv_cursor_uleb(&cursor), patch = fvv_cursor_uleb(&cursor);
  const uint64_t left = cursor.size - cursor.position;
  if (cursor.failed || absent > left || patch > left - absent)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_SIZE, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "runs of %llu bytes and a patch of %llu, %llu bytes are left", (unsigned long long)absent,
                    (unsigned long long)patch, (unsigned long long)left);
  parts->absent = FVV_MESH_SIZE + cursor.position;
  parts->absent_size = (size_t)absent;
  parts->patch = parts->absent + parts->absent_size;
  parts->patch_size = (size_t)patch;
  parts->delta = parts->patch + parts->patch_size;
  if (!parts->patch_size) return FVV_OK;
  return check_patch(data + (parts->patch - FVV_MESH_SIZE), header, limits, parts, diagnostic);
}

static fvv_status no_memory(const fvv_mesh_sequence *s, fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for a patched frame of %lu faces",
                  (unsigned long)s->mesh.face_count);
}

/* Room for the flags; none is set. */
static fvv_status begin_change(const fvv_mesh_sequence *s, fvv_patched_change *change,
                               fvv_diagnostic *diagnostic) {
  change->face_count = s->mesh.face_count;
  change->vertex_count = s->mesh.vertex_count;
  change->absent = fvv_allocate_zeroed(&s->allocator, change->face_count);
  change->used = fvv_allocate_zeroed(&s->allocator, change->vertex_count);
  return change->absent && change->used ? FVV_OK : no_memory(s, diagnostic);
}

void fvv_patched_change_free(fvv_patched_change *change, const fvv_allocator *allocator) {
  fvv_release(allocator, change->absent, change->face_count);
  fvv_release(allocator, change->used, change->vertex_count);
  memset(change, 0, sizeof *change);
}

/* What remains, by the flags of faces. */
static void count_kept(const fvv_mesh_sequence *s, fvv_patched_change *change) {
  for (size_t f = 0; f < change->face_count; f++) {
    if (change->absent[f]) continue;
    change->kept_faces++;
    for (size_t i = 3 * f; i < 3 * f + 3; i++) change->used[s->mesh.faces[i]] = 1;
  }
  for (size_t v = 0; v < change->vertex_count; v++) change->kept_vertices += change->used[v];
}

static fvv_status read_runs(const uint8_t *payload, const fvv_patched_parts *parts,
                            fvv_patched_change *change, fvv_diagnostic *diagnostic) {
  const uint32_t faces = change->face_count;
  fvv_cursor cursor = {payload, parts->patch, parts->absent, 0};
  uint32_t face = 0;
  for (uint32_t run = 0; cursor.position < cursor.size && !cursor.failed; run++) {
    const size_t offset = cursor.position;
    const uint64_t length = fvv_cursor_uleb(&cursor);
    if (cursor.failed || (run && !length) || length > faces - face)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_FACES, FVV_CHUNK_MESH, offset,
                      "run %lu has %llu faces, %lu of the mesh before are left", (unsigned long)run,
                      (unsigned long long)length, (unsigned long)(faces - face));
    memset(change->absent + face, run & 1, (size_t)length);
    face += (uint32_t)length;
  }
  if (face == faces) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_FACES, FVV_CHUNK_MESH, parts->absent,
                  "runs of %lu faces, the mesh before has %lu", (unsigned long)face, (unsigned long)faces);
}

fvv_status fvv_patched_read(fvv_mesh_sequence *sequence, const uint8_t *payload,
                            const fvv_mesh_header *header, const fvv_patched_parts *parts,
                            const fvv_limits *limits, fvv_patched_change *change,
                            fvv_diagnostic *diagnostic) {
  fvv_mesh_sequence *s = sequence;
  fvv_status status = begin_change(s, change, diagnostic);
  if (status == FVV_OK) status = read_runs(payload, parts, change, diagnostic);
  if (status != FVV_OK) return status;
  count_kept(s, change);
  const uint64_t vertices = (uint64_t)change->kept_vertices + parts->header.vertex_count,
                 faces = (uint64_t)change->kept_faces + parts->header.face_count;
  if (header->vertex_count != vertices || header->face_count != faces)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_COUNTS, FVV_CHUNK_MESH,
                    FVV_MESH_VERTEX_COUNT,
                    "%lu vertices and %lu faces, what remains and the patch have %llu and %llu together",
                    (unsigned long)header->vertex_count, (unsigned long)header->face_count,
                    (unsigned long long)vertices, (unsigned long long)faces);
  if (vertices > FVV_DELTA_VERTICES_MAX)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_MESH, FVV_MESH_VERTEX_COUNT,
                    "%llu vertices, delta frames can follow at most %lu", (unsigned long long)vertices,
                    (unsigned long)FVV_DELTA_VERTICES_MAX);
  if (!parts->patch_size) return FVV_OK;
  return in_patch(parts,
                  fvv_mesh_decode(payload + parts->patch, parts->patch_size, limits, &s->allocator, &s->patch,
                                  diagnostic),
                  diagnostic);
}

/* Pairs of the vertices that stay, then those of the patch. */
static void copy_pairs(const fvv_mesh_sequence *s, uint32_t *to, const uint32_t *former,
                       const uint32_t *own) {
  if (!to) return;
  for (size_t v = 0; v < s->kept_count; v++)
    memcpy(to + 2 * v, former + 2 * (size_t)s->kept[v], 2 * sizeof *to);
  if (own) memcpy(to + 2 * (size_t)s->kept_count, own, (size_t)s->patch.vertex_count * 2 * sizeof *to);
}

/* number: of each vertex that stays its place among them. */
static void fill(const fvv_mesh_sequence *s, const fvv_patched_change *change, const uint32_t *number,
                 fvv_mesh *out) {
  const fvv_mesh *former = &s->mesh, *patch = &s->patch;
  for (size_t v = 0; v < s->kept_count; v++)
    memcpy(out->lattice + 3 * v, former->lattice + 3 * (size_t)s->kept[v], 3 * sizeof *out->lattice);
  if (patch->lattice)
    memcpy(out->lattice + 3 * (size_t)s->kept_count, patch->lattice,
           (size_t)patch->vertex_count * 3 * sizeof *out->lattice);
  copy_pairs(s, out->texture, former->texture, patch->texture);
  copy_pairs(s, out->normals, former->normals, patch->normals);
  uint32_t *to = out->faces;
  for (size_t f = 0; f < former->face_count; f++) {
    if (change->absent[f]) continue;
    for (size_t i = 3 * f; i < 3 * f + 3; i++) *to++ = number[former->faces[i]];
  }
  for (size_t i = 0; i < 3 * (size_t)patch->face_count; i++) *to++ = patch->faces[i] + s->kept_count;
}

fvv_status fvv_patched_merge(fvv_mesh_sequence *sequence, const fvv_patched_change *change,
                             fvv_diagnostic *diagnostic) {
  fvv_mesh_sequence *s = sequence;
  fvv_mesh out = {.allocator = s->allocator,
                  .vertex_count = change->kept_vertices + s->patch.vertex_count,
                  .face_count = change->kept_faces + s->patch.face_count,
                  .texture_bits = s->mesh.texture_bits,
                  .normal_bits = s->mesh.normal_bits};
  /* One more, so that a frame that keeps nothing has an address. */
  s->kept = fvv_allocate_array(&s->allocator, (size_t)change->kept_vertices + 1, sizeof *s->kept);
  uint32_t *number = fvv_allocate_array(&s->allocator, change->vertex_count, sizeof *number);
  fvv_status status = s->kept && number && fvv_mesh_allocate(&out) ? FVV_OK : FVV_ERROR_MEMORY;
  if (s->kept) s->kept_count = change->kept_vertices;
  if (status == FVV_OK) {
    uint32_t kept = 0;
    for (uint32_t v = 0; v < change->vertex_count; v++) {
      if (!change->used[v]) continue;
      number[v] = kept;
      s->kept[kept++] = v;
    }
    fill(s, change, number, &out);
    status = fvv_delta_replace_mesh(s, &out);
  }
  fvv_release(&s->allocator, number, change->vertex_count * sizeof *number);
  fvv_mesh_free(&out);
  return status == FVV_OK ? FVV_OK : no_memory(s, diagnostic);
}

void fvv_patched_clear(fvv_mesh_sequence *sequence) {
  fvv_mesh_sequence *s = sequence;
  fvv_mesh_free(&s->patch);
  fvv_release(&s->allocator, s->kept, ((size_t)s->kept_count + 1) * sizeof *s->kept);
  s->kept = NULL;
  s->kept_count = 0;
}

const fvv_mesh *fvv_mesh_sequence_patch(const fvv_mesh_sequence *sequence) {
  return sequence->patch.lattice ? &sequence->patch : NULL;
}

const uint32_t *fvv_mesh_sequence_kept(const fvv_mesh_sequence *sequence, uint32_t *count) {
  *count = sequence->kept ? sequence->kept_count : sequence->mesh.vertex_count;
  return sequence->kept;
}

/* ---- writing ------------------------------------------------------------------------------------------ */

static fvv_status check_border(const fvv_mesh_sequence *s, const fvv_mesh_patch *patch,
                               fvv_diagnostic *diagnostic) {
  for (uint32_t v = 0; patch->border && v < patch->mesh->vertex_count; v++)
    if (patch->border[v] != UINT32_MAX && patch->border[v] >= s->mesh.vertex_count)
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_INDEX, 0, 0,
                      "vertex %lu of the patch is to lie on vertex %lu of a mesh of %lu", (unsigned long)v,
                      (unsigned long)patch->border[v], (unsigned long)s->mesh.vertex_count);
  return FVV_OK;
}

/* kept: faces that are not left out. */
static fvv_status check_arguments(const fvv_mesh_sequence *s, const fvv_mesh_patch *patch, uint32_t kept,
                                  fvv_diagnostic *diagnostic) {
  const fvv_mesh *mesh = patch->mesh;
  if (!mesh)
    return kept ? FVV_OK
                : fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_COUNTS, 0, 0,
                           "all faces are left out and there is no patch: no face is left");
  if (patch->profile != FVV_MESH_RAW && patch->profile != FVV_MESH_DRACO && patch->profile != FVV_MESH_FAST)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_PATCHED_MESH, 0, 0,
                    "a patch of profile %u, expected 0, 1 or 4", patch->profile);
  if (patch->level < 0 || patch->level > 10)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "level %d is outside 0 to 10", patch->level);
  if (mesh->vertex_count < 3 || mesh->face_count < 1)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_COUNTS, 0, 0,
                    "a patch of %lu vertices and %lu faces, a mesh has at least 3 and 1",
                    (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count);
  if (mesh->texture_bits != s->mesh.texture_bits || mesh->normal_bits != s->mesh.normal_bits)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_PATCHED_MESH, 0, 0,
                    "a patch with %u texture and %u normal bits, the mesh before has %u and %u",
                    mesh->texture_bits, mesh->normal_bits, s->mesh.texture_bits, s->mesh.normal_bits);
  fvv_status status = fvv_mesh_check(mesh, FVV_MESH_FROM_CALLER, &s->allocator, diagnostic);
  return status == FVV_OK ? check_border(s, patch, diagnostic) : status;
}

/* Draco may give a patch more vertices than it was handed: it is called before and after. */
static fvv_status check_readable(const fvv_patched_change *change, uint32_t vertices, uint32_t faces,
                                 fvv_diagnostic *diagnostic) {
  const fvv_limits limits = fvv_limits_or_default(NULL);
  const fvv_status status =
      fvv_readable_check((uint64_t)change->kept_vertices + vertices, limits.max_vertices,
                         "vertices of a mesh with its patch", FVV_CHUNK_MESH, diagnostic);
  return status != FVV_OK ? status
                          : fvv_readable_check((uint64_t)change->kept_faces + faces, limits.max_faces,
                                               "faces of a mesh with its patch", FVV_CHUNK_MESH, diagnostic);
}

static fvv_status put_runs(const fvv_patched_change *change, fvv_bytes *runs) {
  uint32_t length = 0;
  int absent = 0;
  fvv_status status = FVV_OK;
  for (uint32_t f = 0; f < change->face_count && status == FVV_OK; f++, length++) {
    if (change->absent[f] == absent) continue;
    status = fvv_bytes_append_uleb(runs, length);
    length = 0;
    absent = !absent;
  }
  return status == FVV_OK ? fvv_bytes_append_uleb(runs, length) : status;
}

/* For each vertex one that remains and was on its point when the levels were found: itself, or at a seam
 * another; UINT32_MAX: none. */
static void find_remaining(const fvv_mesh_sequence *s, const fvv_patched_change *change, uint32_t *on) {
  const fvv_delta_hierarchy *h = &s->hierarchy;
  for (uint32_t v = 0; v < h->vertex_count; v++) on[v] = change->used[v] ? v : UINT32_MAX;
  for (int back = 0; back < 2; back++)
    for (uint32_t i = h->points; i < h->vertex_count; i++) {
      const uint32_t twin = h->order[i], node = h->order[h->stencils[i].node[0]];
      const uint32_t from = back ? node : twin, to = back ? twin : node;
      if (on[to] == UINT32_MAX) on[to] = on[from];
    }
}

/* The patch as it is sent, and read back: that is part of the state of the next frame. */
static fvv_status code_patch(fvv_mesh_sequence *s, const fvv_mesh *joined, const fvv_mesh_patch *patch,
                             fvv_bytes *bytes, fvv_diagnostic *diagnostic) {
  if (patch->vertices)
    return fvv_mesh_encode_mapped(joined, patch->profile, patch->level, &s->allocator, bytes, &s->patch,
                                  patch->vertices, diagnostic);
  const fvv_status status =
      fvv_mesh_encode(joined, patch->profile, patch->level, &s->allocator, bytes, diagnostic);
  if (status != FVV_OK) return status;
  return fvv_mesh_decode(bytes->data, bytes->size, NULL, &s->allocator, &s->patch, diagnostic);
}

/* The border of the patch lies on the vertices that stay, as they are decoded in this frame. */
static fvv_status encode_patch(fvv_mesh_sequence *s, const fvv_patched_change *change,
                               const fvv_mesh_patch *patch, fvv_bytes *bytes, fvv_diagnostic *diagnostic) {
  uint32_t *on = fvv_allocate_array(&s->allocator, change->vertex_count, sizeof *on);
  fvv_mesh joined;
  fvv_status status = fvv_mesh_copy(patch->mesh, &s->allocator, &joined);
  if (status != FVV_OK || !on) {
    status = no_memory(s, diagnostic);
  } else {
    find_remaining(s, change, on);
    for (size_t v = 0; patch->border && v < joined.vertex_count; v++) {
      const uint32_t lies = patch->border[v] == UINT32_MAX ? UINT32_MAX : on[patch->border[v]];
      if (lies != UINT32_MAX)
        memcpy(joined.lattice + 3 * v, s->mesh.lattice + 3 * (size_t)lies, 3 * sizeof *joined.lattice);
    }
    status = code_patch(s, &joined, patch, bytes, diagnostic);
  }
  fvv_mesh_free(&joined);
  fvv_release(&s->allocator, on, change->vertex_count * sizeof *on);
  return status;
}

/* Buffers of a frame, released by the caller. */
typedef struct coded_parts {
  fvv_bytes runs, patch, delta;
} coded_parts;

static fvv_status put_parts(const fvv_mesh_sequence *s, const fvv_patched_change *change,
                            const coded_parts *parts, fvv_bytes *payload) {
  fvv_status status = fvv_delta_put_header(s, FVV_MESH_PATCHED, change->kept_vertices + s->patch.vertex_count,
                                           change->kept_faces + s->patch.face_count, payload);
  if (status == FVV_OK) status = fvv_bytes_append_uleb(payload, parts->runs.size);
  if (status == FVV_OK) status = fvv_bytes_append_uleb(payload, parts->patch.size);
  if (status == FVV_OK) status = fvv_bytes_append(payload, parts->runs.data, parts->runs.size);
  if (status == FVV_OK) status = fvv_bytes_append(payload, parts->patch.data, parts->patch.size);
  return status == FVV_OK ? fvv_bytes_append(payload, parts->delta.data, parts->delta.size) : status;
}

/* Moves the vertices, then codes all of the frame; after an error nothing can follow. */
static fvv_status encode_parts(fvv_mesh_sequence *s, const int32_t *lattice,
                               const fvv_mesh_delta_options *options, const fvv_mesh_patch *patch,
                               const fvv_patched_change *change, coded_parts *parts, fvv_bytes *payload,
                               fvv_diagnostic *diagnostic) {
  if (put_runs(change, &parts->runs) != FVV_OK) return no_memory(s, diagnostic);
  fvv_status status = fvv_delta_put_levels(s, lattice, change->used, options, &parts->delta, diagnostic);
  if (status == FVV_OK && patch->mesh) {
    status = encode_patch(s, change, patch, &parts->patch, diagnostic);
    if (status == FVV_OK)
      status = check_readable(change, s->patch.vertex_count, s->patch.face_count, diagnostic);
  }
  if (status != FVV_OK) return status;
  if (put_parts(s, change, parts, payload) != FVV_OK) return no_memory(s, diagnostic);
  return fvv_patched_merge(s, change, diagnostic);
}

/* What is found here is found before anything of the state changes. */
static fvv_status prepare(const fvv_mesh_sequence *s, const int32_t *lattice,
                          const fvv_mesh_delta_options *options, const fvv_mesh_patch *patch,
                          fvv_patched_change *change, fvv_diagnostic *diagnostic) {
  fvv_status status = fvv_delta_check_input(s, lattice, options, diagnostic);
  if (status == FVV_OK) status = begin_change(s, change, diagnostic);
  if (status != FVV_OK) return status;
  for (size_t f = 0; patch->absent && f < change->face_count; f++) change->absent[f] = !!patch->absent[f];
  count_kept(s, change);
  status = check_arguments(s, patch, change->kept_faces, diagnostic);
  if (status != FVV_OK || !patch->mesh) return status;
  return check_readable(change, patch->mesh->vertex_count, patch->mesh->face_count, diagnostic);
}

fvv_status fvv_mesh_sequence_encode_patched(fvv_mesh_sequence *sequence, const int32_t *lattice,
                                            const fvv_mesh_delta_options *options,
                                            const fvv_mesh_patch *patch, fvv_bytes *payload,
                                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_mesh_sequence *s = sequence;
  if (!payload->allocator.resize) payload->allocator = s->allocator;
  payload->size = 0;
  fvv_mesh_patch chosen = {0};
  memcpy(&chosen, patch, patch->struct_size < sizeof chosen ? patch->struct_size : sizeof chosen);
  fvv_patched_change change = {0};
  fvv_status status = prepare(s, lattice, options, &chosen, &change, diagnostic);
  if (status == FVV_OK) {
    const fvv_bytes none = {NULL, 0, 0, s->allocator};
    coded_parts parts = {none, none, none};
    fvv_patched_clear(s);
    status = encode_parts(s, lattice, options, &chosen, &change, &parts, payload, diagnostic);
    fvv_bytes_free(&parts.runs);
    fvv_bytes_free(&parts.patch);
    fvv_bytes_free(&parts.delta);
    if (status != FVV_OK) {
      payload->size = 0;
      s->broken = 1;
    }
  }
  fvv_patched_change_free(&change, &s->allocator);
  return status;
}
