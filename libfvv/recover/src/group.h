// What a group had, what is left of it, and which part of that is of use.
#pragma once

#include "recover/src/chunk.h"

#include <optional>
#include <set>

namespace fvv::recover {

// Chunks of one group that are looked at, as in libfvv's default limits.
constexpr size_t most_chunks = size_t(1) << 20;

// GRUP, clause 6.1.
struct Head {
  uint32_t sequence, digest;
  int64_t start, end;
};
std::optional<Head> parse_head(const fvv_event &event);

// GEND, clause 6.3.
struct End {
  struct Row { // of the table: one chunk
    uint32_t type;
    uint16_t track;
    uint8_t flags;
    uint64_t size;
    int64_t difference; // ticks after the one before
  };
  uint32_t sequence, chunk_count, chain;
  int64_t time;
  std::vector<Row> table; // one row less than chunk_count
};
// Nothing where the payload does not have the form of clause 6.3.
std::optional<End> parse_end(const fvv_event &event);

// A chunk of the group, in its order.
struct Slot {
  Chunk chunk;     // of a chunk that is lost altogether: what the table says of it
  bool usable;     // it is there, and nothing is wrong with it
  bool gap_before; // an unknown number of chunks is missing before it
};

struct Slots {
  std::vector<Slot> slots;
  bool gap_after = false; // chunks may be missing at the end
  bool is_whole() const;
  bool has_gaps() const;
  // Frames that the group had; at least these if it has gaps.
  std::set<int64_t> frames() const;
};

// found: chunks with intact headers, of times within the group, in order of the file; some may be there twice
// or in another order. end: of the group; end_counter: of its GEND, whose payload may be damaged.
Slots arrange(const std::vector<Chunk> &found, int64_t start, const std::optional<End> &end,
              std::optional<uint8_t> end_counter);

// The head of a group whose GRUP is lost, proven by the chain in its GEND: with it and every header in found,
// in the order of the table, the chain is that of the group. Nothing where it is not.
std::optional<Head> prove_head(const std::vector<Chunk> &found, const End &end,
                               const std::vector<uint32_t> &digests);

// A chunk to write.
struct Part {
  size_t slot;
  int64_t time; // that of the slot, but for a layout that moves to the first sample that is left
};
// What is whole and has all that it depends on. tiled: video tracks that show tiles.
std::vector<Part> select(const Slots &slots, const std::set<uint16_t> &tiled);

} // namespace fvv::recover
