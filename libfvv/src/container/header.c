#include "container/header.h"

#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"

enum { TRACK_NONE, TRACK_OWN };

typedef struct chunk_row {
  uint32_t type;
  fvv_place place;
  uint8_t flags, track;
} chunk_row;

#define ROW(type, place, flags, track) {type, FVV_PLACE_##place, flags, TRACK_##track},
static const chunk_row rows[] = {FVV_CHUNK_TABLE(ROW)};
#undef ROW

/* Of a type with two places the key flag decides. */
static const chunk_row *row_of(uint32_t type, uint8_t flags) {
  const chunk_row *found = NULL;
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
    if (rows[i].type == type && (!found || (flags & FVV_FLAG_KEY && rows[i].place == FVV_PLACE_FRAME)))
      found = &rows[i];
  return found;
}

fvv_place fvv_chunk_place(uint32_t type, uint8_t flags) {
  const chunk_row *row = row_of(type, flags);
  return row ? row->place : FVV_PLACE_UNKNOWN;
}

uint8_t fvv_chunk_flags(uint32_t type) {
  const chunk_row *row = row_of(type, 0);
  return row ? row->flags : 0;
}

uint8_t fvv_chunk_track_kind(uint32_t type) {
  switch (type) {
  case FVV_CHUNK_MESH:
    return FVV_TRACK_MESH;
  case FVV_CHUNK_CALIBRATION:
    return FVV_TRACK_CALIBRATION;
  case FVV_CHUNK_VISIBILITY:
    return FVV_TRACK_VISIBILITY;
  case FVV_CHUNK_TILES:
  case FVV_CHUNK_VIDEO_PACKET:
    return FVV_TRACK_VIDEO;
  case FVV_CHUNK_COLOURS:
    return FVV_TRACK_COLOURS;
  case FVV_CHUNK_ENVIRONMENT:
    return FVV_TRACK_ENVIRONMENT;
  case FVV_CHUNK_AUDIO:
    return FVV_TRACK_AUDIO;
  case FVV_CHUNK_DATA:
    return FVV_TRACK_DATA;
  default:
    return 0;
  }
}

int fvv_type_makes_frame(uint32_t type) {
  if (type == FVV_CHUNK_MESH || type == FVV_CHUNK_VIDEO_PACKET) return 1;
  return row_of(type, 0) && type != FVV_CHUNK_DATA ? 0 : -1;
}

int fvv_kind_is_foreign(uint8_t kind) {
  return kind > FVV_TRACK_COLOURS;
}

int fvv_makes_frame(uint32_t type, uint8_t kind, uint8_t flags) {
  const int by_type = fvv_type_makes_frame(type);
  if (by_type >= 0) return by_type;
  const int counts = type == FVV_CHUNK_DATA ? kind == FVV_TRACK_DATA : fvv_kind_is_foreign(kind);
  return counts && flags & FVV_TRACK_FLAG_FRAMES;
}

void fvv_header_write(fvv_chunk_header *header, uint8_t out[FVV_CHUNK_HEADER_SIZE]) {
  fvv_put_u32(out + FVV_CHUNK_HEADER_TYPE, header->type);
  out[FVV_CHUNK_HEADER_FLAGS] = header->flags;
  out[FVV_CHUNK_HEADER_COUNTER] = header->counter;
  fvv_put_u16(out + FVV_CHUNK_HEADER_TRACK, header->track);
  fvv_put_i64(out + FVV_CHUNK_HEADER_TIME, header->time);
  fvv_put_u64(out + FVV_CHUNK_HEADER_PAYLOAD_SIZE, header->size);
  fvv_put_u32(out + FVV_CHUNK_HEADER_PAYLOAD_CRC, header->payload_crc);
  header->header_crc = fvv_crc32c(0, out, FVV_CHUNK_HEADER_HEADER_CRC);
  fvv_put_u32(out + FVV_CHUNK_HEADER_HEADER_CRC, header->header_crc);
}

uint32_t fvv_header_chain(uint32_t crc, const fvv_chunk_header *header) {
  uint8_t bytes[FVV_CHUNK_HEADER_SIZE];
  fvv_chunk_header copy = *header;
  fvv_header_write(&copy, bytes);
  return fvv_crc32c(crc, bytes, FVV_CHUNK_HEADER_HEADER_CRC);
}

int fvv_header_read(fvv_chunk_header *header, const uint8_t bytes[FVV_CHUNK_HEADER_SIZE]) {
  /* Cheap tests first: scanning does this at every offset. */
  for (int i = 0; i < 4; i++)
    if (bytes[i] < 0x20 || bytes[i] > 0x7e) return 0;
  header->header_crc = fvv_get_u32(bytes + FVV_CHUNK_HEADER_HEADER_CRC);
  if (fvv_crc32c(0, bytes, FVV_CHUNK_HEADER_HEADER_CRC) != header->header_crc) return 0;
  header->type = fvv_get_u32(bytes + FVV_CHUNK_HEADER_TYPE);
  header->flags = bytes[FVV_CHUNK_HEADER_FLAGS];
  header->counter = bytes[FVV_CHUNK_HEADER_COUNTER];
  header->track = fvv_get_u16(bytes + FVV_CHUNK_HEADER_TRACK);
  header->time = fvv_get_i64(bytes + FVV_CHUNK_HEADER_TIME);
  header->size = fvv_get_u64(bytes + FVV_CHUNK_HEADER_PAYLOAD_SIZE);
  header->payload_crc = fvv_get_u32(bytes + FVV_CHUNK_HEADER_PAYLOAD_CRC);
  return 1;
}

int fvv_header_plausible(const fvv_chunk_header *header, uint64_t max_payload) {
  fvv_diagnostic ignored = {0};
  return header->size <= max_payload && fvv_header_check(header, 0, &ignored) == FVV_OK;
}

uint64_t fvv_chunk_extent(uint64_t size) {
  return FVV_CHUNK_HEADER_SIZE + fvv_padded(size);
}

fvv_status fvv_header_check(const fvv_chunk_header *header, uint64_t offset, fvv_diagnostic *diagnostic) {
  const chunk_row *row = row_of(header->type, header->flags);
  const uint8_t flags = header->flags;
  if (header->size >> 63)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CHUNK_SIZE, header->type,
                    offset + FVV_CHUNK_HEADER_PAYLOAD_SIZE, "payload size has bit 63 set");
  const uint8_t free_flags = !row || row->place == FVV_PLACE_FRAME ? FVV_FLAG_KEY : 0;
  const uint8_t known = row ? row->flags : (flags & (FVV_FLAG_CRITICAL | FVV_FLAG_LAST));
  if ((flags & ~free_flags) != known || (!row && flags & FVV_FLAG_LAST))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CHUNK_FLAGS, header->type,
                    offset + FVV_CHUNK_HEADER_FLAGS, "flags are 0x%02x", flags);
  if (!row) return FVV_OK;
  if ((row->track == TRACK_NONE && header->track) || (row->track == TRACK_OWN && !header->track))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CHUNK_FIELDS, header->type,
                    offset + FVV_CHUNK_HEADER_TRACK, "track is %u, expected %s", header->track,
                    row->track == TRACK_NONE ? "0" : "a track");
  if ((row->place == FVV_PLACE_CONFIGURATION || row->place == FVV_PLACE_END) && header->time)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CHUNK_FIELDS, header->type,
                    offset + FVV_CHUNK_HEADER_TIME, "time is not 0 in a chunk that has none");
  return FVV_OK;
}

fvv_status fvv_file_header_check(const uint8_t bytes[FVV_FILE_HEADER_SIZE], fvv_diagnostic *diagnostic) {
  if (memcmp(bytes, FVV_SIGNATURE, 8) != 0)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SIGNATURE, 0, 0,
                    "not a fvv stream: the signature is missing");
  if (fvv_crc32c(0, bytes, FVV_FILE_HEADER_CRC) != fvv_get_u32(bytes + FVV_FILE_HEADER_CRC))
    return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_FILE_HEADER_CRC, 0, FVV_FILE_HEADER_CRC,
                    "CRC of the file header does not match");
  const unsigned major = fvv_get_u16(bytes + FVV_FILE_HEADER_READER_MAJOR);
  const unsigned minor = fvv_get_u16(bytes + FVV_FILE_HEADER_READER_MINOR);
  if (major != FVV_FORMAT_MAJOR || minor > FVV_FORMAT_MINOR || minor < FVV_FORMAT_READER_MINOR)
    return fvv_fail(diagnostic, FVV_ERROR_UNSUPPORTED, FVV_ISSUE_VERSION, 0, FVV_FILE_HEADER_READER_MAJOR,
                    "needs a reader of format %u.%u, this one knows %d.%d", major, minor, FVV_FORMAT_MAJOR,
                    FVV_FORMAT_MINOR);
  if (fvv_get_u32(bytes + FVV_FILE_HEADER_RESERVED))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FILE_HEADER_RESERVED, 0,
                    FVV_FILE_HEADER_RESERVED, "reserved bytes of the file header are not 0");
  return FVV_OK;
}
