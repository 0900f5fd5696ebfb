#include "container/index.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

static void put_entry(uint8_t *p, const fvv_index_entry *entry) {
  const fvv_group_info *group = &entry->group;
  fvv_put_u64(p + FVV_INDX_ENTRY_OFFSET, group->offset);
  fvv_put_u64(p + FVV_INDX_ENTRY_GROUP_SIZE, group->size);
  fvv_put_i64(p + FVV_INDX_ENTRY_START, group->start);
  fvv_put_i64(p + FVV_INDX_ENTRY_END, group->end);
  fvv_put_u32(p + FVV_INDX_ENTRY_SEQUENCE, group->sequence);
  fvv_put_u32(p + FVV_INDX_ENTRY_FRAME_COUNT, group->frame_count);
  fvv_put_u32(p + FVV_INDX_ENTRY_CHAIN_CRC, entry->chain_crc);
  fvv_put_u32(p + FVV_INDX_ENTRY_END_SIZE, entry->end_size);
  fvv_put_u64(p + FVV_INDX_ENTRY_CONFIGURATION_OFFSET, group->configuration_offset);
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
  group->configuration_offset = fvv_get_u64(p + FVV_INDX_ENTRY_CONFIGURATION_OFFSET);
  group->intact = 1;
  entry->chain_crc = fvv_get_u32(p + FVV_INDX_ENTRY_CHAIN_CRC);
  entry->end_size = fvv_get_u32(p + FVV_INDX_ENTRY_END_SIZE);
}

fvv_status fvv_index_encode(const fvv_index_entry *entries, size_t count, fvv_bytes *out) {
  uint8_t fixed[FVV_INDX_SIZE] = {0};
  fvv_put_u32(fixed + FVV_INDX_GROUP_COUNT, (uint32_t)count);
  out->size = 0;
  fvv_status status = fvv_bytes_append(out, fixed, sizeof fixed);
  for (size_t i = 0; i < count && status == FVV_OK; i++) {
    uint8_t bytes[FVV_INDX_ENTRY_SIZE];
    put_entry(bytes, &entries[i]);
    status = fvv_bytes_append(out, bytes, sizeof bytes);
  }
  return status;
}

static fvv_status bad_index(fvv_diagnostic *diagnostic, size_t offset, const char *what) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_INDEX, FVV_CHUNK_INDEX, offset, "%s", what);
}

fvv_status fvv_index_decode(const uint8_t *payload, size_t size, uint64_t index_offset,
                            const fvv_limits *limits, fvv_bytes *entries, fvv_diagnostic *diagnostic) {
  if (size < FVV_INDX_SIZE || (size - FVV_INDX_SIZE) % FVV_INDX_ENTRY_SIZE)
    return bad_index(diagnostic, 0, "payload is no whole number of entries");
  const size_t count = (size - FVV_INDX_SIZE) / FVV_INDX_ENTRY_SIZE;
  if (fvv_get_u32(payload + FVV_INDX_GROUP_COUNT) != count || fvv_get_u32(payload + FVV_INDX_RESERVED))
    return bad_index(diagnostic, 0, "count does not fit the payload");
  if (count > limits->max_groups)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_INDEX, 0, "%zu groups, limit %u",
                    count, limits->max_groups);
  entries->size = 0;
  uint64_t least = FVV_FILE_HEADER_SIZE;
  int64_t last_end = INT64_MIN;
  uint32_t last_sequence = 0;
  for (size_t i = 0; i < count; i++) {
    const size_t at = FVV_INDX_SIZE + i * FVV_INDX_ENTRY_SIZE;
    fvv_index_entry entry;
    get_entry(payload + at, &entry);
    const fvv_group_info *group = &entry.group;
    const uint64_t smallest = fvv_chunk_extent(FVV_GRUP_SIZE) + entry.end_size;
    if (group->offset < least || group->offset > index_offset || group->size > index_offset - group->offset ||
        group->size < smallest || entry.end_size < fvv_chunk_extent(FVV_GEND_SIZE) ||
        (group->offset | group->size | entry.end_size | group->configuration_offset) & 7)
      return bad_index(diagnostic, at, "entry points outside the stream or into another group");
    if (group->configuration_offset < FVV_FILE_HEADER_SIZE || group->configuration_offset >= group->offset)
      return bad_index(diagnostic, at + FVV_INDX_ENTRY_CONFIGURATION_OFFSET, "configuration is not in front");
    if (i && group->sequence <= last_sequence)
      return bad_index(diagnostic, at + FVV_INDX_ENTRY_SEQUENCE, "sequence numbers do not rise");
    if (group->start >= group->end || group->start < last_end)
      return bad_index(diagnostic, at + FVV_INDX_ENTRY_START, "times of groups are not in order");
    least = group->offset + group->size;
    last_end = group->end;
    last_sequence = group->sequence;
    const fvv_status status = fvv_bytes_append(entries, &entry, sizeof entry);
    if (status < 0) return status;
  }
  return FVV_OK;
}
