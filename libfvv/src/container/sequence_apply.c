/* What an accepted chunk changes; the rules themselves are in sequence.c. */
#include "container/sequence.h"

#include "base/bytes.h"

static fvv_status begin_block(fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset) {
  fvv_scene scene;
  if (!s->scene_seen && fvv_scene_decode(&scene, payload, (size_t)header->size, NULL) == FVV_OK) {
    s->scene = scene;
    s->scene_seen = 1;
  }
  s->in_block = 1;
  s->in_group = s->suspect = s->block_has_more = 0;
  s->configuration = FVV_CONFIGURATION_GOOD;
  s->configuration_crc = 0;
  s->configuration_offset = offset;
  s->tracks.size = 0;
  return FVV_OK;
}

static void begin_group(fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                        uint64_t offset) {
  /* Every header of the block is in the digest, and every payload's CRC in its header. */
  if (s->configuration == FVV_CONFIGURATION_LOST && s->configuration_offset &&
      fvv_get_u32(payload + FVV_GRUP_CONFIGURATION_CRC) == s->configuration_crc)
    s->configuration = FVV_CONFIGURATION_GOOD;
  s->in_block = 0;
  s->in_group = 1;
  s->suspect = s->joining = 0;
  s->group_offset = offset;
  s->group_start = fvv_get_i64(payload + FVV_GRUP_START);
  s->group_end = fvv_get_i64(payload + FVV_GRUP_END);
  const uint32_t number = fvv_get_u32(payload + FVV_GRUP_SEQUENCE);
  s->next_sequence = number + 1;
  fvv_group_table_begin(&s->table, header, number);
  fvv_sequence_track *tracks = (fvv_sequence_track *)s->tracks.data;
  for (size_t i = 0; i < s->tracks.size / sizeof *tracks; i++) tracks[i].seen = tracks[i].laid_out = 0;
}

static fvv_status end_group(fvv_sequence *s, const fvv_chunk_header *header, uint64_t offset) {
  s->in_group = 0;
  s->last_end = s->group_end;
  if (s->suspect) return FVV_OK;
  if (s->groups.size / sizeof(fvv_index_entry) >= s->limits.max_groups) return FVV_ERROR_LIMIT;
  fvv_index_entry entry;
  memset(&entry, 0, sizeof entry);
  entry.group.offset = s->group_offset;
  entry.end_size = (uint32_t)fvv_chunk_extent(header->size);
  entry.group.size = offset + entry.end_size - s->group_offset;
  entry.group.start = s->group_start;
  entry.group.end = s->group_end;
  entry.group.sequence = s->table.sequence;
  entry.group.frame_count = s->table.frame_count;
  entry.group.intact = fvv_sequence_group_intact(s);
  entry.group.configuration_offset = s->configuration_offset;
  entry.chain_crc = s->table.chain_crc;
  return fvv_bytes_append(&s->groups, &entry, sizeof entry);
}

static fvv_status add_frame_chunk(fvv_sequence *s, const fvv_chunk_header *header) {
  fvv_sequence_track *tracks = (fvv_sequence_track *)s->tracks.data;
  for (size_t i = 0; i < s->tracks.size / sizeof *tracks; i++)
    if (tracks[i].id == header->track && fvv_chunk_track_kind(header->type)) {
      if (header->type == FVV_CHUNK_GROUP_TILES)
        tracks[i].laid_out = 1;
      else
        tracks[i].seen = 1;
      tracks[i].last_time = header->time;
    }
  return fvv_group_table_add(&s->table, header);
}

fvv_status fvv_sequence_apply(fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset) {
  s->next_counter = (uint8_t)(header->counter + 1);
  fvv_status status = FVV_OK;
  switch (header->type) {
  case FVV_CHUNK_SCENE:
    status = begin_block(s, header, payload, offset);
    break;
  case FVV_CHUNK_GROUP:
    if (header->size == FVV_GRUP_SIZE) begin_group(s, header, payload, offset);
    return FVV_OK;
  case FVV_CHUNK_GROUP_END:
    return s->in_group ? end_group(s, header, offset) : FVV_OK;
  case FVV_CHUNK_INDEX:
    s->index_seen = 1;
    s->in_group = s->in_block = s->suspect = 0;
    s->index_offset = offset;
    s->index_crc = header->payload_crc;
    return FVV_OK;
  case FVV_CHUNK_FOOTER:
    s->footer_seen = 1;
    return FVV_OK;
  case FVV_CHUNK_TRACK:
    if (s->in_block && header->size >= FVV_TRAK_SIZE) {
      const fvv_sequence_track track = {header->track, payload[FVV_TRAK_KIND], 0, 0, 0};
      status = fvv_bytes_append(&s->tracks, &track, sizeof track);
    }
    break;
  default:
    break;
  }
  if (status < 0) return status;
  if (s->in_group) return add_frame_chunk(s, header);
  /* A frame without its GRUP: the block ended somewhere in what was lost. */
  if (fvv_chunk_place(header->type) == FVV_PLACE_FRAME) s->in_block = 0;
  if (s->in_block) {
    s->block_has_more |= header->type != FVV_CHUNK_SCENE && header->type != FVV_CHUNK_TRACK;
    s->configuration_crc = fvv_header_chain(s->configuration_crc, header);
  }
  return FVV_OK;
}

void fvv_sequence_lost(fvv_sequence *s) {
  s->suspect = s->gaps = 1;
  /* A block that is complete stays good; if a newer one was lost, the next group's digest tells. */
  if ((s->in_block && s->configuration == FVV_CONFIGURATION_GOOD) ||
      s->configuration == FVV_CONFIGURATION_NONE)
    s->configuration = FVV_CONFIGURATION_LOST;
}

void fvv_sequence_broken(fvv_sequence *s, const fvv_chunk_header *header) {
  s->suspect = 1;
  const fvv_place place = fvv_chunk_place(header->type);
  if ((s->in_block || s->configuration == FVV_CONFIGURATION_NONE) &&
      (place == FVV_PLACE_CONFIGURATION || place == FVV_PLACE_UNKNOWN))
    s->configuration = FVV_CONFIGURATION_BROKEN;
}

void fvv_sequence_abandon_group(fvv_sequence *s) {
  s->in_group = 0;
  s->gaps = 1;
}

int fvv_sequence_group_intact(const fvv_sequence *s) {
  return !s->suspect &&
         (s->configuration == FVV_CONFIGURATION_GOOD || s->configuration == FVV_CONFIGURATION_UNSEEN);
}

fvv_status fvv_sequence_index(const fvv_sequence *s, fvv_bytes *payload) {
  return fvv_index_encode((const fvv_index_entry *)s->groups.data, s->groups.size / sizeof(fvv_index_entry),
                          payload);
}

void fvv_footer_write(uint64_t index_offset, uint64_t file_size, uint32_t index_crc, uint8_t *payload) {
  memset(payload, 0, FVV_FOOT_SIZE);
  fvv_put_u64(payload + FVV_FOOT_INDEX_OFFSET, index_offset);
  fvv_put_u64(payload + FVV_FOOT_FILE_SIZE, file_size);
  fvv_put_u32(payload + FVV_FOOT_INDEX_CRC, index_crc);
}
