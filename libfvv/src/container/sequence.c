#include "container/sequence.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/limits.h"

void fvv_sequence_init(fvv_sequence *sequence, const fvv_limits *limits, const fvv_allocator *allocator) {
  memset(sequence, 0, sizeof *sequence);
  sequence->limits = fvv_limits_or_default(limits);
  sequence->allocator = fvv_allocator_or_default(allocator);
  sequence->last_end = INT64_MIN;
  fvv_group_table_init(&sequence->table, &sequence->allocator);
  sequence->tracks.allocator = sequence->groups.allocator = sequence->scratch.allocator = sequence->allocator;
}

void fvv_sequence_free(fvv_sequence *sequence) {
  fvv_group_table_free(&sequence->table);
  fvv_bytes_free(&sequence->tracks);
  fvv_bytes_free(&sequence->groups);
  fvv_bytes_free(&sequence->scratch);
}

uint8_t fvv_sequence_counter(const fvv_sequence *sequence, uint32_t type) {
  const int restarts = type == FVV_CHUNK_SCENE || type == FVV_CHUNK_GROUP || type == FVV_CHUNK_INDEX;
  return restarts ? 0 : sequence->next_counter;
}

static size_t track_count(const fvv_sequence *s) {
  return s->tracks.size / sizeof(fvv_sequence_track);
}

static fvv_sequence_track *track_of(const fvv_sequence *s, uint16_t id) {
  fvv_sequence_track *tracks = (fvv_sequence_track *)s->tracks.data;
  for (size_t i = 0; i < track_count(s); i++)
    if (tracks[i].id == id) return &tracks[i];
  return NULL;
}

/* What every rule below answers with; the header of the chunk in question is in scope. */
#define BROKEN(issue, at, ...)                                                                               \
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_##issue, header->type, offset + (at), __VA_ARGS__)
enum { IN_PAYLOAD = FVV_CHUNK_HEADER_SIZE };

static fvv_status check_place(const fvv_sequence *s, const fvv_chunk_header *header, uint64_t offset,
                              fvv_diagnostic *diagnostic) {
  const fvv_place place = fvv_chunk_place(header->type);
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
  if (header->type == FVV_CHUNK_FOOTER && !s->index_seen) BROKEN(CHUNK_PLACE, 0, "no index stands in front");
  if ((header->type == FVV_CHUNK_GROUP || header->type == FVV_CHUNK_INDEX) &&
      s->configuration == FVV_CONFIGURATION_NONE)
    BROKEN(NO_CONFIGURATION, 0, "no configuration stands in front");
  return FVV_OK;
}

/* Ticks and lattice indices must mean the same all through a stream. */
static fvv_status check_scene(const fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset, fvv_diagnostic *diagnostic) {
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
           "time base %u/%u is not the first block's %u/%u", scene.time_base.numerator,
           scene.time_base.denominator, s->scene.time_base.numerator, s->scene.time_base.denominator);
  if (memcmp(scene.lattice_origin, s->scene.lattice_origin, sizeof scene.lattice_origin) != 0 ||
      memcmp(&scene.lattice_step, &s->scene.lattice_step, sizeof scene.lattice_step) != 0)
    BROKEN(LATTICE, IN_PAYLOAD + FVV_SCEN_LATTICE_ORIGIN, "lattice is not the first block's");
  return FVV_OK;
}

static fvv_status check_track(const fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset, fvv_diagnostic *diagnostic) {
  fvv_track track;
  const fvv_status status = fvv_track_decode(&track, payload, (size_t)header->size, &s->limits, diagnostic);
  if (status < 0) {
    fvv_diagnostic_rebase(diagnostic, offset + IN_PAYLOAD, header->type);
    return status;
  }
  if (s->block_has_more) BROKEN(CHUNK_PLACE, 0, "tracks are declared before anything else but SCEN");
  if (track_of(s, header->track))
    BROKEN(TRACK_ID, FVV_CHUNK_HEADER_TRACK, "track %u is declared twice", header->track);
  if (track_count(s) >= s->limits.max_tracks)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, offset, "more than %u tracks",
                    s->limits.max_tracks);
  return FVV_OK;
}

static fvv_status check_group(const fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset, fvv_diagnostic *diagnostic) {
  if (header->size != FVV_GRUP_SIZE)
    BROKEN(GROUP_PAYLOAD, FVV_CHUNK_HEADER_PAYLOAD_SIZE, "payload of %llu bytes, expected %d",
           (unsigned long long)header->size, FVV_GRUP_SIZE);
  const uint32_t number = fvv_get_u32(payload + FVV_GRUP_SEQUENCE);
  const int64_t start = fvv_get_i64(payload + FVV_GRUP_START), end = fvv_get_i64(payload + FVV_GRUP_END);
  if (start >= end || start != header->time || start < s->last_end)
    BROKEN(GROUP_TIME, IN_PAYLOAD + FVV_GRUP_START,
           "group covers ticks %lld to %lld with header time %lld, and the former group ended at %lld",
           (long long)start, (long long)end, (long long)header->time, (long long)s->last_end);
  /* After a gap groups may be missing, but never come twice. */
  if (!s->joining && (s->gaps ? number < s->next_sequence : number != s->next_sequence))
    BROKEN(GROUP_SEQUENCE, IN_PAYLOAD + FVV_GRUP_SEQUENCE, "group %u, expected %u", number, s->next_sequence);
  if (s->configuration == FVV_CONFIGURATION_GOOD &&
      fvv_get_u32(payload + FVV_GRUP_CONFIGURATION_CRC) != s->configuration_crc)
    BROKEN(GROUP_CONFIGURATION, IN_PAYLOAD + FVV_GRUP_CONFIGURATION_CRC,
           "group %u belongs to another configuration than the one in front", number);
  return FVV_OK;
}

/* A layout belongs to the samples behind it; it is none of those that rules about a track's chunks count. */
static fvv_status check_layout(const fvv_sequence_track *track, const fvv_chunk_header *header,
                               uint64_t offset, fvv_diagnostic *diagnostic) {
  if (!(header->flags & FVV_FLAG_KEY))
    BROKEN(TILE_GROUP, FVV_CHUNK_HEADER_FLAGS, "layout of track %u is no key chunk", header->track);
  if (track->laid_out)
    BROKEN(TILE_GROUP, FVV_CHUNK_HEADER_TRACK, "track %u has a second layout in its group", header->track);
  if (track->seen)
    BROKEN(TILE_GROUP, FVV_CHUNK_HEADER_TRACK, "layout of track %u stands behind a sample of its group",
           header->track);
  return FVV_OK;
}

static fvv_status check_frame(const fvv_sequence *s, const fvv_chunk_header *header, uint64_t offset,
                              fvv_diagnostic *diagnostic) {
  if (s->table.chunk_count >= s->limits.max_group_chunks)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, offset,
                    "group of more than %u chunks", s->limits.max_group_chunks);
  if (header->time < s->group_start || header->time >= s->group_end)
    BROKEN(CHUNK_TIME, FVV_CHUNK_HEADER_TIME, "time %lld is outside the group's %lld to %lld",
           (long long)header->time, (long long)s->group_start, (long long)s->group_end);
  if (header->time < s->table.last_time)
    BROKEN(CHUNK_TIME_ORDER, FVV_CHUNK_HEADER_TIME, "time %lld follows %lld", (long long)header->time,
           (long long)s->table.last_time);
  const uint8_t kind = fvv_chunk_track_kind(header->type);
  if (!kind || s->configuration != FVV_CONFIGURATION_GOOD) return FVV_OK;
  const fvv_sequence_track *track = track_of(s, header->track);
  if (!track) BROKEN(TRACK_UNDECLARED, FVV_CHUNK_HEADER_TRACK, "track %u is not declared", header->track);
  if (track->kind != kind)
    BROKEN(TRACK_KIND_MISMATCH, FVV_CHUNK_HEADER_TRACK, "track %u is of kind %u, expected %u", header->track,
           track->kind, kind);
  if (header->type == FVV_CHUNK_GROUP_TILES) return check_layout(track, header, offset, diagnostic);
  if (!track->seen && track->laid_out && header->time != track->last_time)
    BROKEN(TILE_GROUP, FVV_CHUNK_HEADER_TIME,
           "the first sample of track %u is at time %lld, its layout at %lld", header->track,
           (long long)header->time, (long long)track->last_time);
  if (!track->seen && !(header->flags & FVV_FLAG_KEY))
    BROKEN(TRACK_NOT_KEY, FVV_CHUNK_HEADER_FLAGS, "first chunk of track %u in its group is no key chunk",
           header->track);
  if (track->seen && header->time <= track->last_time)
    BROKEN(CHUNK_TIME_ORDER, FVV_CHUNK_HEADER_TIME, "track %u has a second chunk at time %lld", header->track,
           (long long)header->time);
  return FVV_OK;
}

static fvv_status check_group_end(fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                                  uint64_t offset, fvv_diagnostic *diagnostic) {
  const fvv_status status = fvv_group_table_encode(&s->table, &s->scratch);
  if (status < 0) return status;
  if (header->time != s->group_end)
    BROKEN(GROUP_END, FVV_CHUNK_HEADER_TIME, "time is %lld, expected the group's end %lld",
           (long long)header->time, (long long)s->group_end);
  const size_t common = header->size < s->scratch.size ? (size_t)header->size : s->scratch.size;
  size_t i = 0;
  while (i < common && payload[i] == s->scratch.data[i]) i++;
  if (i == common && header->size == s->scratch.size) return FVV_OK;
  if (i < FVV_GEND_KIND_COUNT)
    BROKEN(GROUP_END, IN_PAYLOAD + i, "sequence, chunk count, chain or frame count is not that of the group");
  BROKEN(GROUP_TABLE, IN_PAYLOAD + i, "table is not that of the group");
}

static fvv_status check_end(fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                            uint64_t offset, fvv_diagnostic *diagnostic) {
  if (s->joined) return FVV_OK;
  if (header->type == FVV_CHUNK_FOOTER) {
    uint8_t expected[FVV_FOOT_SIZE];
    if (!s->index_seen) return FVV_OK; /* lost, and told already */
    fvv_footer_write(s->index_offset, offset + fvv_chunk_extent(FVV_FOOT_SIZE), s->index_crc, expected);
    if (header->size != FVV_FOOT_SIZE || memcmp(payload, expected, sizeof expected) != 0)
      BROKEN(FOOTER, IN_PAYLOAD, "footer does not fit the stream: %llu bytes with the index at 0x%llx",
             (unsigned long long)(offset + fvv_chunk_extent(FVV_FOOT_SIZE)),
             (unsigned long long)s->index_offset);
    return FVV_OK;
  }
  if (s->gaps) return FVV_OK;
  const fvv_status status = fvv_sequence_index(s, &s->scratch);
  if (status < 0) return status;
  if (header->size != s->scratch.size || memcmp(payload, s->scratch.data, s->scratch.size) != 0)
    BROKEN(INDEX, IN_PAYLOAD, "index does not list the %zu groups of the stream",
           s->groups.size / sizeof(fvv_index_entry));
  return FVV_OK;
}

fvv_status fvv_sequence_check(fvv_sequence *s, const fvv_chunk_header *header, const uint8_t *payload,
                              uint64_t offset, fvv_diagnostic *diagnostic) {
  const fvv_place place = fvv_chunk_place(header->type);
  if (place == FVV_PLACE_UNKNOWN && header->flags & FVV_FLAG_CRITICAL)
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_UNKNOWN_CRITICAL, header->type, offset,
                    "critical chunk of a type that this version does not know");
  fvv_status status = fvv_header_check(header, offset, diagnostic);
  if (status < 0) return status;
  const int fresh = header->type == FVV_CHUNK_SCENE || header->type == FVV_CHUNK_GROUP;
  if (s->suspect && !fresh && place != FVV_PLACE_END && !s->footer_seen) return FVV_OK;
  if (!s->suspect || s->footer_seen) status = check_place(s, header, offset, diagnostic);
  if (status < 0) return status;
  if (!s->suspect && header->counter != fvv_sequence_counter(s, header->type))
    BROKEN(CONTINUITY, FVV_CHUNK_HEADER_COUNTER,
           "continuity counter is %u, expected %u: chunks are missing or double", header->counter,
           fvv_sequence_counter(s, header->type));
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
