// The chunks of a group in their order: by the table in GEND, or by times and counters.
#include "recover/src/group.h"

#include "fvv_cxx/untrusted.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace fvv::recover {

std::optional<Head> parse_head(const fvv_event &event) {
  namespace at = layout::grup;
  if (event.chunk.size != at::size || !is_regular(event.chunk)) return std::nullopt;
  const uint8_t *p = event.payload;
  const Head head = {load_u32(p + at::sequence), load_u32(p + at::configuration_crc), load_i64(p + at::start),
                     load_i64(p + at::end)};
  if (head.start >= head.end || head.start != event.chunk.time) return std::nullopt;
  return head;
}

std::optional<End> parse_end(const fvv_event &event) {
  namespace at = layout::gend;
  namespace of_kind = layout::gend_kind;
  const auto size = static_cast<size_t>(event.chunk.size);
  if (size < at::size || !is_regular(event.chunk)) return std::nullopt;
  const uint8_t *p = event.payload;
  End end = {load_u32(p + at::sequence),
             load_u32(p + at::chunk_count),
             load_u32(p + at::chain_crc),
             event.chunk.time,
             {}};
  const uint64_t kinds = load_u32(p + at::kind_count);
  const uint64_t table = load_u32(p + at::table_size);
  if (!end.chunk_count || end.chunk_count > most_chunks) return std::nullopt;
  if (at::size + kinds * of_kind::size + table != size) return std::nullopt;
  const size_t from = at::size + static_cast<size_t>(kinds) * of_kind::size;
  Cursor cursor = {p + from, size - from};
  while (cursor.position < cursor.size && !cursor.failed) {
    const uint64_t kind = cursor.uleb(), bytes = cursor.uleb();
    const int64_t difference = cursor.zigzag();
    if (cursor.failed || kind >= kinds) return std::nullopt;
    const uint8_t *k = p + at::size + kind * of_kind::size;
    end.table.push_back(
        {load_u32(k + of_kind::type), load_u16(k + of_kind::track), k[of_kind::flags], bytes, difference});
  }
  if (cursor.failed || end.table.size() + 1 != end.chunk_count) return std::nullopt;
  return end;
}

bool Slots::has_gaps() const {
  return gap_after || std::any_of(slots.begin(), slots.end(), [](const Slot &s) { return s.gap_before; });
}

bool Slots::is_whole() const {
  return !has_gaps() && std::all_of(slots.begin(), slots.end(), [](const Slot &s) { return s.usable; });
}

std::set<int64_t> Slots::frames() const {
  std::set<int64_t> times;
  for (const Slot &slot : slots)
    if (makes_frame(slot.chunk.header)) times.insert(slot.chunk.header.time);
  return times;
}

namespace {

int64_t later(int64_t time, int64_t difference) { // modulo 2^64, as in the table
  return static_cast<int64_t>(static_cast<uint64_t>(time) + static_cast<uint64_t>(difference));
}

int64_t earlier(int64_t time, int64_t difference) { // the inverse
  return static_cast<int64_t>(static_cast<uint64_t>(time) - static_cast<uint64_t>(difference));
}

using Key = std::tuple<int64_t, uint32_t, uint16_t, uint8_t, uint8_t, uint64_t>;

Key key_of(const fvv_chunk_header &h) {
  return {h.time, h.type, h.track, h.flags, h.counter, h.size};
}

// By the table, chunks are found wherever they are, and others are none of the group.
Slots by_table(const std::vector<Chunk> &found, int64_t start, const End &end) {
  std::map<Key, const Chunk *> chunks;
  for (const Chunk &chunk : found) {
    const Chunk *&place = chunks[key_of(chunk.header)];
    if (!place || (chunk.intact && !place->intact)) place = &chunk;
  }
  Slots out;
  int64_t time = start;
  for (size_t i = 0; i < end.table.size(); i++) {
    const End::Row &row = end.table[i];
    time = later(time, row.difference);
    fvv_chunk_header header = {};
    header.type = row.type;
    header.flags = row.flags;
    header.counter = static_cast<uint8_t>(i + 1);
    header.track = row.track;
    header.time = time;
    header.size = row.size;
    const auto at = chunks.find(key_of(header));
    const bool is_there = at != chunks.end();
    out.slots.push_back(
        {is_there ? *at->second : Chunk{header, 0, false}, is_there && at->second->intact, false});
  }
  return out;
}

struct Placed {
  Chunk chunk;
  int64_t number; // the counter without wrapping
  bool conflict;  // another chunk claims its place
};

bool is_before(const Placed &a, const Placed &b) {
  return std::make_pair(a.chunk.header.time, a.number) < std::make_pair(b.chunk.header.time, b.number);
}

// Chunks that are there twice, once; of two that claim one place it is not known which is the right one.
std::vector<Placed> without_copies(const std::vector<Placed> &sorted) {
  std::vector<Placed> out;
  std::map<std::pair<uint32_t, uint16_t>, size_t> here; // by type and track, of the current time
  for (const Placed &next : sorted) {
    const fvv_chunk_header &h = next.chunk.header;
    if (!out.empty() && out.back().chunk.header.time != h.time) here.clear();
    Placed *former = nullptr;
    if (!out.empty() && out.back().chunk.header.time == h.time && out.back().number == next.number)
      former = &out.back();
    // A track has at most one chunk of a known type at one time (FVV-1209).
    if (!former && place_of(h.type, h.flags) != Place::unknown) {
      const auto [place, is_new] = here.emplace(std::make_pair(h.type, h.track), out.size());
      if (!is_new) former = &out[place->second];
    }
    if (!former) {
      out.push_back(next);
      continue;
    }
    const fvv_chunk_header &other = former->chunk.header;
    if (other.header_crc != h.header_crc || key_of(other) != key_of(h))
      former->conflict = true;
    else if (!former->chunk.intact)
      former->chunk = next.chunk;
  }
  return out;
}

Slots by_counters(const std::vector<Chunk> &found, std::optional<uint8_t> end_counter) {
  std::vector<Placed> placed;
  int64_t number = 0; // of GRUP
  uint8_t counter = 0;
  for (const Chunk &chunk : found) {
    number += static_cast<int8_t>(static_cast<uint8_t>(chunk.header.counter - counter));
    counter = chunk.header.counter;
    placed.push_back({chunk, number, false});
  }
  std::stable_sort(placed.begin(), placed.end(), is_before);
  Slots out;
  counter = 0;
  for (const Placed &next : without_copies(placed)) {
    const uint8_t expected = static_cast<uint8_t>(counter + 1);
    counter = next.chunk.header.counter;
    out.slots.push_back({next.chunk, next.chunk.intact && !next.conflict, counter != expected});
  }
  out.gap_after = !end_counter || *end_counter != static_cast<uint8_t>(counter + 1);
  return out;
}

} // namespace

Slots arrange(const std::vector<Chunk> &found, int64_t start, const std::optional<End> &end,
              std::optional<uint8_t> end_counter) {
  const Slots counted = by_counters(found, end_counter);
  if (!end) return counted;
  // Of 256 missing chunks the counters show nothing. A table that merely contradicts all counters is wrong.
  const bool is_short = counted.slots.size() < end->table.size();
  return counted.has_gaps() || is_short ? by_table(found, start, *end) : counted;
}

std::optional<Head> prove_head(const std::vector<Chunk> &found, const End &end,
                               const std::vector<uint32_t> &digests) {
  if (end.table.empty()) return std::nullopt;
  const End::Row &row = end.table.front();
  const auto first = std::find_if(found.begin(), found.end(), [&](const Chunk &chunk) {
    const fvv_chunk_header &h = chunk.header;
    return h.counter == 1 && h.type == row.type && h.track == row.track && h.flags == row.flags &&
           h.size == row.size;
  });
  if (first == found.end()) return std::nullopt;
  Head head = {end.sequence, 0, earlier(first->header.time, row.difference), end.time};
  if (head.start >= head.end) return std::nullopt;
  const Slots slots = by_table(found, head.start, end);
  for (const uint32_t digest : digests) {
    head.digest = digest;
    namespace at = layout::grup;
    uint8_t payload[at::size];
    store_u32(payload + at::sequence, head.sequence);
    store_u32(payload + at::configuration_crc, digest);
    store_u64(payload + at::start, static_cast<uint64_t>(head.start));
    store_u64(payload + at::end, static_cast<uint64_t>(head.end));
    fvv_chunk_header group = {};
    group.type = FVV_CHUNK_GROUP;
    group.flags = FVV_FLAG_CRITICAL | FVV_FLAG_KEY;
    group.time = head.start;
    group.size = sizeof payload;
    group.payload_crc = fvv_crc32c(0, payload, sizeof payload);
    uint32_t chain = continue_chain(0, group);
    for (const Slot &slot : slots.slots) chain = continue_chain(chain, slot.chunk.header);
    if (chain == end.chain) return head;
  }
  return std::nullopt;
}

} // namespace fvv::recover
