#include "recover/src/chunk.h"

#include "src/base/bytes.h"
#include "src/base/layout.h"

namespace fvv::recover {

namespace {

enum class Track { none, own, any };

struct Row {
  uint32_t type;
  Place place;
  uint8_t flags;
  Track track;
};

constexpr Place CONFIGURATION = Place::configuration, GROUP = Place::group, FRAME = Place::frame,
                END = Place::end;
constexpr Track NONE = Track::none, OWN = Track::own, ANY = Track::any;
#define ROW(type, place, flags, track) {type, place, flags, track},
constexpr Row rows[] = {FVV_CHUNK_TABLE(ROW)};
#undef ROW

} // namespace

Place place_of(uint32_t type, uint8_t flags) {
  Place place = Place::unknown;
  // TILE has two places; the key flag decides.
  for (const Row &row : rows)
    if (row.type == type && (place == Place::unknown || flags & FVV_FLAG_KEY)) place = row.place;
  return place;
}

bool is_regular(const fvv_chunk_header &header) {
  const Place place = place_of(header.type, header.flags);
  if (place == Place::unknown) return !(header.flags & ~FVV_FLAG_KEY);
  for (const Row &row : rows) {
    if (row.type != header.type || row.place != place) continue;
    const int optional = place == Place::frame ? FVV_FLAG_KEY : 0;
    return (header.flags & ~optional) == row.flags && (row.track != NONE || !header.track) &&
           (row.track != OWN || header.track) && (place != Place::configuration || !header.time);
  }
  return false;
}

uint32_t continue_chain(uint32_t crc, const fvv_chunk_header &header) {
  uint8_t bytes[FVV_CHUNK_HEADER_HEADER_CRC];
  fvv_put_u32(bytes + FVV_CHUNK_HEADER_TYPE, header.type);
  bytes[FVV_CHUNK_HEADER_FLAGS] = header.flags;
  bytes[FVV_CHUNK_HEADER_COUNTER] = header.counter;
  fvv_put_u16(bytes + FVV_CHUNK_HEADER_TRACK, header.track);
  fvv_put_i64(bytes + FVV_CHUNK_HEADER_TIME, header.time);
  fvv_put_u64(bytes + FVV_CHUNK_HEADER_PAYLOAD_SIZE, header.size);
  fvv_put_u32(bytes + FVV_CHUNK_HEADER_PAYLOAD_CRC, header.payload_crc);
  return fvv_crc32c(crc, bytes, sizeof bytes);
}

const std::vector<uint8_t> &Payloads::read(const Chunk &chunk) {
  bytes.resize(static_cast<size_t>(chunk.header.size));
  const fvv_input input = file.input();
  const bool is_read = bytes.empty() || input.read_at(input.user, chunk.offset + FVV_CHUNK_HEADER_SIZE,
                                                      bytes.data(), bytes.size()) == FVV_OK;
  if (!is_read) throw Error(file.path(), "cannot read");
  // What changed since must not get a CRC that matches (FVV-9006).
  if (fvv_crc32c(0, bytes.data(), bytes.size()) != chunk.header.payload_crc)
    throw Error(file.path(), "changes while it is read");
  return bytes;
}

} // namespace fvv::recover
