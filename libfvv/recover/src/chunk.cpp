#include "recover/src/chunk.h"

#include "fvv_cxx/untrusted.h"

namespace fvv::recover {

using layout::ChunkRule, layout::ChunkTrack, layout::chunk_rules;

Place place_of(uint32_t type, uint8_t flags) {
  Place place = Place::unknown;
  // TILE has two places; the key flag decides.
  for (const ChunkRule &rule : chunk_rules)
    if (rule.type == type && (place == Place::unknown || flags & FVV_FLAG_KEY)) place = rule.place;
  return place;
}

bool is_regular(const fvv_chunk_header &header) {
  const Place place = place_of(header.type, header.flags);
  if (place == Place::unknown) return !(header.flags & ~FVV_FLAG_KEY);
  for (const ChunkRule &rule : chunk_rules) {
    if (rule.type != header.type || rule.place != place) continue;
    const int optional = place == Place::frame ? FVV_FLAG_KEY : 0;
    return (header.flags & ~optional) == rule.flags && (rule.track != ChunkTrack::none || !header.track) &&
           (rule.track != ChunkTrack::own || header.track) && (place != Place::configuration || !header.time);
  }
  return false;
}

uint32_t continue_chain(uint32_t crc, const fvv_chunk_header &header) {
  namespace at = layout::chunk_header;
  uint8_t bytes[at::header_crc];
  store_u32(bytes + at::type, header.type);
  bytes[at::flags] = header.flags;
  bytes[at::counter] = header.counter;
  store_u16(bytes + at::track, header.track);
  store_u64(bytes + at::time, static_cast<uint64_t>(header.time));
  store_u64(bytes + at::payload_size, header.size);
  store_u32(bytes + at::payload_crc, header.payload_crc);
  return fvv_crc32c(crc, bytes, sizeof bytes);
}

const std::vector<uint8_t> &Payloads::read(const Chunk &chunk) {
  bytes.resize(static_cast<size_t>(chunk.header.size));
  const fvv_input input = file.input();
  const bool is_read = bytes.empty() || input.read_at(input.user, chunk.offset + layout::chunk_header::size,
                                                      bytes.data(), bytes.size()) == FVV_OK;
  if (!is_read) throw Error(file.path(), "cannot read");
  // What changed since must not get a CRC that matches (FVV-9006).
  if (fvv_crc32c(0, bytes.data(), bytes.size()) != chunk.header.payload_crc)
    throw Error(file.path(), "changes while it is read");
  return bytes;
}

} // namespace fvv::recover
