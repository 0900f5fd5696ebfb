/* The order of chunks: what is checked of each, and what changes when it is taken. */
#include "container/chunk_order.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/memory.h"

void fvv_chunk_order_init(fvv_chunk_order *order, const fvv_limits *limits, const fvv_allocator *allocator) {
  memset(order, 0, sizeof *order);
  order->limits = fvv_limits_or_default(limits);
  order->allocator = fvv_allocator_or_default(allocator);
  order->last_end = INT64_MIN;
  fvv_group_table_init(&order->table, &order->allocator);
  order->tracks.allocator = order->blocks.allocator = order->groups.allocator = order->scratch.allocator =
      order->allocator;
  for (size_t i = 0; i < FVV_KNOWN_BLOCKS; i++) order->known[i].tracks.allocator = order->allocator;
}

void fvv_chunk_order_free(fvv_chunk_order *order) {
  fvv_group_table_free(&order->table);
  fvv_bytes_free(&order->tracks);
  fvv_bytes_free(&order->blocks);
  fvv_bytes_free(&order->groups);
  fvv_bytes_free(&order->scratch);
  for (size_t i = 0; i < FVV_KNOWN_BLOCKS; i++) fvv_bytes_free(&order->known[i].tracks);
}

void fvv_chunk_order_inherit(fvv_chunk_order *order, fvv_chunk_order *former) {
  for (size_t i = 0; i < FVV_KNOWN_BLOCKS; i++) {
    const fvv_known_block mine = order->known[i];
    order->known[i] = former->known[i];
    former->known[i] = mine;
  }
  order->next_known = former->next_known;
}

static fvv_known_block *find_known(fvv_chunk_order *s, uint32_t digest) {
  for (size_t i = 0; i < FVV_KNOWN_BLOCKS; i++)
    if (s->known[i].used && s->known[i].digest == digest) return &s->known[i];
  return NULL;
}

/* Remembers the tracks of the block that holds. */
static fvv_status remember_block(fvv_chunk_order *s) {
  if (find_known(s, s->configuration_crc)) return FVV_OK;
  fvv_known_block *block = &s->known[s->next_known];
  s->next_known = (s->next_known + 1) % FVV_KNOWN_BLOCKS;
  block->used = 0;
  block->digest = s->configuration_crc;
  block->tracks.size = 0;
  const fvv_status status = fvv_bytes_append(&block->tracks, s->tracks.data, s->tracks.size);
  block->used = status == FVV_OK;
  return status;
}

/* The block with this digest holds, although it is not the last one. */
static fvv_status recall_block(fvv_chunk_order *s, const fvv_known_block *block) {
  s->configuration = FVV_CONFIGURATION_GOOD;
  s->configuration_crc = block->digest;
  s->tracks.size = 0;
  return fvv_bytes_append(&s->tracks, block->tracks.data, block->tracks.size);
}

uint8_t fvv_chunk_order_counter(const fvv_chunk_order *order, uint32_t type) {
  const int restarts = type == FVV_CHUNK_SCENE || type == FVV_CHUNK_GROUP || type == FVV_CHUNK_INDEX;
  return restarts ? 0 : order->next_counter;
}

static size_t track_count(const fvv_chunk_order *s) {
  return s->tracks.size / sizeof(fvv_chunk_order_track);
}

static fvv_chunk_order_track *track_of(const fvv_chunk_order *s, uint16_t id) {
  fvv_chunk_order_track *tracks = (fvv_chunk_order_track *)s->tracks.data;
  for (size_t i = 0; i < track_count(s); i++)
    if (tracks[i].id == id) return &tracks[i];
  return NULL;
}

/* Returns with the error of a broken rule; header is that of the chunk. */
#define BROKEN(issue, at, ...)                                                                               \
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_##issue, header->type, offset + (at), __VA_ARGS__)
/* The same, when the chunk is good and something before it is missing. */
#define MISSING(issue, at, ...)                                                                              \
  return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_##issue, header->type, offset + (at), __VA_ARGS__)
enum { IN_PAYLOAD = FVV_CHUNK_HEADER_SIZE };

static fvv_status check_place(const fvv_chunk_order *s, const fvv_chunk_header *header, uint64_t offset,
                              fvv_diagnostic *diagnostic) {
  const fvv_place place = fvv_chunk_place(header->type, header->flags);
  if (s->footer_seen) BROKEN(TRAILING, 0, "a chunk follows the footer");
  if (s->in_group &&
      (place == FVV_PLACE_CONFIGURATION || place == FVV_PLACE_END || header->type == FVV_CHUNK_GROUP))
    BROKEN(GROUP_UNFINISHED, 0, "group %u has not ended", s->table.sequence);
  if (s->index_seen && header->type != FVV_CHUNK_FOOTER)
    BROKEN(CHUNK_PLACE, 0, "only the footer may follow the index");
  if (place == FVV_PLACE_CONFIGURATION && header->type != FVV_CHUNK_SCENE && !s->in_block)
    BROKEN(CHUNK_PLACE, 0, "a configuration block begins with SCEN");
  if ((place == FVV_PLACE_FRAME || header->type == FVV_CHUNK_GROUP_END) && !s->in_group)
    BROKEN(CHUNK_PLACE, 0, "no group is open");
  if (header->type == FVV_CHUNK_FOOTER && !s->index_seen)
    BROKEN(CHUNK_PLACE, 0, "no index precedes the footer");
  if (header->type == FVV_CHUNK_INDEX && s->configuration == FVV_CONFIGURATION_NONE)
    BROKEN(NO_CONFIGURATION, 0, "no configuration precedes it");
  return FVV_OK;
}

/* Ticks and lattice indices must mean the same all through a stream. */
static fvv_status check_scene(const fvv_chunk_order *s, const fvv_chunk_header *header,
                              const uint8_t *payload, uint64_t offset, fvv_diagnostic *diagnostic) {
  fvv_scene scene;
  const fvv_status status = fvv_scene_decode(&scene, payload, (size_t)header->size, diagnostic);
  if (status < 0) {
    fvv_diagnostic_rebase(diagnostic, offset + IN_PAYLOAD, header->type);
    return status;
  }
  if (!s->scene_seen) return FVV_OK;
  if (scene.time_base.numerator != s->scene.time_base.numerator ||
      scene.time_base.denominator != s->scene.time_base.denominator)
    BROKEN(TIME_BASE, IN_PAYLOAD + FVV_SCEN_TIME_BASE_NUMERATOR,
           "time base is %u/%u, expected %u/%u as in the first configuration", scene.time_base.numerator,
           scene.time_base.denominator, s->scene.time_base.numerator, s->scene.time_base.denominator);
  if (memcmp(scene.lattice_origin, s->scene.lattice_origin, sizeof scene.lattice_origin) != 0 ||
      memcmp(&scene.lattice_step, &s->scene.lattice_step, sizeof scene.lattice_step) != 0)
    BROKEN(LATTICE, IN_PAYLOAD + FVV_SCEN_LATTICE_ORIGIN,
           "lattice differs from that of the first configuration");
  return FVV_OK;
}

static fvv_status check_track(const fvv_chunk_order *s, const fvv_chunk_header *header,
                              const uint8_t *payload, uint64_t offset, fvv_diagnostic *diagnostic) {
  fvv_track track;
  if (s->block_has_more) BROKEN(CHUNK_PLACE, 0, "track is declared after other chunks than SCEN");
  const fvv_status status = fvv_track_decode(&track, payload, (size_t)header->size, &s->limits, diagnostic);
  if (status < 0) {
    fvv_diagnostic_rebase(diagnostic, offset + IN_PAYLOAD, header->type);
    return status;
  }
  if (track_of(s, header->track))
    BROKEN(TRACK_ID, FVV_CHUNK_HEADER_TRACK, "track %u is declared twice", header->track);
  if (track_count(s) >= s->limits.max_tracks)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, offset, "more than %u tracks",
                    s->limits.max_tracks);
  return FVV_OK;
}

static fvv_status check_group(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset, fvv_diagnostic *diagnostic) {
  if (header->size != FVV_GRUP_SIZE)
    BROKEN(GROUP_PAYLOAD, FVV_CHUNK_HEADER_PAYLOAD_SIZE, "payload of %llu bytes, expected %d",
           (unsigned long long)header->size, FVV_GRUP_SIZE);
  const uint32_t number = fvv_get_u32(payload + FVV_GRUP_SEQUENCE);
  const int64_t start = fvv_get_i64(payload + FVV_GRUP_START), end = fvv_get_i64(payload + FVV_GRUP_END);
  if (start >= end || start != header->time || start < s->last_end)
    BROKEN(GROUP_TIME, IN_PAYLOAD + FVV_GRUP_START,
           "group covers ticks %lld to %lld with header time %lld, and the previous group ended at %lld",
           (long long)start, (long long)end, (long long)header->time, (long long)s->last_end);
  if (!s->joining && number < s->next_sequence)
    BROKEN(GROUP_SEQUENCE, IN_PAYLOAD + FVV_GRUP_SEQUENCE, "group %u, expected %u: it is repeated", number,
           s->next_sequence);
  const uint32_t digest = fvv_get_u32(payload + FVV_GRUP_CONFIGURATION_CRC);
  if (s->configuration == FVV_CONFIGURATION_NONE) {
    if (!find_known(s, digest)) BROKEN(NO_CONFIGURATION, 0, "no configuration precedes it");
    MISSING(NO_CONFIGURATION, 0, "no configuration precedes it; a repetition follows");
  }
  if (s->configuration == FVV_CONFIGURATION_GOOD && digest != s->configuration_crc) {
    if (!find_known(s, digest))
      BROKEN(GROUP_CONFIGURATION, IN_PAYLOAD + FVV_GRUP_CONFIGURATION_CRC,
             "group %u does not belong to the configuration before it", number);
    if (!s->hole)
      MISSING(GROUP_CONFIGURATION, IN_PAYLOAD + FVV_GRUP_CONFIGURATION_CRC,
              "group %u belongs to an earlier configuration, of which a repetition is missing", number);
  }
  if (!s->joining && !s->hole && number != s->next_sequence)
    MISSING(GROUP_SEQUENCE, IN_PAYLOAD + FVV_GRUP_SEQUENCE, "group %u, expected %u: groups are missing",
            number, s->next_sequence);
  return FVV_OK;
}

/* A layout belongs to the samples after it; rules about a track's chunks do not count it. */
static fvv_status check_layout(const fvv_chunk_order_track *track, const fvv_chunk_header *header,
                               uint64_t offset, fvv_diagnostic *diagnostic) {
  if (track->laid_out && header->time == track->layout_time)
    BROKEN(CHUNK_TIME_ORDER, FVV_CHUNK_HEADER_TIME, "track %u has a second TILE at time %lld", header->track,
           (long long)header->time);
  if (track->laid_out)
    BROKEN(TILE_GROUP, FVV_CHUNK_HEADER_TRACK, "track %u has a second layout in its group", header->track);
  if (track->seen)
    BROKEN(TILE_GROUP, FVV_CHUNK_HEADER_TRACK, "layout of track %u follows a sample of its group",
           header->track);
  return FVV_OK;
}

static fvv_status check_frame(const fvv_chunk_order *s, const fvv_chunk_header *header, uint64_t offset,
                              fvv_diagnostic *diagnostic) {
  if (s->table.chunk_count >= s->limits.max_group_chunks)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, offset,
                    "group has more than %u chunks", s->limits.max_group_chunks);
  if (!fvv_group_table_has_room(&s->table, header))
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, offset,
                    "group of more than %d kinds of chunks", FVV_MAX_GROUP_KINDS);
  if (header->time < s->group_start || header->time >= s->group_end)
    BROKEN(CHUNK_TIME, FVV_CHUNK_HEADER_TIME, "time %lld is outside the group's %lld to %lld",
           (long long)header->time, (long long)s->group_start, (long long)s->group_end);
  if (header->time < s->table.last_time)
    BROKEN(CHUNK_TIME_ORDER, FVV_CHUNK_HEADER_TIME, "time %lld follows time %lld", (long long)header->time,
           (long long)s->table.last_time);
  const uint8_t kind = fvv_chunk_track_kind(header->type);
  if (!kind || s->configuration != FVV_CONFIGURATION_GOOD) return FVV_OK;
  const fvv_chunk_order_track *track = track_of(s, header->track);
  if (!track) BROKEN(TRACK_UNDECLARED, FVV_CHUNK_HEADER_TRACK, "track %u is not declared", header->track);
  if (track->kind != kind)
    BROKEN(TRACK_KIND_MISMATCH, FVV_CHUNK_HEADER_TRACK, "track %u is of kind %u, expected %u", header->track,
           track->kind, kind);
  if (header->type == FVV_CHUNK_TILES) return check_layout(track, header, offset, diagnostic);
  if (!track->seen && track->laid_out && header->time != track->last_time)
    BROKEN(TILE_GROUP, FVV_CHUNK_HEADER_TIME,
           "the first sample of track %u is at time %lld, its layout at %lld", header->track,
           (long long)header->time, (long long)track->last_time);
  if (!track->seen && !(header->flags & FVV_FLAG_KEY))
    BROKEN(TRACK_NOT_KEY, FVV_CHUNK_HEADER_FLAGS, "first chunk of track %u in its group is not a key chunk",
           header->track);
  if (track->seen && header->time <= track->last_time)
    BROKEN(CHUNK_TIME_ORDER, FVV_CHUNK_HEADER_TIME, "track %u has a second chunk at time %lld", header->track,
           (long long)header->time);
  return FVV_OK;
}

static fvv_status check_group_end(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                                  uint64_t offset, fvv_diagnostic *diagnostic) {
  const fvv_status status = fvv_group_table_encode(&s->table, &s->scratch);
  if (status < 0) return status;
  /* Without the tracks it is not known which times are frames. */
  if (s->configuration != FVV_CONFIGURATION_GOOD && header->size >= FVV_GEND_SIZE)
    memcpy(s->scratch.data + FVV_GEND_FRAME_COUNT, payload + FVV_GEND_FRAME_COUNT, 4);
  if (header->time != s->group_end)
    BROKEN(GROUP_END, FVV_CHUNK_HEADER_TIME, "time is %lld, expected the group's end %lld",
           (long long)header->time, (long long)s->group_end);
  const size_t common = header->size < s->scratch.size ? (size_t)header->size : s->scratch.size;
  size_t i = 0;
  while (i < common && payload[i] == s->scratch.data[i]) i++;
  if (i == common && header->size == s->scratch.size) return FVV_OK;
  if (i < FVV_GEND_KIND_COUNT)
    BROKEN(GROUP_END, IN_PAYLOAD + i,
           "sequence number, chunk count, chain or frame count does not match the group");
  BROKEN(GROUP_TABLE, IN_PAYLOAD + i, "table does not match the chunks of the group");
}

static fvv_status check_end(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                            uint64_t offset, fvv_diagnostic *diagnostic) {
  if (s->joined) return FVV_OK;
  if (header->type == FVV_CHUNK_FOOTER) {
    uint8_t expected[FVV_FOOT_SIZE];
    if (!s->index_seen) return FVV_OK; /* lost, and reported already */
    fvv_footer_write(s->index_offset, offset + fvv_chunk_extent(FVV_FOOT_SIZE), s->index_crc, expected);
    if (header->size != FVV_FOOT_SIZE || memcmp(payload, expected, sizeof expected) != 0)
      BROKEN(FOOTER, IN_PAYLOAD, "footer does not match the stream of %llu bytes with the index at 0x%llx",
             (unsigned long long)(offset + fvv_chunk_extent(FVV_FOOT_SIZE)),
             (unsigned long long)s->index_offset);
    return FVV_OK;
  }
  if (s->gaps) return FVV_OK;
  const fvv_status status = fvv_chunk_order_index(s, &s->scratch);
  if (status < 0) return status;
  if (header->size < s->scratch.size || memcmp(payload, s->scratch.data, s->scratch.size) != 0)
    BROKEN(INDEX, IN_PAYLOAD, "index does not list the %zu groups of the stream",
           s->groups.size / sizeof(fvv_index_entry));
  return FVV_OK;
}

/* After damage a violation is not reported, but then the list of the group's chunks can't be trusted. */
static void check_list(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                       uint64_t offset) {
  if (!s->listed) return;
  s->suspect = 0;
  s->listed = fvv_chunk_order_check(s, header, payload, offset, NULL) == FVV_OK;
  s->suspect = 1;
}

/* Whether a critical chunk is ignored with its track: the kind is not known, or nothing of the group can be
 * decoded without its configuration. */
static int is_ignored(const fvv_chunk_order *s, uint16_t id) {
  const fvv_chunk_order_track *track = track_of(s, id);
  if (s->in_group && s->configuration != FVV_CONFIGURATION_GOOD) return id != 0;
  return track && fvv_kind_is_foreign(track->kind);
}

fvv_status fvv_chunk_order_check(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                                 uint64_t offset, fvv_diagnostic *diagnostic) {
  const fvv_place place = fvv_chunk_place(header->type, header->flags);
  if (place == FVV_PLACE_UNKNOWN && header->flags & FVV_FLAG_CRITICAL && !is_ignored(s, header->track))
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_UNKNOWN_CRITICAL, header->type, offset,
                    "critical chunk of a type that this version does not know");
  fvv_status status = fvv_header_check(header, offset, diagnostic);
  if (status < 0) return status;
  const int fresh = header->type == FVV_CHUNK_SCENE || header->type == FVV_CHUNK_GROUP;
  if (s->suspect && !fresh && place != FVV_PLACE_END && !s->footer_seen) {
    check_list(s, header, payload, offset);
    return FVV_OK;
  }
  if (!s->suspect || s->footer_seen) status = check_place(s, header, offset, diagnostic);
  if (status < 0) return status;
  if (!s->suspect && header->counter != fvv_chunk_order_counter(s, header->type))
    BROKEN(CONTINUITY, FVV_CHUNK_HEADER_COUNTER,
           "continuity counter is %u, expected %u: chunks are missing or repeated", header->counter,
           fvv_chunk_order_counter(s, header->type));
  switch (header->type) {
  case FVV_CHUNK_SCENE:
    return check_scene(s, header, payload, offset, diagnostic);
  case FVV_CHUNK_TRACK:
    return check_track(s, header, payload, offset, diagnostic);
  case FVV_CHUNK_GROUP:
    return check_group(s, header, payload, offset, diagnostic);
  case FVV_CHUNK_GROUP_END:
    return check_group_end(s, header, payload, offset, diagnostic);
  default:
    break;
  }
  if (place == FVV_PLACE_END) return check_end(s, header, payload, offset, diagnostic);
  return s->in_group ? check_frame(s, header, offset, diagnostic) : FVV_OK;
}

/* What an accepted chunk changes. */

static fvv_status begin_block(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset) {
  fvv_scene scene;
  if (!s->scene_seen && fvv_scene_decode(&scene, payload, (size_t)header->size, NULL) == FVV_OK) {
    s->scene = scene;
    s->scene_seen = 1;
  }
  s->in_block = 1;
  s->in_group = s->suspect = s->listed = s->block_has_more = 0;
  s->configuration = FVV_CONFIGURATION_GOOD;
  s->configuration_crc = 0;
  s->configuration_offset = offset;
  s->tracks.size = 0;
  return FVV_OK;
}

/* The digest covers every header of the block, and each header has the CRC of its payload. A block that was
 * damaged or lost is replaced by an intact repetition. */
static fvv_status find_configuration(fvv_chunk_order *s, uint32_t digest) {
  const int is_whole = s->configuration == FVV_CONFIGURATION_GOOD ||
                       (s->configuration == FVV_CONFIGURATION_LOST && s->configuration_offset);
  if (is_whole && digest == s->configuration_crc) {
    s->configuration = FVV_CONFIGURATION_GOOD;
    return remember_block(s);
  }
  if (s->configuration == FVV_CONFIGURATION_UNSEEN) return FVV_OK;
  const fvv_known_block *known = find_known(s, digest);
  if (known) return recall_block(s, known);
  if (s->configuration == FVV_CONFIGURATION_NONE) s->configuration = FVV_CONFIGURATION_LOST;
  return FVV_OK;
}

static fvv_status begin_group(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset) {
  const fvv_status status = find_configuration(s, fvv_get_u32(payload + FVV_GRUP_CONFIGURATION_CRC));
  if (status < 0) return status;
  s->in_block = 0;
  s->in_group = 1;
  s->suspect = s->joining = s->hole = 0;
  s->group_offset = offset;
  s->group_start = fvv_get_i64(payload + FVV_GRUP_START);
  s->group_end = fvv_get_i64(payload + FVV_GRUP_END);
  const uint32_t number = fvv_get_u32(payload + FVV_GRUP_SEQUENCE);
  s->next_sequence = number + 1;
  fvv_group_table_begin(&s->table, header, number);
  fvv_chunk_order_track *tracks = (fvv_chunk_order_track *)s->tracks.data;
  for (size_t i = 0; i < s->tracks.size / sizeof *tracks; i++) tracks[i].seen = tracks[i].laid_out = 0;
  s->listed = fvv_chunk_order_group_intact(s);
  return FVV_OK;
}

/* The block of the open group, for the index. */
static fvv_status list_block(fvv_chunk_order *s) {
  const size_t count = s->blocks.size / sizeof(fvv_index_block);
  if (count && ((const fvv_index_block *)s->blocks.data)[count - 1].offset == s->configuration_offset)
    return FVV_OK;
  const uint64_t size = s->group_offset - s->configuration_offset;
  if (size > UINT32_MAX) return FVV_ERROR_LIMIT;
  const fvv_index_block block = {s->configuration_offset, (uint32_t)size, s->configuration_crc};
  return fvv_bytes_append(&s->blocks, &block, sizeof block);
}

static fvv_status end_group(fvv_chunk_order *s, const fvv_chunk_header *header, uint64_t offset) {
  s->in_group = 0;
  s->last_end = s->group_end;
  /* After damage, and where reading began late, no index is compared: live streams have no end. */
  if (s->suspect || s->gaps || s->joined) return FVV_OK;
  if (s->groups.size / sizeof(fvv_index_entry) >= s->limits.max_groups) return FVV_ERROR_LIMIT;
  const fvv_status status = list_block(s);
  if (status < 0) return status;
  fvv_index_entry entry;
  memset(&entry, 0, sizeof entry);
  entry.group.offset = s->group_offset;
  entry.end_size = (uint32_t)fvv_chunk_extent(header->size);
  entry.group.size = offset + entry.end_size - s->group_offset;
  entry.group.start = s->group_start;
  entry.group.end = s->group_end;
  entry.group.sequence = s->table.sequence;
  entry.group.frame_count = s->table.frame_count;
  entry.group.intact = fvv_chunk_order_group_intact(s);
  entry.group.configuration_offset = s->configuration_offset;
  entry.chain_crc = s->table.chain_crc;
  return fvv_bytes_append(&s->groups, &entry, sizeof entry);
}

static fvv_status add_frame_chunk(fvv_chunk_order *s, const fvv_chunk_header *header) {
  fvv_chunk_order_track *track = track_of(s, header->track);
  if (track && fvv_chunk_track_kind(header->type)) {
    if (header->type == FVV_CHUNK_TILES) {
      track->laid_out = 1;
      track->layout_time = header->time;
    } else {
      track->seen = 1;
    }
    track->last_time = header->time;
  }
  const int makes_frame = fvv_makes_frame(header->type, track ? track->kind : 0, track ? track->flags : 0);
  return fvv_group_table_add(&s->table, header, makes_frame);
}

fvv_status fvv_chunk_order_apply(fvv_chunk_order *s, const fvv_chunk_header *header, const uint8_t *payload,
                                 uint64_t offset) {
  s->next_counter = (uint8_t)(header->counter + 1);
  fvv_status status = FVV_OK;
  switch (header->type) {
  case FVV_CHUNK_SCENE:
    status = begin_block(s, header, payload, offset);
    break;
  case FVV_CHUNK_GROUP:
    return header->size == FVV_GRUP_SIZE ? begin_group(s, header, payload, offset) : FVV_OK;
  case FVV_CHUNK_GROUP_END:
    return s->in_group ? end_group(s, header, offset) : FVV_OK;
  case FVV_CHUNK_INDEX:
    s->index_seen = 1;
    s->in_group = s->in_block = s->suspect = s->listed = 0;
    s->index_offset = offset;
    s->index_crc = header->payload_crc;
    return FVV_OK;
  case FVV_CHUNK_FOOTER:
    s->footer_seen = 1;
    return FVV_OK;
  case FVV_CHUNK_TRACK:
    if (s->in_block && header->size >= FVV_TRAK_SIZE) {
      const fvv_chunk_order_track track = {
          header->track, payload[FVV_TRAK_KIND], payload[FVV_TRAK_FLAGS], 0, 0, 0, 0};
      status = fvv_bytes_append(&s->tracks, &track, sizeof track);
    }
    break;
  default:
    break;
  }
  if (status < 0) return status;
  if (s->in_group) return add_frame_chunk(s, header);
  /* A frame without its GRUP: the block ended within the lost bytes. */
  if (fvv_chunk_place(header->type, header->flags) == FVV_PLACE_FRAME) s->in_block = 0;
  if (s->in_block) {
    s->block_has_more |= header->type != FVV_CHUNK_SCENE && header->type != FVV_CHUNK_TRACK &&
                         fvv_chunk_place(header->type, header->flags) != FVV_PLACE_UNKNOWN;
    s->configuration_crc = fvv_header_chain(s->configuration_crc, header);
  }
  return FVV_OK;
}

void fvv_chunk_order_lost(fvv_chunk_order *s) {
  s->suspect = s->gaps = s->hole = 1;
  s->listed = 0;
  /* A block that is complete stays good; if a newer one was lost, the next group's digest shows it. */
  if ((s->in_block && s->configuration == FVV_CONFIGURATION_GOOD) ||
      s->configuration == FVV_CONFIGURATION_NONE)
    s->configuration = FVV_CONFIGURATION_LOST;
}

fvv_status fvv_chunk_order_damaged(fvv_chunk_order *s, const fvv_chunk_header *header, uint64_t offset) {
  const fvv_place place = fvv_chunk_place(header->type, header->flags);
  const int is_of_group = place == FVV_PLACE_FRAME || place == FVV_PLACE_UNKNOWN;
  const int listed = s->listed && is_of_group;
  fvv_chunk_order_lost(s);
  s->listed = listed;
  check_list(s, header, NULL, offset);
  return s->listed ? fvv_chunk_order_apply(s, header, NULL, offset) : FVV_OK;
}

void fvv_chunk_order_broken(fvv_chunk_order *s, const fvv_chunk_header *header) {
  s->suspect = s->gaps = s->hole = 1;
  s->listed = 0;
  const fvv_place place = fvv_chunk_place(header->type, header->flags);
  if ((s->in_block || s->configuration == FVV_CONFIGURATION_NONE) &&
      (place == FVV_PLACE_CONFIGURATION || place == FVV_PLACE_UNKNOWN))
    s->configuration = FVV_CONFIGURATION_BROKEN;
}

void fvv_chunk_order_missing(fvv_chunk_order *s) {
  s->gaps = 1;
}

void fvv_chunk_order_abandon_group(fvv_chunk_order *s) {
  s->in_group = s->listed = 0;
  s->gaps = s->hole = 1;
}

int fvv_chunk_order_group_intact(const fvv_chunk_order *s) {
  return !s->suspect &&
         (s->configuration == FVV_CONFIGURATION_GOOD || s->configuration == FVV_CONFIGURATION_UNSEEN);
}

fvv_status fvv_chunk_order_index(const fvv_chunk_order *s, fvv_bytes *payload) {
  return fvv_index_encode(&s->groups, &s->blocks, payload);
}

void fvv_footer_write(uint64_t index_offset, uint64_t file_size, uint32_t index_crc, uint8_t *payload) {
  memset(payload, 0, FVV_FOOT_SIZE);
  fvv_put_u64(payload + FVV_FOOT_INDEX_OFFSET, index_offset);
  fvv_put_u64(payload + FVV_FOOT_FILE_SIZE, file_size);
  fvv_put_u32(payload + FVV_FOOT_INDEX_CRC, index_crc);
}
