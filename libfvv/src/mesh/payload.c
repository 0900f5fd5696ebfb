/* Payloads of key meshes. */
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "fvv/mesh.h"
#include "mesh/draco_bridge.h"
#include "mesh/draco_check.h"
#include "mesh/fast.h"
#include "mesh/hash.h"
#include "mesh/mesh.h"
#include "mesh/patched.h"

const char *fvv_mesh_profile_name(uint8_t profile) {
  static const char *const names[FVV_MESH_PROFILE_COUNT] = {"raw",   "draco", "delta",
                                                            "field", "fast",  "patched"};
  return profile < FVV_MESH_PROFILE_COUNT ? names[profile] : NULL;
}

static fvv_status no_memory(const fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0,
                  "no memory to encode a mesh of %lu vertices and %lu faces",
                  (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count);
}

/* Bytes of the raw profile. */
static uint64_t raw_size(uint32_t vertices, uint32_t faces, int texture, int normals) {
  return (12 + (texture ? 8 : 0) + (normals ? 8 : 0)) * (uint64_t)vertices + 12 * (uint64_t)faces;
}

static fvv_status invalid(fvv_diagnostic *diagnostic, uint32_t issue, uint64_t offset, const char *text) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, FVV_CHUNK_MESH, offset, "%s", text);
}

static fvv_status check_size(const fvv_mesh_header *header, const uint8_t *data, const fvv_limits *limits,
                             fvv_diagnostic *diagnostic) {
  const uint64_t raw =
      raw_size(header->vertex_count, header->face_count, header->texture_bits, header->normal_bits);
  const fvv_draco_counts counts = {header->vertex_count, header->face_count};
  if (header->profile == FVV_MESH_RAW && header->data_size != raw)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_RAW_SIZE, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "%zu bytes follow the header, %lu vertices and %lu faces take %llu", header->data_size,
                    (unsigned long)header->vertex_count, (unsigned long)header->face_count,
                    (unsigned long long)raw);
  if (header->profile == FVV_MESH_DRACO && !fvv_draco_dense_enough(header->data_size, counts))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_DENSITY, FVV_CHUNK_MESH,
                    FVV_MESH_VERTEX_COUNT,
                    "%zu bytes of Draco bitstream cannot carry %lu vertices and %lu faces", header->data_size,
                    (unsigned long)header->vertex_count, (unsigned long)header->face_count);
  if (header->profile == FVV_MESH_FAST) {
    fvv_fast_streams streams;
    return fvv_fast_split(data, header, &streams, diagnostic);
  }
  if (header->profile == FVV_MESH_PATCHED) {
    fvv_patched_parts parts;
    return fvv_patched_split(data, header, limits, &parts, diagnostic);
  }
  return FVV_OK;
}

static int known_profile(uint8_t profile) {
  return profile == FVV_MESH_RAW || profile == FVV_MESH_DRACO || profile == FVV_MESH_FAST ||
         fvv_mesh_follows(profile);
}

static fvv_status check_attributes(const uint8_t *payload, fvv_diagnostic *diagnostic) {
  const unsigned attributes = payload[FVV_MESH_ATTRIBUTES], bits = payload[FVV_MESH_TEXTURE_BITS];
  if (attributes & ~(unsigned)(FVV_MESH_HAS_TEXTURE | FVV_MESH_HAS_NORMALS))
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_MESH_PROFILE, FVV_CHUNK_MESH,
                    FVV_MESH_ATTRIBUTES, "mesh attributes 0x%x are not known, only bits 0 and 1 are",
                    attributes);
  const int texture = attributes & FVV_MESH_HAS_TEXTURE;
  if (texture ? bits < 1 || bits > FVV_TEXTURE_BITS_MAX : bits != 0)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_TEXTURE_BITS, FVV_CHUNK_MESH,
                    FVV_MESH_TEXTURE_BITS,
                    texture ? "%u texture bits, texture coordinates have 1 to 16"
                            : "%u texture bits in a mesh without texture coordinates",
                    bits);
  const unsigned normal_bits = payload[FVV_MESH_NORMAL_BITS];
  const int normals = attributes & FVV_MESH_HAS_NORMALS;
  if (normals ? normal_bits < 2 || normal_bits > FVV_NORMAL_BITS_MAX : normal_bits != 0)
    return fvv_fail(
        diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_NORMAL_BITS, FVV_CHUNK_MESH, FVV_MESH_NORMAL_BITS,
        normals ? "%u normal bits, normals have 2 to 12" : "%u normal bits in a mesh without normals",
        normal_bits);
  return FVV_OK;
}

fvv_status fvv_mesh_peek(const uint8_t *payload, size_t size, const fvv_limits *limits,
                         fvv_mesh_header *header, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(header, 0, sizeof *header);
  if (size < FVV_MESH_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_PAYLOAD, FVV_CHUNK_MESH, 0,
                    "%zu bytes of MESH payload, its header has %d", size, FVV_MESH_SIZE);
  const fvv_mesh_header read = {payload[FVV_MESH_PROFILE],
                                fvv_get_u32(payload + FVV_MESH_VERTEX_COUNT),
                                fvv_get_u32(payload + FVV_MESH_FACE_COUNT),
                                size - FVV_MESH_SIZE,
                                payload[FVV_MESH_TEXTURE_BITS],
                                payload[FVV_MESH_NORMAL_BITS]};
  if (fvv_get_u32(payload + FVV_MESH_RESERVED))
    return invalid(diagnostic, FVV_ISSUE_MESH_PAYLOAD, FVV_MESH_RESERVED, "reserved bytes are not 0");
  if (!known_profile(read.profile))
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_MESH_PROFILE, FVV_CHUNK_MESH,
                    FVV_MESH_PROFILE, "mesh profile %u is not known, 0 to 2, 4 and 5 are", read.profile);
  fvv_status status = check_attributes(payload, diagnostic);
  if (status != FVV_OK) return status;
  if (read.vertex_count < 3 || read.face_count < 1)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_COUNTS, FVV_CHUNK_MESH,
                    FVV_MESH_VERTEX_COUNT, "%lu vertices and %lu faces, a mesh has at least 3 and 1",
                    (unsigned long)read.vertex_count, (unsigned long)read.face_count);
  const fvv_limits most = fvv_limits_or_default(limits);
  if (read.vertex_count > most.max_vertices || read.face_count > most.max_faces)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_MESH, FVV_MESH_VERTEX_COUNT,
                    "%lu vertices and %lu faces, this reader takes at most %lu and %lu",
                    (unsigned long)read.vertex_count, (unsigned long)read.face_count,
                    (unsigned long)most.max_vertices, (unsigned long)most.max_faces);
  status = check_size(&read, payload + FVV_MESH_SIZE, &most, diagnostic);
  if (status == FVV_OK) *header = read;
  return status;
}

static fvv_status allocate(fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  if (fvv_mesh_allocate(mesh)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for a mesh of %lu vertices and %lu faces",
                  (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count);
}

static void read_raw(const uint8_t *data, fvv_mesh *mesh) {
  const size_t vertices = mesh->vertex_count, corners = 3 * (size_t)mesh->face_count;
  for (size_t i = 0; i < 3 * vertices; i++, data += 4) {
    const uint32_t bits = fvv_get_u32(data);
    memcpy(&mesh->lattice[i], &bits, sizeof bits);
  }
  for (size_t i = 0; mesh->texture && i < 2 * vertices; i++, data += 4) mesh->texture[i] = fvv_get_u32(data);
  for (size_t i = 0; mesh->normals && i < 2 * vertices; i++, data += 4) mesh->normals[i] = fvv_get_u32(data);
  for (size_t i = 0; i < corners; i++, data += 4) mesh->faces[i] = fvv_get_u32(data);
}

static fvv_status decode(const fvv_mesh_header *header, const uint8_t *data, fvv_mesh *mesh,
                         fvv_diagnostic *diagnostic) {
  if (header->profile == FVV_MESH_RAW) {
    const fvv_status status = allocate(mesh, diagnostic);
    if (status != FVV_OK) return status;
    read_raw(data, mesh);
    return fvv_mesh_check(mesh, FVV_MESH_FROM_RAW, &mesh->allocator, diagnostic);
  }
  if (header->profile == FVV_MESH_FAST) {
    fvv_status status = allocate(mesh, diagnostic);
    if (status == FVV_OK) status = fvv_fast_decode(data, header, mesh, diagnostic);
    if (status == FVV_OK)
      status = fvv_mesh_check(mesh, FVV_MESH_FROM_BITSTREAM, &mesh->allocator, diagnostic);
    return status;
  }
  const fvv_draco_counts counts = {header->vertex_count, header->face_count};
  fvv_status status = fvv_draco_check(data, header->data_size, counts, header->texture_bits != 0,
                                      header->normal_bits != 0, &mesh->allocator, NULL, diagnostic);
  if (status == FVV_OK) status = allocate(mesh, diagnostic);
  if (status == FVV_OK) status = fvv_draco_decode(data, header->data_size, mesh, diagnostic);
  if (status == FVV_OK) status = fvv_mesh_check(mesh, FVV_MESH_FROM_BITSTREAM, &mesh->allocator, diagnostic);
  return status;
}

fvv_status fvv_mesh_decode(const uint8_t *payload, size_t size, const fvv_limits *limits,
                           const fvv_allocator *allocator, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  memset(mesh, 0, sizeof *mesh);
  fvv_mesh_header header;
  fvv_status status = fvv_mesh_peek(payload, size, limits, &header, diagnostic);
  if (status != FVV_OK) return status;
  if (fvv_mesh_follows(header.profile))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_KEY, FVV_CHUNK_MESH, FVV_MESH_PROFILE,
                    "a %s frame does not stand alone, it needs the key mesh before it",
                    fvv_mesh_profile_name(header.profile));
  mesh->allocator = fvv_allocator_or_default(allocator);
  mesh->vertex_count = header.vertex_count;
  mesh->face_count = header.face_count;
  mesh->texture_bits = header.texture_bits;
  mesh->normal_bits = header.normal_bits;
  status = decode(&header, payload + FVV_MESH_SIZE, mesh, diagnostic);
  if (status != FVV_OK) fvv_mesh_free(mesh);
  return status;
}

static fvv_status put_header(const fvv_mesh *mesh, fvv_bytes *payload, uint8_t profile) {
  uint8_t header[FVV_MESH_SIZE] = {0};
  header[FVV_MESH_PROFILE] = profile;
  header[FVV_MESH_ATTRIBUTES] = fvv_mesh_attributes(mesh);
  header[FVV_MESH_TEXTURE_BITS] = mesh->texture_bits;
  header[FVV_MESH_NORMAL_BITS] = mesh->normal_bits;
  payload->size = 0;
  return fvv_bytes_append(payload, header, sizeof header);
}

static void put_counts(fvv_bytes *payload, uint32_t vertices, uint32_t faces) {
  fvv_put_u32(payload->data + FVV_MESH_VERTEX_COUNT, vertices);
  fvv_put_u32(payload->data + FVV_MESH_FACE_COUNT, faces);
}

static fvv_status encode_raw(const fvv_mesh *mesh, fvv_bytes *payload) {
  const uint64_t size =
      raw_size(mesh->vertex_count, mesh->face_count, mesh->texture != NULL, mesh->normals != NULL);
  if (size > SIZE_MAX) return FVV_ERROR_MEMORY;
  fvv_status status = put_header(mesh, payload, FVV_MESH_RAW);
  if (status == FVV_OK) status = fvv_bytes_reserve(payload, (size_t)size);
  if (status != FVV_OK) return status;
  put_counts(payload, mesh->vertex_count, mesh->face_count);
  uint8_t *p = payload->data + payload->size;
  for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++, p += 4)
    fvv_put_u32(p, (uint32_t)mesh->lattice[i]);
  for (size_t i = 0; mesh->texture && i < 2 * (size_t)mesh->vertex_count; i++, p += 4)
    fvv_put_u32(p, mesh->texture[i]);
  for (size_t i = 0; mesh->normals && i < 2 * (size_t)mesh->vertex_count; i++, p += 4)
    fvv_put_u32(p, mesh->normals[i]);
  for (size_t i = 0; i < 3 * (size_t)mesh->face_count; i++, p += 4) fvv_put_u32(p, mesh->faces[i]);
  payload->size += (size_t)size;
  return FVV_OK;
}

static uint64_t vertex_hash(const fvv_mesh *mesh, uint32_t vertex) {
  const int32_t *p = mesh->lattice + 3 * (size_t)vertex;
  uint64_t hash = fvv_hash3((uint32_t)p[0], (uint32_t)p[1], (uint32_t)p[2]);
  const uint32_t *const pairs[2] = {mesh->texture, mesh->normals};
  for (int i = 0; i < 2; i++) {
    if (!pairs[i]) continue;
    const uint32_t *pair = pairs[i] + 2 * (size_t)vertex;
    hash = fvv_mix(hash ^ fvv_mix((uint64_t)pair[0] << 32 | pair[1]));
  }
  return hash;
}

/* The sum of hashes of all triangles, each begun at each of its corners: equal for the same triangles in any
 * order of vertices and faces, different for others but for one chance in 2^64. */
static uint64_t fingerprint(const fvv_mesh *mesh) {
  uint64_t sum = 0;
  for (size_t f = 0; f < mesh->face_count; f++) {
    uint64_t corner[3];
    for (size_t c = 0; c < 3; c++) corner[c] = vertex_hash(mesh, mesh->faces[3 * f + c]);
    for (int c = 0; c < 3; c++)
      sum += fvv_mix(fvv_mix(fvv_mix(corner[c]) + corner[(c + 1) % 3]) + corner[(c + 2) % 3]);
  }
  return sum;
}

static fvv_status check_counts_readable(uint32_t vertices, uint32_t faces, fvv_diagnostic *diagnostic) {
  const fvv_limits limits = fvv_limits_or_default(NULL);
  const fvv_status status =
      fvv_readable_check(vertices, limits.max_vertices, "vertices of a mesh", FVV_CHUNK_MESH, diagnostic);
  return status != FVV_OK
             ? status
             : fvv_readable_check(faces, limits.max_faces, "faces of a mesh", FVV_CHUNK_MESH, diagnostic);
}

/* Decodes what this process has encoded within a reader's limits: whatever fails is a bug. */
static fvv_status decode_own(const fvv_bytes *payload, const fvv_allocator *allocator, fvv_mesh *decoded,
                             fvv_diagnostic *diagnostic) {
  fvv_diagnostic why;
  const fvv_status status = fvv_mesh_decode(payload->data, payload->size, NULL, allocator, decoded, &why);
  if (status == FVV_OK || status == FVV_ERROR_MEMORY) return status;
  return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0, "what was encoded does not decode: %.150s",
                  why.message);
}

static fvv_status verify(const fvv_mesh *mesh, const fvv_allocator *allocator, const fvv_bytes *payload,
                         fvv_diagnostic *diagnostic) {
  fvv_mesh decoded;
  fvv_status status = decode_own(payload, allocator, &decoded, diagnostic);
  if (status != FVV_OK) return status;
  if (decoded.face_count != mesh->face_count || fingerprint(&decoded) != fingerprint(mesh))
    status = fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0,
                      "%lu faces were coded and %lu come back: not the same triangles",
                      (unsigned long)mesh->face_count, (unsigned long)decoded.face_count);
  fvv_mesh_free(&decoded);
  return status;
}

static fvv_status encode_fast(const fvv_mesh *mesh, fvv_bytes *payload, fvv_diagnostic *diagnostic) {
  const fvv_status status = put_header(mesh, payload, FVV_MESH_FAST);
  if (status != FVV_OK) return status;
  put_counts(payload, mesh->vertex_count, mesh->face_count);
  return fvv_fast_encode(mesh, payload, diagnostic);
}

/* Draco splits vertices where the surface is not a manifold: the result has its counts. */
static fvv_status encode_draco(const fvv_mesh *mesh, int level, fvv_draco_coding coding, fvv_bytes *payload,
                               fvv_diagnostic *diagnostic) {
  fvv_draco_counts counts;
  fvv_status status = put_header(mesh, payload, FVV_MESH_DRACO);
  if (status == FVV_OK) status = fvv_draco_encode(mesh, level, coding, payload, diagnostic);
  if (status == FVV_OK)
    status = fvv_draco_read_counts(payload->data + FVV_MESH_SIZE, payload->size - FVV_MESH_SIZE, &counts,
                                   diagnostic);
  if (status == FVV_OK) status = check_counts_readable(counts.vertices, counts.faces, diagnostic);
  if (status == FVV_OK) put_counts(payload, counts.vertices, counts.faces);
  return status;
}

/* 1 when a reader will refuse the payload as too much for its bytes or too slow, although it is right. */
static int too_costly(const fvv_bytes *payload, const fvv_allocator *allocator) {
  const unsigned attributes = payload->data[FVV_MESH_ATTRIBUTES];
  const fvv_draco_counts counts = {fvv_get_u32(payload->data + FVV_MESH_VERTEX_COUNT),
                                   fvv_get_u32(payload->data + FVV_MESH_FACE_COUNT)};
  const uint8_t *data = payload->data + FVV_MESH_SIZE;
  const size_t size = payload->size - FVV_MESH_SIZE;
  if (!fvv_draco_dense_enough(size, counts)) return 1;
  fvv_diagnostic why;
  fvv_diagnostic_clear(&why);
  return fvv_draco_check(data, size, counts, attributes & FVV_MESH_HAS_TEXTURE,
                         attributes & FVV_MESH_HAS_NORMALS, allocator, NULL, &why) != FVV_OK &&
         why.issue == FVV_ISSUE_DRACO_STEPS;
}

static fvv_status encode(const fvv_mesh *mesh, uint8_t profile, int level, const fvv_allocator *allocator,
                         fvv_bytes *payload, fvv_draco_coding *coding, fvv_diagnostic *diagnostic) {
  fvv_status status = fvv_mesh_check(mesh, FVV_MESH_FROM_CALLER, allocator, diagnostic);
  if (status != FVV_OK) return status;
  if (profile == FVV_MESH_RAW) return encode_raw(mesh, payload);
  if (profile == FVV_MESH_FAST) {
    status = encode_fast(mesh, payload, diagnostic);
    return status == FVV_OK ? verify(mesh, allocator, payload, diagnostic) : status;
  }
  if (mesh->vertex_count > FVV_DRACO_COUNT_MAX || mesh->face_count > FVV_DRACO_COUNT_MAX)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
                    "%lu vertices and %lu faces are more than Draco can count",
                    (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count);
  /* A large regular plane codes to next to nothing: more than a reader can believe of so few bytes; standard
   * edgebreaker takes enough of them. Vertices with thousands of faces can make splits too slow; without
   * edgebreaker there are none. */
  static const fvv_draco_coding codings[] = {FVV_DRACO_BY_LEVEL, FVV_DRACO_STANDARD, FVV_DRACO_SEQUENTIAL};
  for (size_t i = 0; i < sizeof codings / sizeof codings[0]; i++) {
    *coding = codings[i];
    status = encode_draco(mesh, level, *coding, payload, diagnostic);
    if (status != FVV_OK || !too_costly(payload, allocator)) break;
  }
  return status == FVV_OK ? verify(mesh, allocator, payload, diagnostic) : status;
}

/* fvv_mesh_encode, and *coding, which of Draco's codings it took. It has no meaning for other profiles. */
static fvv_status encode_reporting(const fvv_mesh *mesh, uint8_t profile, int level,
                                   const fvv_allocator *allocator, fvv_bytes *payload,
                                   fvv_draco_coding *coding, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator memory = fvv_allocator_or_default(allocator);
  if (!payload->allocator.resize) payload->allocator = memory;
  payload->size = 0;
  if (fvv_mesh_follows(profile) || !known_profile(profile))
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "mesh profile %u is not one to encode with",
                    profile);
  if (level < 0 || level > 10)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "level %d is outside 0 to 10", level);
  if (mesh->vertex_count < 3 || mesh->face_count < 1)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_COUNTS, 0, 0,
                    "%lu vertices and %lu faces, a mesh has at least 3 and 1",
                    (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count);
  fvv_status status = check_counts_readable(mesh->vertex_count, mesh->face_count, diagnostic);
  if (status == FVV_OK) status = encode(mesh, profile, level, &memory, payload, coding, diagnostic);
  if (status != FVV_OK) payload->size = 0;
  if (status == FVV_ERROR_MEMORY)
    return fvv_fail(diagnostic, status, 0, 0, 0, "no memory to encode a mesh of %lu vertices and %lu faces",
                    (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count);
  return status;
}

fvv_status fvv_mesh_encode(const fvv_mesh *mesh, uint8_t profile, int level, const fvv_allocator *allocator,
                           fvv_bytes *payload, fvv_diagnostic *diagnostic) {
  fvv_draco_coding coding;
  return encode_reporting(mesh, profile, level, allocator, payload, &coding, diagnostic);
}

/* The order of a decoded mesh in terms of the one that was encoded. The order depends on the faces alone
 * and on options, never on positions: so a second mesh with the same faces, whose positions are the numbers
 * of its vertices, says after decoding which vertex is where. That is checked, not believed. */

/* The numbered mesh as its decoder yields it. Faces, texture coordinates and normals are borrowed from mesh,
 * lattice is the caller's: 3 * vertex_count. */
static fvv_status code_numbers(const fvv_mesh *mesh, uint8_t profile, int level, fvv_draco_coding coding,
                               int32_t *lattice, const fvv_mesh *decoded, fvv_bytes *bytes,
                               fvv_mesh *numbered, fvv_diagnostic *diagnostic) {
  fvv_mesh source = *mesh;
  source.lattice = lattice;
  memset(lattice, 0, 3 * (size_t)mesh->vertex_count * sizeof *lattice);
  for (uint32_t v = 0; v < mesh->vertex_count; v++) lattice[3 * (size_t)v] = (int32_t)v;
  fvv_status status;
  if (profile == FVV_MESH_FAST) {
    status = fvv_mesh_encode(&source, profile, level, &bytes->allocator, bytes, diagnostic);
    return status == FVV_OK ? decode_own(bytes, &bytes->allocator, numbered, diagnostic) : status;
  }
  /* By Draco alone: what a reader has to believe of a payload is another matter for another mesh. */
  status = fvv_draco_encode(&source, level, coding, bytes, diagnostic);
  if (status != FVV_OK) return status;
  numbered->allocator = bytes->allocator;
  numbered->vertex_count = decoded->vertex_count;
  numbered->face_count = decoded->face_count;
  numbered->texture_bits = decoded->texture_bits;
  numbered->normal_bits = decoded->normal_bits;
  if (!fvv_mesh_allocate(numbered)) return no_memory(mesh, diagnostic);
  return fvv_draco_decode(bytes->data, bytes->size, numbered, diagnostic);
}

static int same_vertex(const fvv_mesh *decoded, uint32_t i, const fvv_mesh *mesh, uint32_t j) {
  return !memcmp(decoded->lattice + 3 * (size_t)i, mesh->lattice + 3 * (size_t)j,
                 3 * sizeof *mesh->lattice) &&
         (!mesh->texture || !memcmp(decoded->texture + 2 * (size_t)i, mesh->texture + 2 * (size_t)j,
                                    2 * sizeof *mesh->texture)) &&
         (!mesh->normals || !memcmp(decoded->normals + 2 * (size_t)i, mesh->normals + 2 * (size_t)j,
                                    2 * sizeof *mesh->normals));
}

static fvv_status read_numbers(const fvv_mesh *mesh, const fvv_mesh *decoded, const fvv_mesh *numbered,
                               uint32_t *vertices, fvv_diagnostic *diagnostic) {
  int same =
      !memcmp(decoded->faces, numbered->faces, 3 * (size_t)decoded->face_count * sizeof *decoded->faces);
  for (uint32_t v = 0; v < decoded->vertex_count && same; v++) {
    const int32_t number = numbered->lattice[3 * (size_t)v];
    same = number >= 0 && (uint32_t)number < mesh->vertex_count &&
           same_vertex(decoded, v, mesh, (uint32_t)number);
    vertices[v] = (uint32_t)number;
  }
  return same ? FVV_OK
              : fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0,
                         "the encoder orders the vertices of a mesh by something else than its faces");
}

static fvv_status find_order(const fvv_mesh *mesh, uint8_t profile, int level, fvv_draco_coding coding,
                             const fvv_allocator *memory, const fvv_mesh *decoded, uint32_t *vertices,
                             fvv_diagnostic *diagnostic) {
  const size_t size = 3 * (size_t)mesh->vertex_count * sizeof(int32_t);
  int32_t *lattice = fvv_allocate(memory, size);
  fvv_bytes bytes = {0};
  bytes.allocator = *memory;
  fvv_mesh numbered = {0};
  fvv_status status = lattice ? FVV_OK : no_memory(mesh, diagnostic);
  if (status == FVV_OK)
    status = code_numbers(mesh, profile, level, coding, lattice, decoded, &bytes, &numbered, diagnostic);
  if (status == FVV_OK) status = read_numbers(mesh, decoded, &numbered, vertices, diagnostic);
  fvv_mesh_free(&numbered);
  fvv_bytes_free(&bytes);
  fvv_release(memory, lattice, size);
  return status;
}

fvv_status fvv_mesh_encode_mapped(const fvv_mesh *mesh, uint8_t profile, int level,
                                  const fvv_allocator *allocator, fvv_bytes *payload, fvv_mesh *decoded,
                                  uint32_t *vertices, fvv_diagnostic *diagnostic) {
  const fvv_allocator memory = fvv_allocator_or_default(allocator);
  fvv_draco_coding coding;
  memset(decoded, 0, sizeof *decoded);
  fvv_status status = encode_reporting(mesh, profile, level, &memory, payload, &coding, diagnostic);
  if (status == FVV_OK) status = decode_own(payload, &memory, decoded, diagnostic);
  if (status == FVV_OK && profile == FVV_MESH_RAW)
    for (uint32_t v = 0; v < mesh->vertex_count; v++) vertices[v] = v;
  else if (status == FVV_OK)
    status = find_order(mesh, profile, level, coding, &memory, decoded, vertices, diagnostic);
  if (status == FVV_OK) return FVV_OK;
  fvv_mesh_free(decoded);
  payload->size = 0;
  return status == FVV_ERROR_MEMORY ? no_memory(mesh, diagnostic) : status;
}
