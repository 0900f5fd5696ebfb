/* The payload of an environment and the rules that its entries keep (clause 18). */
#include <math.h>
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "fvv/environment.h"
#include "mesh/mesh.h"
#include "video/codecs.h"

/* Returns with an error: a rule of this clause is broken. issue without its prefix, offset in the payload. */
#define WRONG(issue, offset, ...)                                                                            \
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_##issue, FVV_CHUNK_ENVIRONMENT, offset,           \
                  __VA_ARGS__)

#define HALF_PI 1.5707963267948966

static int all_finite(const double *v) {
  return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}
static int is_zero(const double *v) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

/* All rules that concern one entry. offset: of the entry in the payload, or of the file of a picture. */
static fvv_status check_light(const fvv_light *light, uint64_t offset, fvv_diagnostic *diagnostic) {
  if (light->type > FVV_LIGHT_SPOT)
    WRONG(ENVIRONMENT_LIGHT, offset + FVV_BACK_LIGHT_TYPE, "light type is %u, expected 0 to 2", light->type);
  const int placed = light->type != FVV_LIGHT_DIRECTIONAL, directed = light->type != FVV_LIGHT_POINT;
  if (!all_finite(light->position) || (!placed && !is_zero(light->position)))
    WRONG(ENVIRONMENT_LIGHT, offset + FVV_BACK_LIGHT_POSITION,
          "position of a light is not finite, or not 0 although the light is directional");
  const double *d = light->direction;
  const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  if (directed ? !(fabs(sqrt(square) - 1) <= 1e-4) : !is_zero(d))
    WRONG(ENVIRONMENT_LIGHT, offset + FVV_BACK_LIGHT_DIRECTION,
          "direction of a light has length %g, expected 1, or 0 for point lights", sqrt(square));
  for (int k = 0; k < 3; k++)
    if (!(light->colour[k] >= 0 && light->colour[k] <= 1))
      WRONG(ENVIRONMENT_LIGHT, offset + FVV_BACK_LIGHT_COLOUR + 8 * (unsigned)k,
            "colour of a light is %g, expected 0 to 1", light->colour[k]);
  if (!(light->intensity >= 0 && isfinite(light->intensity)))
    WRONG(ENVIRONMENT_LIGHT, offset + FVV_BACK_LIGHT_INTENSITY,
          "intensity of a light is %g, expected 0 or more", light->intensity);
  if (!(light->range >= 0 && isfinite(light->range)) || (!placed && light->range != 0))
    WRONG(ENVIRONMENT_LIGHT, offset + FVV_BACK_LIGHT_RANGE,
          "range of a light is %g, expected 0 or more, and 0 for directional lights", light->range);
  const int cone =
      light->inner_cone >= 0 && light->inner_cone < light->outer_cone && light->outer_cone <= HALF_PI;
  if (light->type == FVV_LIGHT_SPOT ? !cone : light->inner_cone != 0 || light->outer_cone != 0)
    WRONG(ENVIRONMENT_LIGHT, offset + FVV_BACK_LIGHT_INNER_CONE,
          "cone of a light is %g to %g, expected 0 <= inner < outer <= pi / 2 for a spot, else 0",
          light->inner_cone, light->outer_cone);
  return FVV_OK;
}

/* Checks of a picture file without decoding it (clause 18.3). JPEG files are checked like JPEG samples of
 * video; of PNG files (ISO/IEC 15948) the signature, IHDR and IEND are. */

enum { SIGNATURE_SIZE = 8, IHDR_SIZE = 25 /* with length, type and CRC */, IEND_SIZE = 12 };
static const uint8_t signature[SIGNATURE_SIZE] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
static const uint8_t ihdr[8] = {0, 0, 0, 13, 'I', 'H', 'D', 'R'};
static const uint8_t iend[IEND_SIZE] = {0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};

static uint32_t get_be32(const uint8_t *p) {
  return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static int is_png(const uint8_t *data, size_t size) {
  return size >= SIGNATURE_SIZE + IHDR_SIZE + IEND_SIZE && !memcmp(data, signature, sizeof signature) &&
         !memcmp(data + SIGNATURE_SIZE, ihdr, sizeof ihdr) &&
         !memcmp(data + size - IEND_SIZE, iend, sizeof iend);
}

static fvv_status check_picture(const fvv_environment_picture *picture, uint64_t offset,
                                fvv_diagnostic *diagnostic) {
  if (picture->codec > FVV_PICTURE_PNG)
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_ENVIRONMENT_CODEC, FVV_CHUNK_ENVIRONMENT,
                    offset, "picture codec is %u, expected 0 or 1", picture->codec);
  if (picture->codec == FVV_PICTURE_JPEG) {
    fvv_diagnostic why = {0};
    if (fvv_jpeg_inspect(picture->width, picture->height, picture->data, picture->size, &why) != FVV_OK)
      WRONG(ENVIRONMENT_PICTURE, offset + why.offset, "%.150s", why.message);
    return FVV_OK;
  }
  if (!is_png(picture->data, picture->size))
    WRONG(ENVIRONMENT_PICTURE, offset, "PNG of %zu bytes lacks signature, IHDR or IEND", picture->size);
  const uint32_t width = get_be32(picture->data + 16), height = get_be32(picture->data + 20);
  if (!width || !height || width != picture->width || height != picture->height)
    WRONG(ENVIRONMENT_PICTURE, offset + 16, "PNG has %lu x %lu pixels, expected %lu x %lu",
          (unsigned long)width, (unsigned long)height, (unsigned long)picture->width,
          (unsigned long)picture->height);
  return FVV_OK;
}

/* The size in the first frame header; 0 when there is none. fvv_jpeg_inspect reports faults. */
static void find_jpeg_size(fvv_environment_picture *picture) {
  const uint8_t *p = picture->data;
  size_t at = 2;
  picture->width = picture->height = 0;
  while (at + 9 <= picture->size) {
    const uint8_t marker = p[at + 1];
    if (p[at] != 0xff) return;
    if (marker == 0xff || marker == 0x01) {
      at += marker == 0xff ? 1 : 2;
      continue;
    }
    if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) {
      picture->height = (uint32_t)p[at + 5] << 8 | p[at + 6];
      picture->width = (uint32_t)p[at + 7] << 8 | p[at + 8];
      return;
    }
    at += 2 + ((size_t)p[at + 2] << 8 | p[at + 3]);
  }
}

fvv_status fvv_environment_picture_inspect(fvv_environment_picture *picture, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (is_png(picture->data, picture->size)) {
    picture->codec = FVV_PICTURE_PNG;
    picture->width = get_be32(picture->data + 16);
    picture->height = get_be32(picture->data + 20);
  } else {
    picture->codec = FVV_PICTURE_JPEG;
    find_jpeg_size(picture);
  }
  const fvv_status status = check_picture(picture, 0, diagnostic);
  if (diagnostic && status == FVV_ERROR_INVALID) diagnostic->status = FVV_ERROR_INPUT;
  return status == FVV_ERROR_INVALID ? FVV_ERROR_INPUT : status;
}

/* BACK payloads, read and checked (clause 18): header, tables of parts, pictures and lights, then the data of
 * all meshes and pictures in the order of their entries. */

/* Where things are in the payload. */
typedef struct places {
  uint64_t pictures, lights, data; /* the parts follow the header */
} places;

static fvv_status within_limit(uint64_t count, uint64_t most, const char *what, uint64_t offset,
                               fvv_diagnostic *diagnostic) {
  if (count <= most) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_ENVIRONMENT, offset,
                  "environment has %llu %s, limit %llu", (unsigned long long)count, what,
                  (unsigned long long)most);
}

static void get_vector(const uint8_t *p, double *out, int count) {
  for (int k = 0; k < count; k++) out[k] = fvv_get_f64(p + 8 * k);
}

/* Sizes, flags and reserved bytes of all entries, before any of them is used. */
static fvv_status check_tables(const uint8_t *p, size_t size, const fvv_environment *environment,
                               const places *at, fvv_diagnostic *diagnostic) {
  uint64_t end = at->data;
  for (size_t i = 0; i < environment->part_count + environment->picture_count; i++) {
    const int is_part = i < environment->part_count;
    const uint64_t entry = is_part ? FVV_BACK_SIZE + (uint64_t)i * FVV_BACK_PART_SIZE
                                   : at->pictures + (i - environment->part_count) * FVV_BACK_PICTURE_SIZE;
    const uint32_t bytes =
        fvv_get_u32(p + entry + (is_part ? FVV_BACK_PART_MESH_SIZE : FVV_BACK_PICTURE_BYTES));
    if (!bytes || bytes > size - end)
      WRONG(ENVIRONMENT_PAYLOAD, entry, "entry has %lu bytes, expected 1 to %llu", (unsigned long)bytes,
            (unsigned long long)(size - end));
    end += bytes;
  }
  for (size_t i = 0; i < environment->part_count; i++) {
    const uint64_t entry = FVV_BACK_SIZE + (uint64_t)i * FVV_BACK_PART_SIZE;
    if (p[entry + FVV_BACK_PART_FLAGS] & ~(FVV_PART_UNLIT | FVV_PART_DOUBLE_SIDED | FVV_PART_CLAMPED) ||
        p[entry + FVV_BACK_PART_RESERVED])
      WRONG(ENVIRONMENT_PAYLOAD, entry + FVV_BACK_PART_FLAGS, "reserved bits of a part are not 0");
  }
  for (size_t i = 0; i < environment->picture_count; i++) {
    const uint64_t entry = at->pictures + (uint64_t)i * FVV_BACK_PICTURE_SIZE;
    if (!fvv_all_zero(p + entry + FVV_BACK_PICTURE_RESERVED, 3))
      WRONG(ENVIRONMENT_PAYLOAD, entry + FVV_BACK_PICTURE_RESERVED, "reserved bytes of a picture are not 0");
  }
  for (size_t i = 0; i < environment->light_count; i++) {
    const uint64_t entry = at->lights + (uint64_t)i * FVV_BACK_LIGHT_SIZE;
    if (p[entry + FVV_BACK_LIGHT_FLAGS] & ~FVV_LIGHT_CASTS_SHADOWS ||
        !fvv_all_zero(p + entry + FVV_BACK_LIGHT_RESERVED, 6))
      WRONG(ENVIRONMENT_PAYLOAD, entry + FVV_BACK_LIGHT_FLAGS, "reserved bits of a light are not 0");
  }
  return FVV_OK;
}

static fvv_status read_header(const uint8_t *p, size_t size, const fvv_limits *limits, fvv_environment *out,
                              places *at, fvv_diagnostic *diagnostic) {
  if (size < FVV_BACK_SIZE)
    WRONG(ENVIRONMENT_PAYLOAD, size, "payload has %zu bytes, expected at least %d", size, FVV_BACK_SIZE);
  if (!fvv_all_zero(p + FVV_BACK_RESERVED, FVV_BACK_SIZE - FVV_BACK_RESERVED))
    WRONG(ENVIRONMENT_PAYLOAD, FVV_BACK_RESERVED, "reserved bytes are not 0");
  const uint64_t parts = fvv_get_u32(p + FVV_BACK_PART_COUNT),
                 pictures = fvv_get_u32(p + FVV_BACK_PICTURE_COUNT),
                 lights = fvv_get_u32(p + FVV_BACK_LIGHT_COUNT);
  at->pictures = FVV_BACK_SIZE + parts * FVV_BACK_PART_SIZE;
  at->lights = at->pictures + pictures * FVV_BACK_PICTURE_SIZE;
  at->data = at->lights + lights * FVV_BACK_LIGHT_SIZE;
  const uint64_t most = parts > pictures    ? (parts > lights ? parts : lights)
                        : pictures > lights ? pictures
                                            : lights;
  const fvv_status fits = within_limit(most, limits->max_environment, "parts, pictures or lights",
                                       FVV_BACK_PART_COUNT, diagnostic);
  if (fits != FVV_OK) return fits;
  if (at->data > size || !(parts + lights))
    WRONG(ENVIRONMENT_PAYLOAD, FVV_BACK_PART_COUNT,
          "%llu parts, %llu pictures and %llu lights do not fit a payload of %zu bytes",
          (unsigned long long)parts, (unsigned long long)pictures, (unsigned long long)lights, size);
  out->part_count = (size_t)parts;
  out->picture_count = (size_t)pictures;
  out->light_count = (size_t)lights;
  const fvv_status whole = check_tables(p, size, out, at, diagnostic);
  if (whole != FVV_OK) return whole;
  get_vector(p + FVV_BACK_LATTICE_ORIGIN, out->lattice_origin, 3);
  out->lattice_step = fvv_get_f64(p + FVV_BACK_LATTICE_STEP);
  for (int k = 0; k < 3; k++)
    if (!(out->lattice_step > 0) ||
        !isfinite(fabs(out->lattice_origin[k]) + out->lattice_step * FVV_LATTICE_MAX))
      WRONG(ENVIRONMENT_LATTICE, FVV_BACK_LATTICE_ORIGIN,
            "lattice has origin %g and step %g, expected a positive step and finite positions",
            out->lattice_origin[k], out->lattice_step);
  return FVV_OK;
}

/* The data of the next entry, which follow those of the one before. */
static const uint8_t *take(uint64_t *data, uint32_t size, const uint8_t *payload) {
  const uint8_t *taken = payload + *data;
  *data += size;
  return taken;
}

static fvv_status read_part(const uint8_t *p, uint64_t offset, const fvv_environment *environment,
                            fvv_environment_part *part, fvv_diagnostic *diagnostic) {
  part->picture = fvv_get_u32(p + FVV_BACK_PART_PICTURE);
  for (int k = 0; k < 3; k++) part->colour[k] = fvv_get_u16(p + FVV_BACK_PART_COLOUR + 2 * k);
  part->flags = p[FVV_BACK_PART_FLAGS];
  get_vector(p + FVV_BACK_PART_TEXTURE_ORIGIN, part->texture_origin, 2);
  get_vector(p + FVV_BACK_PART_TEXTURE_SIZE, part->texture_size, 2);
  if (part->picture != FVV_NO_PICTURE && part->picture >= environment->picture_count)
    WRONG(ENVIRONMENT_PART, offset + FVV_BACK_PART_PICTURE,
          "part has picture %lu, the environment has %zu pictures", (unsigned long)part->picture,
          environment->picture_count);
  for (int k = 0; k < 2; k++)
    if (!isfinite(part->texture_origin[k]) || !isfinite(part->texture_size[k]) ||
        !(part->texture_size[k] > 0))
      WRONG(ENVIRONMENT_PART, offset + FVV_BACK_PART_TEXTURE_ORIGIN,
            "texture has origin %g and size %g, expected finite numbers and a positive size",
            part->texture_origin[k], part->texture_size[k]);
  return FVV_OK;
}

/* Turns an error of a mesh into one of the chunk that contains it. */
static void place_error(fvv_diagnostic *diagnostic, uint64_t offset) {
  fvv_diagnostic_rebase(diagnostic, offset, FVV_CHUNK_ENVIRONMENT);
  if (diagnostic) diagnostic->chunk_type = FVV_CHUNK_ENVIRONMENT;
}

static fvv_status check_mesh(const fvv_environment_part *part, const uint8_t *payload,
                             const fvv_limits *limits, uint64_t *vertices, uint64_t *faces,
                             fvv_diagnostic *diagnostic) {
  const uint64_t offset = (uint64_t)(part->mesh - payload);
  fvv_mesh_header header;
  const fvv_status status = fvv_mesh_peek(part->mesh, part->mesh_size, limits, &header, diagnostic);
  if (status != FVV_OK) {
    place_error(diagnostic, offset);
    return status;
  }
  if (fvv_mesh_follows(header.profile))
    WRONG(ENVIRONMENT_PART, offset, "mesh of an environment is of profile %u, expected 0, 1 or 4",
          header.profile);
  if (part->picture != FVV_NO_PICTURE && !header.texture_bits)
    WRONG(ENVIRONMENT_PART, offset, "part has picture %lu but no texture coordinates",
          (unsigned long)part->picture);
  *vertices += header.vertex_count;
  *faces += header.face_count;
  const fvv_status fits = within_limit(*vertices, limits->max_vertices, "vertices", offset, diagnostic);
  return fits == FVV_OK ? within_limit(*faces, limits->max_faces, "faces", offset, diagnostic) : fits;
}

static fvv_status read_parts(const uint8_t *payload, uint64_t *data, const fvv_limits *limits,
                             fvv_environment *out, fvv_diagnostic *diagnostic) {
  uint64_t vertices = 0, faces = 0;
  fvv_status status = FVV_OK;
  for (size_t i = 0; i < out->part_count && status == FVV_OK; i++) {
    const uint64_t offset = FVV_BACK_SIZE + (uint64_t)i * FVV_BACK_PART_SIZE;
    fvv_environment_part *part = &out->parts[i];
    const uint32_t size = fvv_get_u32(payload + offset + FVV_BACK_PART_MESH_SIZE);
    status = read_part(payload + offset, offset, out, part, diagnostic);
    part->mesh = take(data, size, payload);
    part->mesh_size = size;
    if (status == FVV_OK) status = check_mesh(part, payload, limits, &vertices, &faces, diagnostic);
  }
  return status;
}

static fvv_status read_pictures(const uint8_t *payload, uint64_t offset, uint64_t *data,
                                const fvv_limits *limits, fvv_environment *out, fvv_diagnostic *diagnostic) {
  const uint64_t side = limits->max_dimension;
  uint64_t pixels = 0;
  for (size_t i = 0; i < out->picture_count; i++, offset += FVV_BACK_PICTURE_SIZE) {
    const uint8_t *p = payload + offset;
    fvv_environment_picture *picture = &out->pictures[i];
    picture->codec = p[FVV_BACK_PICTURE_CODEC];
    picture->width = fvv_get_u32(p + FVV_BACK_PICTURE_WIDTH);
    picture->height = fvv_get_u32(p + FVV_BACK_PICTURE_HEIGHT);
    picture->size = fvv_get_u32(p + FVV_BACK_PICTURE_BYTES);
    picture->data = take(data, (uint32_t)picture->size, payload);
    fvv_status status = check_picture(picture, (uint64_t)(picture->data - payload), diagnostic);
    const uint64_t longer = picture->width > picture->height ? picture->width : picture->height;
    if (status == FVV_OK)
      status = within_limit(longer, side, "pixels along a side of a picture", offset, diagnostic);
    if (status != FVV_OK) return status;
    pixels += (uint64_t)picture->width * picture->height;
    status = within_limit(pixels, side * side, "pixels in the pictures", offset, diagnostic);
    if (status != FVV_OK) return status;
  }
  return FVV_OK;
}

static fvv_status read_lights(const uint8_t *payload, uint64_t offset, fvv_environment *out,
                              fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < out->light_count; i++, offset += FVV_BACK_LIGHT_SIZE) {
    const uint8_t *p = payload + offset;
    fvv_light *light = &out->lights[i];
    light->type = p[FVV_BACK_LIGHT_TYPE];
    light->flags = p[FVV_BACK_LIGHT_FLAGS];
    get_vector(p + FVV_BACK_LIGHT_POSITION, light->position, 3);
    get_vector(p + FVV_BACK_LIGHT_DIRECTION, light->direction, 3);
    get_vector(p + FVV_BACK_LIGHT_COLOUR, light->colour, 3);
    light->intensity = fvv_get_f64(p + FVV_BACK_LIGHT_INTENSITY);
    light->range = fvv_get_f64(p + FVV_BACK_LIGHT_RANGE);
    light->inner_cone = fvv_get_f64(p + FVV_BACK_LIGHT_INNER_CONE);
    light->outer_cone = fvv_get_f64(p + FVV_BACK_LIGHT_OUTER_CONE);
    const fvv_status status = check_light(light, offset, diagnostic);
    if (status != FVV_OK) return status;
  }
  return FVV_OK;
}

/* Arrays of no entries stay NULL. */
static int allocate(const fvv_allocator *allocator, size_t count, size_t size, void **out) {
  *out = count ? fvv_allocate_array(allocator, count, size) : NULL;
  return *out || !count;
}

static fvv_status read(const uint8_t *payload, size_t size, const fvv_limits *limits, fvv_environment *out,
                       fvv_diagnostic *diagnostic) {
  places at = {0};
  fvv_status status = read_header(payload, size, limits, out, &at, diagnostic);
  if (status != FVV_OK) {
    out->part_count = out->picture_count = out->light_count = 0;
    return status;
  }
  void *parts = NULL, *pictures = NULL, *lights = NULL;
  const int enough = allocate(&out->allocator, out->part_count, sizeof *out->parts, &parts) &&
                     allocate(&out->allocator, out->picture_count, sizeof *out->pictures, &pictures) &&
                     allocate(&out->allocator, out->light_count, sizeof *out->lights, &lights);
  out->parts = parts;
  out->pictures = pictures;
  out->lights = lights;
  if (!enough)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, FVV_CHUNK_ENVIRONMENT, 0,
                    "out of memory for an environment");
  status = read_parts(payload, &at.data, limits, out, diagnostic);
  if (status == FVV_OK) status = read_pictures(payload, at.pictures, &at.data, limits, out, diagnostic);
  return status == FVV_OK ? read_lights(payload, at.lights, out, diagnostic) : status;
}

fvv_status fvv_environment_decode(const uint8_t *payload, size_t size, const fvv_limits *limits,
                                  const fvv_allocator *allocator, fvv_environment *environment,
                                  fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *environment = (fvv_environment){.payload = payload, .allocator = fvv_allocator_or_default(allocator)};
  const fvv_limits chosen = fvv_limits_or_default(limits);
  const fvv_status status = read(payload, size, &chosen, environment, diagnostic);
  if (status != FVV_OK) fvv_environment_free(environment);
  return status;
}

void fvv_environment_free(fvv_environment *environment) {
  const fvv_allocator memory = fvv_allocator_or_default(&environment->allocator);
  if (environment->parts)
    fvv_release(&memory, environment->parts, environment->part_count * sizeof *environment->parts);
  if (environment->pictures)
    fvv_release(&memory, environment->pictures, environment->picture_count * sizeof *environment->pictures);
  if (environment->lights)
    fvv_release(&memory, environment->lights, environment->light_count * sizeof *environment->lights);
  *environment = (fvv_environment){0};
}

fvv_status fvv_environment_mesh(const fvv_environment *environment, size_t part, const fvv_limits *limits,
                                const fvv_allocator *allocator, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *mesh = (fvv_mesh){0};
  if (part >= environment->part_count)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "no part %zu, the environment has %zu parts",
                    part, environment->part_count);
  const fvv_environment_part *chosen = &environment->parts[part];
  const fvv_status status =
      fvv_mesh_decode(chosen->mesh, chosen->mesh_size, limits, allocator, mesh, diagnostic);
  if (status != FVV_OK) place_error(diagnostic, (uint64_t)(chosen->mesh - environment->payload));
  return status;
}

/* BACK payloads, written (clause 18). The decoder checks the result, so that there is one set of rules. */

static void put_vector(uint8_t *p, const double *values, int count) {
  for (int k = 0; k < count; k++) fvv_put_f64(p + 8 * k, values[k]);
}

static fvv_status put_header(const fvv_environment *b, fvv_bytes *out) {
  uint8_t p[FVV_BACK_SIZE] = {0};
  put_vector(p + FVV_BACK_LATTICE_ORIGIN, b->lattice_origin, 3);
  fvv_put_f64(p + FVV_BACK_LATTICE_STEP, b->lattice_step);
  fvv_put_u32(p + FVV_BACK_PART_COUNT, (uint32_t)b->part_count);
  fvv_put_u32(p + FVV_BACK_PICTURE_COUNT, (uint32_t)b->picture_count);
  fvv_put_u32(p + FVV_BACK_LIGHT_COUNT, (uint32_t)b->light_count);
  return fvv_bytes_append(out, p, sizeof p);
}

static fvv_status put_part(const fvv_environment_part *part, fvv_bytes *out) {
  uint8_t p[FVV_BACK_PART_SIZE] = {0};
  fvv_put_u32(p + FVV_BACK_PART_MESH_SIZE, (uint32_t)part->mesh_size);
  fvv_put_u32(p + FVV_BACK_PART_PICTURE, part->picture);
  for (int k = 0; k < 3; k++) fvv_put_u16(p + FVV_BACK_PART_COLOUR + 2 * k, part->colour[k]);
  p[FVV_BACK_PART_FLAGS] = part->flags;
  put_vector(p + FVV_BACK_PART_TEXTURE_ORIGIN, part->texture_origin, 2);
  put_vector(p + FVV_BACK_PART_TEXTURE_SIZE, part->texture_size, 2);
  return fvv_bytes_append(out, p, sizeof p);
}

static fvv_status put_picture(const fvv_environment_picture *picture, fvv_bytes *out) {
  uint8_t p[FVV_BACK_PICTURE_SIZE] = {0};
  p[FVV_BACK_PICTURE_CODEC] = picture->codec;
  fvv_put_u32(p + FVV_BACK_PICTURE_WIDTH, picture->width);
  fvv_put_u32(p + FVV_BACK_PICTURE_HEIGHT, picture->height);
  fvv_put_u32(p + FVV_BACK_PICTURE_BYTES, (uint32_t)picture->size);
  return fvv_bytes_append(out, p, sizeof p);
}

static fvv_status put_light(const fvv_light *light, fvv_bytes *out) {
  uint8_t p[FVV_BACK_LIGHT_SIZE] = {0};
  p[FVV_BACK_LIGHT_TYPE] = light->type;
  p[FVV_BACK_LIGHT_FLAGS] = light->flags;
  put_vector(p + FVV_BACK_LIGHT_POSITION, light->position, 3);
  put_vector(p + FVV_BACK_LIGHT_DIRECTION, light->direction, 3);
  put_vector(p + FVV_BACK_LIGHT_COLOUR, light->colour, 3);
  fvv_put_f64(p + FVV_BACK_LIGHT_INTENSITY, light->intensity);
  fvv_put_f64(p + FVV_BACK_LIGHT_RANGE, light->range);
  fvv_put_f64(p + FVV_BACK_LIGHT_INNER_CONE, light->inner_cone);
  fvv_put_f64(p + FVV_BACK_LIGHT_OUTER_CONE, light->outer_cone);
  return fvv_bytes_append(out, p, sizeof p);
}

static fvv_status write(const fvv_environment *b, fvv_bytes *out) {
  fvv_status status = put_header(b, out);
  for (size_t i = 0; i < b->part_count && status == FVV_OK; i++) status = put_part(&b->parts[i], out);
  for (size_t i = 0; i < b->picture_count && status == FVV_OK; i++)
    status = put_picture(&b->pictures[i], out);
  for (size_t i = 0; i < b->light_count && status == FVV_OK; i++) status = put_light(&b->lights[i], out);
  for (size_t i = 0; i < b->part_count && status == FVV_OK; i++)
    status = fvv_bytes_append(out, b->parts[i].mesh, b->parts[i].mesh_size);
  for (size_t i = 0; i < b->picture_count && status == FVV_OK; i++)
    status = fvv_bytes_append(out, b->pictures[i].data, b->pictures[i].size);
  return status;
}

/* Sizes and counts have 32 bits. */
static int fits(const fvv_environment *b) {
  int all = b->part_count <= UINT32_MAX && b->picture_count <= UINT32_MAX && b->light_count <= UINT32_MAX;
  for (size_t i = 0; i < b->part_count; i++) all = all && b->parts[i].mesh_size <= UINT32_MAX;
  for (size_t i = 0; i < b->picture_count; i++) all = all && b->pictures[i].size <= UINT32_MAX;
  return all;
}

/* The rules, and the limits that every reader has. */
static fvv_status judge(const fvv_bytes *payload, const fvv_allocator *allocator,
                        fvv_diagnostic *diagnostic) {
  fvv_environment again;
  fvv_status status = fvv_readable_check(payload->size, fvv_limits_or_default(NULL).max_payload,
                                         "bytes of an environment", FVV_CHUNK_ENVIRONMENT, diagnostic);
  if (status == FVV_OK)
    status = fvv_environment_decode(payload->data, payload->size, NULL, allocator, &again, diagnostic);
  if (status == FVV_OK) fvv_environment_free(&again);
  return status;
}

fvv_status fvv_environment_encode(const fvv_environment *environment, const fvv_allocator *allocator,
                                  fvv_bytes *payload, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator memory = fvv_allocator_or_default(allocator);
  if (!payload->allocator.resize) payload->allocator = memory;
  payload->size = 0;
  if (!fits(environment))
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_ENVIRONMENT_PAYLOAD, FVV_CHUNK_ENVIRONMENT, 0,
                    "a mesh or picture of 4 GiB or more does not fit in an environment");
  fvv_status status = write(environment, payload);
  if (status == FVV_ERROR_MEMORY)
    return fvv_fail(diagnostic, status, 0, FVV_CHUNK_ENVIRONMENT, 0,
                    "out of memory while encoding an environment");
  status = judge(payload, &memory, diagnostic);
  if (status == FVV_OK) return status;
  payload->size = 0;
  if (status == FVV_ERROR_MEMORY) return status;
  if (diagnostic) diagnostic->status = FVV_ERROR_INPUT;
  return FVV_ERROR_INPUT;
}
