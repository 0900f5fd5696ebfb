/* Patched frames: delta frames in which a mesh of its own replaces some faces of the key mesh (clause 8.14).
 */
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

/* The runs change the flags of the frame before. *kept: faces that are not left out. */
static fvv_status read_runs(fvv_mesh_sequence *s, const uint8_t *payload, const fvv_patched_parts *parts,
                            uint32_t *kept, fvv_diagnostic *diagnostic) {
  const uint32_t faces = s->mesh.face_count;
  fvv_cursor cursor = {payload, parts->patch, parts->absent, 0};
  uint32_t face = 0;
  for (uint32_t run = 0; cursor.position < cursor.size && !cursor.failed; run++) {
    const size_t offset = cursor.position;
    const uint64_t length = fvv_cursor_uleb(&cursor);
    if (cursor.failed || (run && !length) || length > faces - face)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_FACES, FVV_CHUNK_MESH, offset,
                      "run %lu has %llu faces, %lu of the key mesh are left", (unsigned long)run,
                      (unsigned long long)length, (unsigned long)(faces - face));
    const uint32_t end = face + (uint32_t)length;
    for (; face < end; face++) s->absent[face] ^= run & 1;
  }
  if (face != faces)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_FACES, FVV_CHUNK_MESH, parts->absent,
                    "runs of %lu faces, the key mesh has %lu", (unsigned long)face, (unsigned long)faces);
  *kept = 0;
  for (face = 0; face < faces; face++) *kept += !s->absent[face];
  return FVV_OK;
}

fvv_status fvv_patched_read(fvv_mesh_sequence *sequence, const uint8_t *payload,
                            const fvv_mesh_header *header, const fvv_patched_parts *parts,
                            const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  fvv_mesh_sequence *s = sequence;
  if (!s->absent) s->absent = fvv_allocate_zeroed(&s->allocator, s->mesh.face_count);
  if (!s->absent) return no_memory(s, diagnostic);
  uint32_t kept = 0;
  const fvv_status status = read_runs(s, payload, parts, &kept, diagnostic);
  if (status != FVV_OK) return status;
  const uint64_t vertices = (uint64_t)s->mesh.vertex_count + parts->header.vertex_count,
                 faces = (uint64_t)kept + parts->header.face_count;
  if (header->vertex_count != vertices || header->face_count != faces)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PATCHED_COUNTS, FVV_CHUNK_MESH,
                    FVV_MESH_VERTEX_COUNT,
                    "%lu vertices and %lu faces, key mesh and patch together have %llu and %llu",
                    (unsigned long)header->vertex_count, (unsigned long)header->face_count,
                    (unsigned long long)vertices, (unsigned long long)faces);
  fvv_mesh_free(&s->patch);
  if (!parts->patch_size) return FVV_OK;
  return in_patch(parts,
                  fvv_mesh_decode(payload + parts->patch, parts->patch_size, limits, &s->allocator, &s->patch,
                                  diagnostic),
                  diagnostic);
}

fvv_status fvv_patched_decode_patch(const uint8_t *payload, size_t size, const fvv_limits *limits,
                                    const fvv_allocator *allocator, fvv_mesh *patch,
                                    fvv_diagnostic *diagnostic) {
  memset(patch, 0, sizeof *patch);
  fvv_mesh_header header;
  fvv_patched_parts parts;
  fvv_status status = fvv_mesh_peek(payload, size, limits, &header, diagnostic);
  if (status != FVV_OK || header.profile != FVV_MESH_PATCHED) return status;
  status = fvv_patched_split(payload + FVV_MESH_SIZE, &header, limits, &parts, diagnostic);
  if (status != FVV_OK || !parts.patch_size) return status;
  return in_patch(
      &parts, fvv_mesh_decode(payload + parts.patch, parts.patch_size, limits, allocator, patch, diagnostic),
      diagnostic);
}

static void copy_pairs(uint32_t *to, const uint32_t *key, uint32_t key_vertices, const fvv_mesh *patch,
                       const uint32_t *own) {
  if (!to) return;
  memcpy(to, key, (size_t)key_vertices * 2 * sizeof *to);
  if (own) memcpy(to + 2 * (size_t)key_vertices, own, (size_t)patch->vertex_count * 2 * sizeof *to);
}

static void fill(const fvv_mesh_sequence *s, fvv_mesh *out) {
  const fvv_mesh *key = &s->mesh, *patch = &s->patch;
  const size_t vertices = key->vertex_count;
  memcpy(out->lattice, key->lattice, vertices * 3 * sizeof *out->lattice);
  if (patch->lattice)
    memcpy(out->lattice + 3 * vertices, patch->lattice,
           (size_t)patch->vertex_count * 3 * sizeof *out->lattice);
  copy_pairs(out->texture, key->texture, key->vertex_count, patch, patch->texture);
  copy_pairs(out->normals, key->normals, key->vertex_count, patch, patch->normals);
  uint32_t *to = out->faces;
  for (size_t f = 0; f < key->face_count; f++) {
    if (s->absent[f]) continue;
    memcpy(to, key->faces + 3 * f, 3 * sizeof *to);
    to += 3;
  }
  for (size_t i = 0; i < 3 * (size_t)patch->face_count; i++) *to++ = patch->faces[i] + key->vertex_count;
}

fvv_status fvv_patched_merge(fvv_mesh_sequence *sequence, fvv_diagnostic *diagnostic) {
  fvv_mesh_sequence *s = sequence;
  fvv_mesh_free(&s->merged);
  fvv_mesh *out = &s->merged;
  out->allocator = s->allocator;
  out->vertex_count = s->mesh.vertex_count + s->patch.vertex_count;
  out->face_count = s->patch.face_count;
  for (size_t f = 0; f < s->mesh.face_count; f++) out->face_count += !s->absent[f];
  out->texture_bits = s->mesh.texture_bits;
  out->normal_bits = s->mesh.normal_bits;
  if (!fvv_mesh_allocate(out)) return no_memory(s, diagnostic);
  fill(s, out);
  return FVV_OK;
}

void fvv_patched_clear(fvv_mesh_sequence *sequence) {
  fvv_mesh_free(&sequence->merged);
  fvv_mesh_free(&sequence->patch);
  if (sequence->absent) memset(sequence->absent, 0, sequence->mesh.face_count);
}

const fvv_mesh *fvv_mesh_sequence_patch(const fvv_mesh_sequence *sequence) {
  return sequence->patch.lattice ? &sequence->patch : NULL;
}

const uint8_t *fvv_mesh_sequence_absent(const fvv_mesh_sequence *sequence) {
  return sequence->merged.lattice ? sequence->absent : NULL;
}

/* ---- writing ------------------------------------------------------------------------------------------ */

static int is_absent(const fvv_mesh_patch *patch, size_t face) {
  return patch->absent && patch->absent[face];
}

static fvv_status check_border(const fvv_mesh_sequence *s, const fvv_mesh_patch *patch,
                               fvv_diagnostic *diagnostic) {
  for (uint32_t v = 0; patch->border && v < patch->mesh->vertex_count; v++)
    if (patch->border[v] != UINT32_MAX && patch->border[v] >= s->mesh.vertex_count)
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_INDEX, 0, 0,
                      "vertex %lu of the patch is to lie on vertex %lu of a key mesh of %lu",
                      (unsigned long)v, (unsigned long)patch->border[v], (unsigned long)s->mesh.vertex_count);
  return FVV_OK;
}

/* What is found here is found before anything of the state changes. kept: faces that are not left out. */
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
                    "a patch with %u texture and %u normal bits, the key mesh has %u and %u",
                    mesh->texture_bits, mesh->normal_bits, s->mesh.texture_bits, s->mesh.normal_bits);
  fvv_status status = fvv_mesh_check(mesh, FVV_MESH_FROM_CALLER, &s->allocator, diagnostic);
  return status == FVV_OK ? check_border(s, patch, diagnostic) : status;
}

/* Draco may give a patch more vertices than it was handed: it is called before and after. */
static fvv_status check_readable(const fvv_mesh_sequence *s, uint32_t vertices, uint32_t faces,
                                 fvv_diagnostic *diagnostic) {
  const fvv_limits limits = fvv_limits_or_default(NULL);
  const fvv_status status =
      fvv_readable_check((uint64_t)s->mesh.vertex_count + vertices, limits.max_vertices,
                         "vertices of a mesh with its patch", FVV_CHUNK_MESH, diagnostic);
  return status != FVV_OK ? status
                          : fvv_readable_check((uint64_t)s->mesh.face_count + faces, limits.max_faces,
                                               "faces of a mesh with its patch", FVV_CHUNK_MESH, diagnostic);
}

static fvv_status put_runs(const fvv_mesh_sequence *s, const fvv_mesh_patch *patch, fvv_bytes *runs) {
  const uint8_t *before = s->absent;
  uint32_t length = 0;
  int changes = 0;
  fvv_status status = FVV_OK;
  for (uint32_t f = 0; f < s->mesh.face_count && status == FVV_OK; f++, length++) {
    if (((before && before[f]) != is_absent(patch, f)) == changes) continue;
    status = fvv_bytes_append_uleb(runs, length);
    length = 0;
    changes = !changes;
  }
  return status == FVV_OK ? fvv_bytes_append_uleb(runs, length) : status;
}

/* The patch as it is sent: its border lies on the key mesh's vertices as they are decoded in this frame. */
static fvv_status encode_patch(const fvv_mesh_sequence *s, const fvv_mesh_patch *patch, fvv_bytes *bytes,
                               fvv_diagnostic *diagnostic) {
  fvv_mesh joined;
  if (fvv_mesh_copy(patch->mesh, &s->allocator, &joined) != FVV_OK) return no_memory(s, diagnostic);
  for (size_t v = 0; patch->border && v < joined.vertex_count; v++)
    if (patch->border[v] != UINT32_MAX)
      memcpy(joined.lattice + 3 * v, s->mesh.lattice + 3 * (size_t)patch->border[v],
             3 * sizeof *joined.lattice);
  const fvv_status status =
      fvv_mesh_encode(&joined, patch->profile, patch->level, &s->allocator, bytes, diagnostic);
  fvv_mesh_free(&joined);
  return status;
}

/* Buffers of a frame, released by the caller. */
typedef struct coded_parts {
  fvv_bytes runs, patch, delta;
} coded_parts;

static fvv_status put_parts(const fvv_mesh_sequence *s, const coded_parts *parts,
                            const fvv_mesh_header *patch, uint32_t kept, fvv_bytes *payload) {
  fvv_status status = fvv_delta_put_header(s, FVV_MESH_PATCHED, s->mesh.vertex_count + patch->vertex_count,
                                           kept + patch->face_count, payload);
  if (status == FVV_OK) status = fvv_bytes_append_uleb(payload, parts->runs.size);
  if (status == FVV_OK) status = fvv_bytes_append_uleb(payload, parts->patch.size);
  if (status == FVV_OK) status = fvv_bytes_append(payload, parts->runs.data, parts->runs.size);
  if (status == FVV_OK) status = fvv_bytes_append(payload, parts->patch.data, parts->patch.size);
  return status == FVV_OK ? fvv_bytes_append(payload, parts->delta.data, parts->delta.size) : status;
}

/* Reads back what was written: that is the state of the next frame. */
static fvv_status follow(fvv_mesh_sequence *s, const fvv_mesh_patch *patch, const fvv_bytes *payload,
                         fvv_diagnostic *diagnostic) {
  fvv_mesh_header header;
  fvv_patched_parts parts;
  fvv_diagnostic why;
  fvv_status status = fvv_mesh_peek(payload->data, payload->size, NULL, &header, &why);
  if (status == FVV_OK)
    status = fvv_patched_split(payload->data + FVV_MESH_SIZE, &header, NULL, &parts, &why);
  if (status == FVV_OK) status = fvv_patched_read(s, payload->data, &header, &parts, NULL, &why);
  int same = status == FVV_OK;
  for (size_t f = 0; f < s->mesh.face_count && same; f++) same = s->absent[f] == is_absent(patch, f);
  if (same) return fvv_patched_merge(s, diagnostic);
  if (status == FVV_ERROR_MEMORY) return no_memory(s, diagnostic);
  return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0, "what was encoded does not decode: %.150s",
                  status == FVV_OK ? "other faces are left out" : why.message);
}

/* Moves the vertices, then codes all of the frame; after an error nothing can follow. */
static fvv_status encode_parts(fvv_mesh_sequence *s, const int32_t *lattice,
                               const fvv_mesh_delta_options *options, const fvv_mesh_patch *patch,
                               uint32_t kept, coded_parts *parts, fvv_bytes *payload,
                               fvv_diagnostic *diagnostic) {
  if (put_runs(s, patch, &parts->runs) != FVV_OK) return no_memory(s, diagnostic);
  fvv_status status = fvv_delta_put_levels(s, lattice, options, &parts->delta, diagnostic);
  fvv_mesh_header header = {0};
  if (status == FVV_OK && patch->mesh) {
    status = encode_patch(s, patch, &parts->patch, diagnostic);
    if (status == FVV_OK)
      status = fvv_mesh_peek(parts->patch.data, parts->patch.size, NULL, &header, diagnostic);
    if (status == FVV_OK) status = check_readable(s, header.vertex_count, header.face_count, diagnostic);
  }
  if (status != FVV_OK) return status;
  if (put_parts(s, parts, &header, kept, payload) != FVV_OK) return no_memory(s, diagnostic);
  return follow(s, patch, payload, diagnostic);
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
  uint32_t kept = 0;
  for (size_t f = 0; f < s->mesh.face_count; f++) kept += !is_absent(&chosen, f);
  fvv_status status = fvv_delta_check_input(s, lattice, options, diagnostic);
  if (status == FVV_OK) status = check_arguments(s, &chosen, kept, diagnostic);
  if (status == FVV_OK && chosen.mesh)
    status = check_readable(s, chosen.mesh->vertex_count, chosen.mesh->face_count, diagnostic);
  if (status != FVV_OK) return status;
  const fvv_bytes none = {NULL, 0, 0, s->allocator};
  coded_parts parts = {none, none, none};
  status = encode_parts(s, lattice, options, &chosen, kept, &parts, payload, diagnostic);
  fvv_bytes_free(&parts.runs);
  fvv_bytes_free(&parts.patch);
  fvv_bytes_free(&parts.delta);
  if (status == FVV_OK) return FVV_OK;
  payload->size = 0;
  s->broken = 1;
  return status;
}
