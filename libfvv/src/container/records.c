/* The payloads that the container itself has to understand: SCEN, TRAK, INDX and GEND. */
#include "container/records.h"

#include <math.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/text.h"
#include "fvv/container.h"

static fvv_status scene_check(const fvv_scene *scene, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint32_t type = FVV_CHUNK_SCENE;
  if (scene->flags & ~FVV_SCENE_SCALE_UNKNOWN)
    return fvv_fail(diagnostic, status, FVV_ISSUE_SCENE_PAYLOAD, type, FVV_SCEN_FLAGS,
                    "scene flags are 0x%02x, expected 0 or 1", scene->flags);
  if (!scene->time_base.numerator || !scene->time_base.denominator)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TIME_BASE, type, FVV_SCEN_TIME_BASE_NUMERATOR,
                    "time base is %u/%u seconds per tick, expected two positive numbers",
                    scene->time_base.numerator, scene->time_base.denominator);
  if (scene->frame_duration <= 0)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TIME_BASE, type, FVV_SCEN_FRAME_DURATION,
                    "frame duration is %lld ticks, expected a positive number",
                    (long long)scene->frame_duration);
  if (!(scene->lattice_step > 0) || !isfinite(scene->lattice_step))
    return fvv_fail(diagnostic, status, FVV_ISSUE_LATTICE, type, FVV_SCEN_LATTICE_STEP,
                    "lattice step is %g, expected a positive number of metres", scene->lattice_step);
  for (int i = 0; i < 3; i++)
    if (!isfinite(fabs(scene->lattice_origin[i]) + scene->lattice_step * FVV_LATTICE_MAX))
      return fvv_fail(diagnostic, status, FVV_ISSUE_LATTICE, type,
                      (uint64_t)(FVV_SCEN_LATTICE_ORIGIN + 8 * i),
                      "lattice with origin %g and step %g exceeds the range of a double",
                      scene->lattice_origin[i], scene->lattice_step);
  if (scene->up_axis > FVV_UP_MINUS_Z)
    return fvv_fail(diagnostic, status, FVV_ISSUE_UP_AXIS, type, FVV_SCEN_UP_AXIS,
                    "up axis is %u, expected 0 to %d", scene->up_axis, FVV_UP_MINUS_Z);
  return FVV_OK;
}

fvv_status fvv_scene_encode(const fvv_scene *scene, uint8_t *out, size_t capacity, size_t *written,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_status status = scene_check(scene, FVV_ERROR_ARGUMENT, diagnostic);
  if (status < 0) return status;
  *written = FVV_SCEN_SIZE;
  if (capacity < FVV_SCEN_SIZE) return FVV_ERROR_BUFFER_TOO_SMALL;
  memset(out, 0, FVV_SCEN_SIZE);
  fvv_put_u32(out + FVV_SCEN_TIME_BASE_NUMERATOR, scene->time_base.numerator);
  fvv_put_u32(out + FVV_SCEN_TIME_BASE_DENOMINATOR, scene->time_base.denominator);
  fvv_put_i64(out + FVV_SCEN_FRAME_DURATION, scene->frame_duration);
  for (int i = 0; i < 3; i++) fvv_put_f64(out + FVV_SCEN_LATTICE_ORIGIN + 8 * i, scene->lattice_origin[i]);
  fvv_put_f64(out + FVV_SCEN_LATTICE_STEP, scene->lattice_step);
  out[FVV_SCEN_UP_AXIS] = scene->up_axis;
  out[FVV_SCEN_FLAGS] = scene->flags;
  return FVV_OK;
}

fvv_status fvv_scene_decode(fvv_scene *scene, const uint8_t *payload, size_t size,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(scene, 0, sizeof *scene);
  if (size != FVV_SCEN_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SCENE_PAYLOAD, FVV_CHUNK_SCENE, 0,
                    "payload of %zu bytes, expected %d", size, FVV_SCEN_SIZE);
  if (!fvv_all_zero(payload + FVV_SCEN_RESERVED, FVV_SCEN_SIZE - FVV_SCEN_RESERVED))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SCENE_PAYLOAD, FVV_CHUNK_SCENE,
                    FVV_SCEN_RESERVED, "reserved bytes are not 0");
  scene->time_base.numerator = fvv_get_u32(payload + FVV_SCEN_TIME_BASE_NUMERATOR);
  scene->time_base.denominator = fvv_get_u32(payload + FVV_SCEN_TIME_BASE_DENOMINATOR);
  scene->frame_duration = fvv_get_i64(payload + FVV_SCEN_FRAME_DURATION);
  for (int i = 0; i < 3; i++)
    scene->lattice_origin[i] = fvv_get_f64(payload + FVV_SCEN_LATTICE_ORIGIN + 8 * i);
  scene->lattice_step = fvv_get_f64(payload + FVV_SCEN_LATTICE_STEP);
  scene->up_axis = payload[FVV_SCEN_UP_AXIS];
  scene->flags = payload[FVV_SCEN_FLAGS];
  return scene_check(scene, FVV_ERROR_INVALID, diagnostic);
}

/* The flags that a kind decides; *required are those that are set. Others are free on data and unknown kinds.
 */
static uint8_t decided_flags(uint8_t kind, uint8_t *required) {
  *required = kind == FVV_TRACK_MESH || kind == FVV_TRACK_VIDEO ? FVV_TRACK_FLAG_FRAMES : 0;
  const int known = kind <= FVV_TRACK_COLOURS && kind != FVV_TRACK_DATA;
  return known ? FVV_TRACK_FLAG_FRAMES : 0;
}

/* Which kinds may count in ticks of their own: those whose payloads have times. */
static fvv_status track_check(const fvv_track *track, fvv_status status, fvv_diagnostic *diagnostic) {
  uint8_t required;
  const uint8_t decided = decided_flags(track->kind, &required);
  if ((track->flags & decided) != required)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TRACK_FRAMES, FVV_CHUNK_TRACK, FVV_TRAK_FLAGS,
                    "flags of a track of kind %u are 0x%02x, expected 0x%02x", track->kind, track->flags,
                    required);
  const fvv_rational base = track->time_base;
  const int free = (track->kind > FVV_TRACK_ENVIRONMENT && track->kind != FVV_TRACK_COLOURS);
  if (!base.numerator != !base.denominator || (base.numerator && !free))
    return fvv_fail(diagnostic, status, FVV_ISSUE_TRACK_TIME_BASE, FVV_CHUNK_TRACK,
                    FVV_TRAK_TIME_BASE_NUMERATOR, "time base is %u/%u, expected %s", base.numerator,
                    base.denominator, free ? "0/0 or two positive numbers" : "0/0, that of the scene");
  if (track->rank && !track->alternate_group)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TRACK_ALTERNATE, FVV_CHUNK_TRACK, FVV_TRAK_RANK,
                    "rank is %u without an alternate group, expected 0", track->rank);
  return FVV_OK;
}

fvv_status fvv_track_encode(const fvv_track *track, uint8_t *out, size_t capacity, size_t *written,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (!track->id || !track->kind || track->name_size > UINT16_MAX ||
      !fvv_text_valid((const uint8_t *)track->name, track->name_size, NULL))
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, FVV_CHUNK_TRACK, 0,
                    "a track needs an id, a kind and a UTF-8 name of at most 65535 bytes");
  fvv_track declared = *track;
  uint8_t required;
  decided_flags(track->kind, &required);
  declared.flags |= required;
  if (declared.flags & ~FVV_TRACK_FLAG_FRAMES)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, FVV_ISSUE_TRACK_PAYLOAD, FVV_CHUNK_TRACK, FVV_TRAK_FLAGS,
                    "track flags are 0x%02x, expected 0 or 1", track->flags);
  const fvv_status status = track_check(&declared, FVV_ERROR_ARGUMENT, diagnostic);
  if (status < 0) return status;
  *written = FVV_TRAK_SIZE + track->name_size;
  if (capacity < *written) return FVV_ERROR_BUFFER_TOO_SMALL;
  memset(out, 0, FVV_TRAK_SIZE);
  out[FVV_TRAK_KIND] = track->kind;
  out[FVV_TRAK_FLAGS] = declared.flags;
  fvv_put_u16(out + FVV_TRAK_NAME_SIZE, (uint16_t)track->name_size);
  fvv_put_u32(out + FVV_TRAK_TIME_BASE_NUMERATOR, track->time_base.numerator);
  fvv_put_u32(out + FVV_TRAK_TIME_BASE_DENOMINATOR, track->time_base.denominator);
  fvv_put_u16(out + FVV_TRAK_ALTERNATE_GROUP, track->alternate_group);
  fvv_put_u16(out + FVV_TRAK_RANK, track->rank);
  fvv_put_u32(out + FVV_TRAK_BIT_RATE, track->bit_rate);
  fvv_put_u32(out + FVV_TRAK_NOMINAL_SIZE, track->size);
  if (track->name_size) memcpy(out + FVV_TRAK_SIZE, track->name, track->name_size);
  return FVV_OK;
}

fvv_status fvv_track_decode(fvv_track *track, const uint8_t *payload, size_t size, const fvv_limits *limits,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(track, 0, sizeof *track);
  if (size < FVV_TRAK_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_PAYLOAD, FVV_CHUNK_TRACK, 0,
                    "payload of %zu bytes, expected at least %d", size, FVV_TRAK_SIZE);
  track->flags = payload[FVV_TRAK_FLAGS];
  if (track->flags & ~FVV_TRACK_FLAG_FRAMES)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_PAYLOAD, FVV_CHUNK_TRACK, FVV_TRAK_FLAGS,
                    "track flags are 0x%02x, expected 0 or 1", track->flags);
  track->time_base.numerator = fvv_get_u32(payload + FVV_TRAK_TIME_BASE_NUMERATOR);
  track->time_base.denominator = fvv_get_u32(payload + FVV_TRAK_TIME_BASE_DENOMINATOR);
  track->alternate_group = fvv_get_u16(payload + FVV_TRAK_ALTERNATE_GROUP);
  track->rank = fvv_get_u16(payload + FVV_TRAK_RANK);
  track->bit_rate = fvv_get_u32(payload + FVV_TRAK_BIT_RATE);
  track->size = fvv_get_u32(payload + FVV_TRAK_NOMINAL_SIZE);
  track->kind = payload[FVV_TRAK_KIND];
  track->name_size = fvv_get_u16(payload + FVV_TRAK_NAME_SIZE);
  track->name = (const char *)payload + FVV_TRAK_SIZE;
  if (size != FVV_TRAK_SIZE + track->name_size)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_PAYLOAD, FVV_CHUNK_TRACK,
                    FVV_TRAK_NAME_SIZE, "payload of %zu bytes, expected %zu for a name of %zu", size,
                    FVV_TRAK_SIZE + track->name_size, track->name_size);
  if (!track->kind)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_KIND, FVV_CHUNK_TRACK, FVV_TRAK_KIND,
                    "track kind is 0");
  const fvv_limits limit = fvv_limits_or_default(limits);
  if (track->name_size > limit.max_text)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_TRACK, FVV_TRAK_NAME_SIZE,
                    "name of %zu bytes, limit %u", track->name_size, limit.max_text);
  const fvv_status status = track_check(track, FVV_ERROR_INVALID, diagnostic);
  if (status < 0) return status;
  return fvv_text_check(track->name, track->name_size, "track name", FVV_ERROR_INVALID, FVV_CHUNK_TRACK,
                        FVV_TRAK_SIZE, diagnostic);
}

uint64_t fvv_payload_limit(const fvv_limits *limits, uint32_t type) {
  const uint64_t index =
      FVV_INDX_SIZE + (uint64_t)(FVV_INDX_BLOCK_SIZE + FVV_INDX_ENTRY_SIZE) * limits->max_groups;
  return type == FVV_CHUNK_INDEX && index > limits->max_payload ? index : limits->max_payload;
}

static void put_entry(uint8_t *p, const fvv_index_entry *entry, uint32_t block) {
  const fvv_group_info *group = &entry->group;
  fvv_put_u64(p + FVV_INDX_ENTRY_OFFSET, group->offset);
  fvv_put_u64(p + FVV_INDX_ENTRY_GROUP_SIZE, group->size);
  fvv_put_i64(p + FVV_INDX_ENTRY_START, group->start);
  fvv_put_i64(p + FVV_INDX_ENTRY_END, group->end);
  fvv_put_u32(p + FVV_INDX_ENTRY_SEQUENCE, group->sequence);
  fvv_put_u32(p + FVV_INDX_ENTRY_FRAME_COUNT, group->frame_count);
  fvv_put_u32(p + FVV_INDX_ENTRY_CHAIN_CRC, entry->chain_crc);
  fvv_put_u32(p + FVV_INDX_ENTRY_END_SIZE, entry->end_size);
  fvv_put_u32(p + FVV_INDX_ENTRY_BLOCK, block);
}

static void get_entry(const uint8_t *p, fvv_index_entry *entry) {
  memset(entry, 0, sizeof *entry);
  fvv_group_info *group = &entry->group;
  group->offset = fvv_get_u64(p + FVV_INDX_ENTRY_OFFSET);
  group->size = fvv_get_u64(p + FVV_INDX_ENTRY_GROUP_SIZE);
  group->start = fvv_get_i64(p + FVV_INDX_ENTRY_START);
  group->end = fvv_get_i64(p + FVV_INDX_ENTRY_END);
  group->sequence = fvv_get_u32(p + FVV_INDX_ENTRY_SEQUENCE);
  group->frame_count = fvv_get_u32(p + FVV_INDX_ENTRY_FRAME_COUNT);
  group->intact = 1;
  entry->chain_crc = fvv_get_u32(p + FVV_INDX_ENTRY_CHAIN_CRC);
  entry->end_size = fvv_get_u32(p + FVV_INDX_ENTRY_END_SIZE);
}

fvv_status fvv_index_encode(const fvv_bytes *entries, const fvv_bytes *blocks, fvv_bytes *out) {
  const fvv_index_entry *entry = (const fvv_index_entry *)entries->data;
  const fvv_index_block *block = (const fvv_index_block *)blocks->data;
  const size_t count = entries->size / sizeof *entry, block_count = blocks->size / sizeof *block;
  out->size = 0;
  const fvv_status status =
      fvv_bytes_reserve(out, FVV_INDX_SIZE + block_count * FVV_INDX_BLOCK_SIZE + count * FVV_INDX_ENTRY_SIZE);
  if (status != FVV_OK) return status;
  uint8_t *p = out->data;
  fvv_put_u32(p + FVV_INDX_GROUP_COUNT, (uint32_t)count);
  fvv_put_u32(p + FVV_INDX_BLOCK_COUNT, (uint32_t)block_count);
  p += FVV_INDX_SIZE;
  for (size_t i = 0; i < block_count; i++, p += FVV_INDX_BLOCK_SIZE) {
    fvv_put_u64(p + FVV_INDX_BLOCK_OFFSET, block[i].offset);
    fvv_put_u32(p + FVV_INDX_BLOCK_BLOCK_SIZE, block[i].size);
    fvv_put_u32(p + FVV_INDX_BLOCK_DIGEST, block[i].digest);
  }
  uint32_t number = 0;
  for (size_t i = 0; i < count; i++, p += FVV_INDX_ENTRY_SIZE) {
    while (number + 1 < block_count && block[number + 1].offset <= entry[i].group.configuration_offset)
      number++;
    put_entry(p, &entry[i], number);
  }
  out->size = (size_t)(p - out->data);
  return FVV_OK;
}

static fvv_status bad_index(fvv_diagnostic *diagnostic, size_t offset, const char *what) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_INDEX, FVV_CHUNK_INDEX, offset, "%s", what);
}

typedef struct index_reading {
  const uint8_t *payload;
  size_t count, block_count;
  uint64_t index_offset;
  uint64_t least; /* end of the group before */
  int64_t last_end;
  uint32_t last_sequence;
  size_t blocks; /* that groups have named so far */
} index_reading;

/* The block of entry i, which the group before has or which lies directly before its own first group. */
static fvv_status find_block(index_reading *r, size_t at, fvv_group_info *group, fvv_bytes *blocks,
                             fvv_diagnostic *diagnostic) {
  const size_t number = fvv_get_u32(r->payload + at + FVV_INDX_ENTRY_BLOCK);
  fvv_index_block block;
  if (r->blocks && number == r->blocks - 1) {
    block = ((const fvv_index_block *)blocks->data)[number];
  } else {
    if (number != r->blocks || number >= r->block_count)
      return bad_index(diagnostic, at + FVV_INDX_ENTRY_BLOCK, "configuration blocks are not in rising order");
    const size_t place = FVV_INDX_SIZE + number * FVV_INDX_BLOCK_SIZE;
    const uint8_t *p = r->payload + place;
    block.offset = fvv_get_u64(p + FVV_INDX_BLOCK_OFFSET);
    block.size = fvv_get_u32(p + FVV_INDX_BLOCK_BLOCK_SIZE);
    block.digest = fvv_get_u32(p + FVV_INDX_BLOCK_DIGEST);
    if (block.offset < r->least || (block.offset | block.size) & 7 ||
        block.size < fvv_chunk_extent(FVV_SCEN_SIZE) || group->offset < block.size ||
        block.offset != group->offset - block.size)
      return bad_index(diagnostic, place, "configuration block is not directly before its first group");
    r->blocks++;
    const fvv_status status = fvv_bytes_append(blocks, &block, sizeof block);
    if (status < 0) return status;
  }
  group->configuration_offset = block.offset;
  group->configuration_size = block.size;
  return FVV_OK;
}

static fvv_status read_entry(index_reading *r, size_t at, fvv_index_entry *entry, fvv_bytes *blocks,
                             fvv_diagnostic *diagnostic) {
  get_entry(r->payload + at, entry);
  fvv_group_info *group = &entry->group;
  const uint64_t smallest = fvv_chunk_extent(FVV_GRUP_SIZE) + entry->end_size;
  if (group->offset < r->least || group->offset > r->index_offset ||
      group->size > r->index_offset - group->offset || group->size < smallest ||
      entry->end_size < fvv_chunk_extent(FVV_GEND_SIZE) ||
      (group->offset | group->size | entry->end_size) & 7)
    return bad_index(diagnostic, at, "entry lies outside the stream or overlaps another group");
  if (r->last_end != INT64_MIN && group->sequence <= r->last_sequence)
    return bad_index(diagnostic, at + FVV_INDX_ENTRY_SEQUENCE, "sequence numbers are not in rising order");
  if (group->start >= group->end || group->start < r->last_end)
    return bad_index(diagnostic, at + FVV_INDX_ENTRY_START, "times of groups are not in order");
  const fvv_status status = find_block(r, at, group, blocks, diagnostic);
  r->least = group->offset + group->size;
  r->last_end = group->end;
  r->last_sequence = group->sequence;
  return status;
}

fvv_status fvv_index_decode(const uint8_t *payload, size_t size, uint64_t index_offset,
                            const fvv_limits *limits, fvv_bytes *entries, fvv_bytes *blocks,
                            fvv_diagnostic *diagnostic) {
  if (size < FVV_INDX_SIZE) return bad_index(diagnostic, 0, "payload ends inside its header");
  index_reading r = {payload, 0, 0, index_offset, FVV_FILE_HEADER_SIZE, INT64_MIN, 0, 0};
  r.count = fvv_get_u32(payload + FVV_INDX_GROUP_COUNT);
  r.block_count = fvv_get_u32(payload + FVV_INDX_BLOCK_COUNT);
  if (r.count > limits->max_groups)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_INDEX, 0, "%zu groups, limit %u",
                    r.count, limits->max_groups);
  if (size <
      FVV_INDX_SIZE + (uint64_t)r.block_count * FVV_INDX_BLOCK_SIZE + (uint64_t)r.count * FVV_INDX_ENTRY_SIZE)
    return bad_index(diagnostic, 0, "counts do not fit the payload");
  entries->size = blocks->size = 0;
  fvv_status status = r.count > SIZE_MAX / sizeof(fvv_index_entry)
                          ? FVV_ERROR_MEMORY
                          : fvv_bytes_reserve(entries, r.count * sizeof(fvv_index_entry));
  size_t at = FVV_INDX_SIZE + r.block_count * FVV_INDX_BLOCK_SIZE;
  for (size_t i = 0; i < r.count && status == FVV_OK; i++, at += FVV_INDX_ENTRY_SIZE) {
    fvv_index_entry entry;
    status = read_entry(&r, at, &entry, blocks, diagnostic);
    if (status == FVV_OK) status = fvv_bytes_append(entries, &entry, sizeof entry);
  }
  if (status == FVV_OK && r.blocks != r.block_count)
    return bad_index(diagnostic, 0, "a configuration block has no group");
  return status;
}

void fvv_group_table_init(fvv_group_table *table, const fvv_allocator *allocator) {
  memset(table, 0, sizeof *table);
  table->kinds.allocator = table->entries.allocator = *allocator;
}

void fvv_group_table_free(fvv_group_table *table) {
  fvv_bytes_free(&table->kinds);
  fvv_bytes_free(&table->entries);
}

void fvv_group_table_begin(fvv_group_table *table, const fvv_chunk_header *group, uint32_t sequence) {
  table->sequence = sequence;
  table->chunk_count = 1;
  table->chain_crc = fvv_header_chain(0, group);
  table->frame_count = 0;
  table->kind_count = table->last_kind = 0;
  table->last_time = group->time;
  table->kinds.size = table->entries.size = 0;
}

static void put_kind(uint8_t row[FVV_GEND_KIND_SIZE], const fvv_chunk_header *header) {
  memset(row, 0, FVV_GEND_KIND_SIZE);
  fvv_put_u32(row + FVV_GEND_KIND_TYPE, header->type);
  fvv_put_u16(row + FVV_GEND_KIND_TRACK, header->track);
  row[FVV_GEND_KIND_FLAGS] = header->flags;
}

/* The number of a row; kind_count: it is not there. Frames repeat the same kinds in the same order, so the
 * row after the last one used is tried first. */
static uint32_t find_kind(const fvv_group_table *table, const uint8_t row[FVV_GEND_KIND_SIZE]) {
  for (uint32_t i = 0; i < table->kind_count; i++) {
    const uint32_t kind = (table->last_kind + 1 + i) % table->kind_count;
    if (!memcmp(table->kinds.data + kind * FVV_GEND_KIND_SIZE, row, FVV_GEND_KIND_SIZE)) return kind;
  }
  return table->kind_count;
}

int fvv_group_table_has_room(const fvv_group_table *table, const fvv_chunk_header *header) {
  uint8_t row[FVV_GEND_KIND_SIZE];
  if (table->kind_count < FVV_MAX_GROUP_KINDS) return 1;
  put_kind(row, header);
  return find_kind(table, row) < table->kind_count;
}

static fvv_status kind_of(fvv_group_table *table, const fvv_chunk_header *header, uint32_t *kind) {
  uint8_t row[FVV_GEND_KIND_SIZE];
  put_kind(row, header);
  *kind = find_kind(table, row);
  if (*kind < table->kind_count) return FVV_OK;
  if (table->kind_count == FVV_MAX_GROUP_KINDS) return FVV_ERROR_LIMIT;
  const fvv_status status = fvv_bytes_append(&table->kinds, row, sizeof row);
  if (status == FVV_OK) table->kind_count++;
  return status;
}

fvv_status fvv_group_table_add(fvv_group_table *table, const fvv_chunk_header *header, int makes_frame) {
  uint32_t kind = 0;
  fvv_status status = kind_of(table, header, &kind);
  if (status < 0) return status;
  uint8_t entry[30];
  size_t size = fvv_put_uleb(entry, kind);
  size += fvv_put_uleb(entry + size, header->size);
  /* Modulo 2^64: a hostile stream may have times at both ends of the range. */
  const uint64_t delta = (uint64_t)header->time - (uint64_t)table->last_time;
  int64_t signed_delta;
  memcpy(&signed_delta, &delta, sizeof delta);
  size += fvv_put_uleb(entry + size, fvv_zigzag(signed_delta));
  status = fvv_bytes_append(&table->entries, entry, size);
  if (status < 0) return status;
  if (makes_frame && (!table->frame_count || header->time != table->frame_time)) {
    table->frame_count++;
    table->frame_time = header->time;
  }
  table->last_kind = kind;
  table->last_time = header->time;
  table->chain_crc = fvv_header_chain(table->chain_crc, header);
  table->chunk_count++;
  return FVV_OK;
}

fvv_status fvv_group_table_encode(const fvv_group_table *table, fvv_bytes *out) {
  uint8_t fixed[FVV_GEND_SIZE];
  fvv_put_u32(fixed + FVV_GEND_SEQUENCE, table->sequence);
  fvv_put_u32(fixed + FVV_GEND_CHUNK_COUNT, table->chunk_count);
  fvv_put_u32(fixed + FVV_GEND_CHAIN_CRC, table->chain_crc);
  fvv_put_u32(fixed + FVV_GEND_FRAME_COUNT, table->frame_count);
  fvv_put_u32(fixed + FVV_GEND_KIND_COUNT, table->kind_count);
  fvv_put_u32(fixed + FVV_GEND_TABLE_SIZE, (uint32_t)table->entries.size);
  out->size = 0;
  fvv_status status = fvv_bytes_append(out, fixed, sizeof fixed);
  if (status == FVV_OK) status = fvv_bytes_append(out, table->kinds.data, table->kinds.size);
  if (status == FVV_OK) status = fvv_bytes_append(out, table->entries.data, table->entries.size);
  return status;
}

static fvv_status bad_table(fvv_diagnostic *diagnostic, size_t offset, const char *what) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_GROUP_TABLE, FVV_CHUNK_GROUP_END, offset, "%s",
                  what);
}

fvv_status fvv_group_table_decode(const uint8_t *payload, size_t size, uint64_t group_offset,
                                  int64_t group_start, uint64_t chunks_size, const fvv_limits *limits,
                                  fvv_bytes *out, fvv_diagnostic *diagnostic) {
  if (size < FVV_GEND_SIZE) return bad_table(diagnostic, 0, "payload is shorter than its fixed part");
  const uint32_t chunks = fvv_get_u32(payload + FVV_GEND_CHUNK_COUNT);
  const uint32_t kinds = fvv_get_u32(payload + FVV_GEND_KIND_COUNT);
  const uint32_t table_size = fvv_get_u32(payload + FVV_GEND_TABLE_SIZE);
  if (!chunks) return bad_table(diagnostic, FVV_GEND_CHUNK_COUNT, "a group has at least its GRUP chunk");
  if (kinds > FVV_MAX_GROUP_KINDS || chunks > limits->max_group_chunks)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_GROUP_END, FVV_GEND_CHUNK_COUNT,
                    "%u chunks of %u kinds, limits %u and %d", chunks, kinds, limits->max_group_chunks,
                    FVV_MAX_GROUP_KINDS);
  if (size != FVV_GEND_SIZE + (uint64_t)kinds * FVV_GEND_KIND_SIZE + table_size)
    return bad_table(diagnostic, FVV_GEND_KIND_COUNT, "payload size does not match the counts");
  /* Every entry has at least three bytes: the count is bounded by what is there before memory is allocated.
   */
  if ((uint64_t)(chunks - 1) * 3 > table_size)
    return bad_table(diagnostic, FVV_GEND_CHUNK_COUNT, "table is too short for its chunk count");
  out->size = 0;
  fvv_status status = fvv_bytes_reserve(out, (chunks - 1) * sizeof(fvv_chunk_info));
  if (status < 0) return status;
  const uint8_t *rows = payload + FVV_GEND_SIZE;
  fvv_cursor cursor = {payload, size, FVV_GEND_SIZE + (size_t)kinds * FVV_GEND_KIND_SIZE, 0};
  uint64_t offset = fvv_chunk_extent(FVV_GRUP_SIZE), time = (uint64_t)group_start;
  for (uint32_t i = 1; i < chunks; i++) {
    const uint64_t kind = fvv_cursor_uleb(&cursor), payload_size = fvv_cursor_uleb(&cursor);
    time += (uint64_t)fvv_unzigzag(fvv_cursor_uleb(&cursor));
    if (cursor.failed || kind >= kinds) return bad_table(diagnostic, cursor.position, "entry is malformed");
    if (payload_size > chunks_size || fvv_chunk_extent(payload_size) > chunks_size - offset)
      return bad_table(diagnostic, cursor.position, "entry ends beyond the group");
    const uint8_t *row = rows + kind * FVV_GEND_KIND_SIZE;
    fvv_chunk_info info;
    memset(&info, 0, sizeof info);
    info.offset = group_offset + offset;
    info.size = payload_size;
    memcpy(&info.time, &time, sizeof time);
    info.type = fvv_get_u32(row + FVV_GEND_KIND_TYPE);
    info.track = fvv_get_u16(row + FVV_GEND_KIND_TRACK);
    info.flags = row[FVV_GEND_KIND_FLAGS];
    status = fvv_bytes_append(out, &info, sizeof info);
    if (status < 0) return status;
    offset += fvv_chunk_extent(payload_size);
  }
  if (cursor.position != size || offset != chunks_size)
    return bad_table(diagnostic, cursor.position, "table does not match the size of the group");
  return FVV_OK;
}
