/* BACK payloads, written (clause 18). The decoder judges what comes out, so that there is one set of rules.
 */
#include "background/background.h"
#include "base/bytes.h"
#include "base/limits.h"
#include "base/memory.h"

static void put_vector(uint8_t *p, const double *values, int count) {
  for (int k = 0; k < count; k++) fvv_put_f64(p + 8 * k, values[k]);
}

static fvv_status put_header(const fvv_background *b, fvv_bytes *out) {
  uint8_t p[FVV_BACK_SIZE] = {0};
  put_vector(p + FVV_BACK_LATTICE_ORIGIN, b->lattice_origin, 3);
  fvv_put_f64(p + FVV_BACK_LATTICE_STEP, b->lattice_step);
  fvv_put_u32(p + FVV_BACK_PART_COUNT, (uint32_t)b->part_count);
  fvv_put_u32(p + FVV_BACK_PICTURE_COUNT, (uint32_t)b->picture_count);
  fvv_put_u32(p + FVV_BACK_LIGHT_COUNT, (uint32_t)b->light_count);
  return fvv_bytes_append(out, p, sizeof p);
}

static fvv_status put_part(const fvv_background_part *part, fvv_bytes *out) {
  uint8_t p[FVV_BACK_PART_SIZE] = {0};
  fvv_put_u32(p + FVV_BACK_PART_MESH_SIZE, (uint32_t)part->mesh_size);
  fvv_put_u32(p + FVV_BACK_PART_PICTURE, part->picture);
  for (int k = 0; k < 3; k++) fvv_put_u16(p + FVV_BACK_PART_COLOUR + 2 * k, part->colour[k]);
  p[FVV_BACK_PART_FLAGS] = part->flags;
  put_vector(p + FVV_BACK_PART_TEXTURE_ORIGIN, part->texture_origin, 2);
  put_vector(p + FVV_BACK_PART_TEXTURE_SIZE, part->texture_size, 2);
  return fvv_bytes_append(out, p, sizeof p);
}

static fvv_status put_picture(const fvv_background_picture *picture, fvv_bytes *out) {
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

static fvv_status write(const fvv_background *b, fvv_bytes *out) {
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
static int fits(const fvv_background *b) {
  int all = b->part_count <= UINT32_MAX && b->picture_count <= UINT32_MAX && b->light_count <= UINT32_MAX;
  for (size_t i = 0; i < b->part_count; i++) all = all && b->parts[i].mesh_size <= UINT32_MAX;
  for (size_t i = 0; i < b->picture_count; i++) all = all && b->pictures[i].size <= UINT32_MAX;
  return all;
}

/* The rules, without the limits of whoever will read. */
static fvv_status judge(const fvv_bytes *payload, const fvv_allocator *allocator,
                        fvv_diagnostic *diagnostic) {
  fvv_background again;
  fvv_limits limits = fvv_limits_or_default(NULL);
  limits.max_background = limits.max_vertices = limits.max_faces = limits.max_dimension = UINT32_MAX;
  const fvv_status status =
      fvv_background_decode(payload->data, payload->size, &limits, allocator, &again, diagnostic);
  if (status == FVV_OK) fvv_background_free(&again);
  return status;
}

fvv_status fvv_background_encode(const fvv_background *background, const fvv_allocator *allocator,
                                 fvv_bytes *payload, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator memory = fvv_allocator_or_default(allocator);
  if (!payload->allocator.resize) payload->allocator = memory;
  payload->size = 0;
  if (!fits(background))
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_BACKGROUND_PAYLOAD, FVV_CHUNK_BACKGROUND, 0,
                    "a mesh or picture of 4 GiB or more does not fit in a background");
  fvv_status status = write(background, payload);
  if (status == FVV_ERROR_MEMORY)
    return fvv_fail(diagnostic, status, 0, FVV_CHUNK_BACKGROUND, 0, "no memory to encode the background");
  status = judge(payload, &memory, diagnostic);
  if (status == FVV_OK) return status;
  payload->size = 0;
  if (status == FVV_ERROR_MEMORY) return status;
  if (diagnostic) diagnostic->status = FVV_ERROR_INPUT;
  return FVV_ERROR_INPUT;
}
