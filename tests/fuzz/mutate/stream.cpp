#include "mutate.h"

extern "C" {
#include "base/bytes.h"
#include "base/layout.h"
#include "container/header.h"
}

#include "fvv/format.h"

#include <algorithm>
#include <map>
#include <utility>

namespace fuzz {

namespace {

constexpr size_t file_header = 24, chunk_header = 32;

struct Chunk {
  uint8_t header[chunk_header];
  Bytes payload;

  uint32_t type() const { return fvv_get_u32(header); }
  void set_size() { fvv_put_u64(header + 16, payload.size()); }
  void sign() {
    fvv_put_u32(header + 24, fvv_crc32c(0, payload.data(), payload.size()));
    fvv_put_u32(header + 28, fvv_crc32c(0, header, 28));
  }
  size_t extent() const { return (chunk_header + payload.size() + 7) / 8 * 8; }
};

struct Stream {
  Bytes header;
  std::vector<Chunk> chunks;
};

// By the sizes in the headers; what does not fit is cut to what is there.
Stream split(const Bytes &bytes) {
  Stream out;
  out.header.assign(bytes.begin(), bytes.begin() + ptrdiff_t(std::min(file_header, bytes.size())));
  for (size_t at = file_header; at < bytes.size();) {
    Chunk chunk = {};
    const size_t left = bytes.size() - at, head = std::min(chunk_header, left);
    std::memcpy(chunk.header, bytes.data() + at, head);
    const uint64_t size = fvv_get_u64(chunk.header + 16);
    const size_t taken = size < left - head ? size_t(size) : left - head;
    const uint8_t *payload = bytes.data() + at + head;
    chunk.payload.assign(payload, payload + taken);
    at += std::min(left, chunk.extent());
    out.chunks.push_back(std::move(chunk));
  }
  return out;
}

Bytes join(const Stream &stream) {
  Bytes out = stream.header;
  for (const Chunk &chunk : stream.chunks) {
    const size_t begin = out.size();
    out.insert(out.end(), chunk.header, chunk.header + chunk_header);
    out.insert(out.end(), chunk.payload.begin(), chunk.payload.end());
    out.resize(begin + chunk.extent());
  }
  return out;
}

void append_u32(Bytes &out, uint32_t value) {
  out.resize(out.size() + 4);
  fvv_put_u32(out.data() + out.size() - 4, value);
}
void append_u64(Bytes &out, uint64_t value) {
  out.resize(out.size() + 8);
  fvv_put_u64(out.data() + out.size() - 8, value);
}
void append_uleb(Bytes &out, uint64_t value) {
  for (; value > 127; value >>= 7) out.push_back(uint8_t(value & 127) | 128);
  out.push_back(uint8_t(value));
}

// Follows a stream from chunk to chunk and makes right what depends on others.
class Repairer {
public:
  void chunk(Chunk &chunk) {
    const uint32_t type = chunk.type();
    if (type == FVV_CHUNK_SCENE || type == FVV_CHUNK_GROUP || type == FVV_CHUNK_INDEX) counter_ = 0;
    chunk.header[5] = counter_++;
    if (type == FVV_CHUNK_SCENE) begin_block();
    if (type == FVV_CHUNK_GROUP) begin_group(chunk);
    if (type == FVV_CHUNK_GROUP_END) end_group(chunk);
    if (type == FVV_CHUNK_INDEX) index(chunk);
    if (type == FVV_CHUNK_FOOTER) footer(chunk);
    chunk.set_size();
    chunk.sign();
    if (in_group_) {
      chain_ = fvv_crc32c(chain_, chunk.header, 28);
      count_++;
      if (type != FVV_CHUNK_GROUP) member(chunk);
    } else if (in_block_) {
      digest_ = fvv_crc32c(digest_, chunk.header, 28);
    }
    position_ += chunk.extent();
    if (type == FVV_CHUNK_GROUP_END && !groups_.empty())
      groups_.back().size = position_ - groups_.back().offset;
  }

private:
  struct Row {
    uint32_t type;
    uint16_t track;
    uint8_t flags;
    bool operator==(const Row &other) const {
      return type == other.type && track == other.track && flags == other.flags;
    }
  };
  struct Block {
    uint64_t offset, size;
    uint32_t digest;
  };
  struct Group {
    uint64_t offset, size;
    int64_t start, end;
    uint32_t sequence, frames, chain, end_size, block;
  };

  void begin_block() {
    in_group_ = false;
    in_block_ = true;
    digest_ = 0;
    block_offset_ = position_;
  }

  void begin_group(Chunk &chunk) {
    if (in_block_) blocks_.push_back({block_offset_, position_ - block_offset_, digest_});
    in_block_ = false;
    in_group_ = true;
    chain_ = count_ = 0;
    rows_.clear();
    table_.clear();
    times_.clear();
    chunk.payload.resize(FVV_GRUP_SIZE);
    uint8_t *payload = chunk.payload.data();
    fvv_put_u32(payload + FVV_GRUP_SEQUENCE, sequence_);
    fvv_put_u32(payload + FVV_GRUP_CONFIGURATION_CRC, digest_);
    start_ = last_time_ = fvv_get_i64(payload + FVV_GRUP_START);
    end_ = fvv_get_i64(payload + FVV_GRUP_END);
    fvv_put_i64(chunk.header + 8, start_);
    group_offset_ = position_;
  }

  void member(const Chunk &chunk) {
    const Row row = {chunk.type(), fvv_get_u16(chunk.header + 6), chunk.header[4]};
    size_t index = size_t(std::find(rows_.begin(), rows_.end(), row) - rows_.begin());
    if (index == rows_.size()) rows_.push_back(row);
    const int64_t time = fvv_get_i64(chunk.header + 8);
    const uint64_t difference = uint64_t(time) - uint64_t(last_time_);
    append_uleb(table_, index);
    append_uleb(table_, chunk.payload.size());
    append_uleb(table_, (difference << 1) ^ (difference >> 63 ? UINT64_MAX : 0));
    last_time_ = time;
    const bool makes_frame = row.type == FVV_CHUNK_MESH || row.type == FVV_CHUNK_VIDEO_PACKET;
    if (makes_frame && std::find(times_.begin(), times_.end(), time) == times_.end()) times_.push_back(time);
  }

  void end_group(Chunk &chunk) {
    if (!in_group_) return;
    in_group_ = false;
    Bytes &payload = chunk.payload;
    payload.clear();
    for (const uint32_t value : {sequence_, count_, chain_, uint32_t(times_.size()), uint32_t(rows_.size()),
                                 uint32_t(table_.size())})
      append_u32(payload, value);
    for (const Row &row : rows_) {
      append_u32(payload, row.type);
      append_u32(payload, uint32_t(row.track) | uint32_t(row.flags) << 16);
    }
    payload.insert(payload.end(), table_.begin(), table_.end());
    fvv_put_i64(chunk.header + 8, end_);
    groups_.push_back({group_offset_, 0, start_, end_, sequence_, uint32_t(times_.size()), chain_,
                       uint32_t(chunk.extent()), blocks_.empty() ? 0 : uint32_t(blocks_.size() - 1)});
    sequence_++;
  }

  void index(Chunk &chunk) {
    in_group_ = in_block_ = false;
    index_offset_ = position_;
    Bytes &payload = chunk.payload;
    payload.clear();
    append_u32(payload, uint32_t(groups_.size()));
    append_u32(payload, uint32_t(blocks_.size()));
    for (const Block &block : blocks_) {
      append_u64(payload, block.offset);
      append_u32(payload, uint32_t(block.size));
      append_u32(payload, block.digest);
    }
    for (const Group &group : groups_) {
      for (const uint64_t value : {group.offset, group.size, uint64_t(group.start), uint64_t(group.end)})
        append_u64(payload, value);
      for (const uint32_t value : {group.sequence, group.frames, group.chain, group.end_size, group.block})
        append_u32(payload, value);
    }
    index_crc_ = fvv_crc32c(0, payload.data(), payload.size());
  }

  void footer(Chunk &chunk) {
    chunk.payload.assign(FVV_FOOT_SIZE, 0);
    uint8_t *payload = chunk.payload.data();
    fvv_put_u64(payload + FVV_FOOT_INDEX_OFFSET, index_offset_);
    fvv_put_u64(payload + FVV_FOOT_FILE_SIZE, position_ + chunk.extent());
    fvv_put_u32(payload + FVV_FOOT_INDEX_CRC, index_crc_);
  }

  uint64_t position_ = file_header;
  uint8_t counter_ = 0;
  bool in_block_ = false, in_group_ = false;
  uint64_t block_offset_ = 0, group_offset_ = 0, index_offset_ = 0;
  uint32_t digest_ = 0, chain_ = 0, count_ = 0, sequence_ = 0, index_crc_ = 0;
  int64_t start_ = 0, end_ = 0, last_time_ = 0;
  std::vector<Row> rows_;
  std::vector<int64_t> times_;
  Bytes table_;
  std::vector<Block> blocks_;
  std::vector<Group> groups_;
};

void repair(Stream &stream, Repair how) {
  if (how == Repair::none) return;
  if (stream.header.size() == file_header)
    fvv_put_u32(stream.header.data() + 20, fvv_crc32c(0, stream.header.data(), 20));
  Repairer repairer;
  for (Chunk &chunk : stream.chunks) {
    if (how == Repair::all) {
      repairer.chunk(chunk);
    } else {
      chunk.set_size();
      chunk.sign();
    }
  }
}

const uint32_t types[] = {
    FVV_CHUNK_SCENE,        FVV_CHUNK_TRACK,   FVV_CHUNK_METADATA,     FVV_CHUNK_CAMERA,
    FVV_CHUNK_VIDEO_CONFIG, FVV_CHUNK_TILES,   FVV_CHUNK_AUDIO_CONFIG, FVV_CHUNK_TEXTURING,
    FVV_CHUNK_GROUP,        FVV_CHUNK_MESH,    FVV_CHUNK_CALIBRATION,  FVV_CHUNK_VIDEO_PACKET,
    FVV_CHUNK_VISIBILITY,   FVV_CHUNK_COLOURS, FVV_CHUNK_ENVIRONMENT,  FVV_CHUNK_AUDIO,
    FVV_CHUNK_GROUP_END,    FVV_CHUNK_INDEX,   FVV_CHUNK_FOOTER,       0x7a7a7a7a};

// What is beyond the range of sums and products: of doubles, whose bits these are, and of times.
const uint64_t extremes[] = {
    0x6126c2d4256ffcc3, // 1e160: its square is infinite
    0xf8ffe30f61b37c72, // -6.9e274
    0x7fe1ccf385ebc8a0, // 1e308
    0x01a56e1fc2f8f359, // 1e-300
    0x0000000000000001, // the smallest
    0x7ff0000000000000, // infinite
    0x7ff8000000000000, // no number
    0x8000000000000000, // INT64_MIN, -0.0
    0x7fffffffffffffff, // INT64_MAX
    0x4000000000000001, // beyond half of that
};
uint64_t extreme(Random &random) {
  return extremes[random.below(sizeof extremes / sizeof *extremes)];
}

void mutate_header(Chunk &chunk, Random &random) {
  switch (random.below(6)) {
  case 0:
    fvv_put_u32(chunk.header, types[random.below(sizeof types / sizeof *types)]);
    break;
  case 1:
    chunk.header[4] ^= uint8_t(1 << random.below(4));
    break;
  case 2:
    fvv_put_u16(chunk.header + 6, uint16_t(random.below(8)));
    break;
  case 3:
    fvv_put_u64(chunk.header + 8, fvv_get_u64(chunk.header + 8) + random.below(9) - 4);
    break;
  case 4:
    fvv_put_u64(chunk.header + 8, extreme(random));
    break;
  default:
    chunk.header[random.below(24)] ^= uint8_t(1 << random.below(8));
  }
}

void mutate_payload(Chunk &chunk, Random &random, MutateBytes mutate) {
  static const uint32_t odd[] = {0, 1, 2, 0x7f, 0x80, 0xff, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff};
  Bytes &payload = chunk.payload;
  if (payload.size() >= 4 && !random.below(4)) {
    const size_t at = random.below(uint32_t(std::min<size_t>(payload.size() - 3, 128)));
    const uint32_t value =
        random.below(2) ? odd[random.below(10)] : fvv_get_u32(payload.data() + at) + random.below(5) - 2;
    fvv_put_u32(payload.data() + at, value);
    return;
  }
  if (payload.size() >= 8 && !random.below(6)) {
    const size_t places = std::min<size_t>((payload.size() - 8) / 4 + 1, 128);
    fvv_put_u64(payload.data() + 4 * size_t(random.below(uint32_t(places))), extreme(random));
    return;
  }
  const size_t size = payload.size();
  payload.resize(size + 64);
  payload.resize(mutate(payload.data(), size, payload.size()));
}

void mutate_order(std::vector<Chunk> &chunks, Random &random) {
  const uint32_t count = uint32_t(chunks.size()), i = random.below(count), k = random.below(count);
  switch (random.below(4)) {
  case 0:
    chunks.erase(chunks.begin() + i);
    break;
  case 1: {
    const Chunk copy = chunks[i];
    chunks.insert(chunks.begin() + k, copy);
    break;
  }
  case 2:
    std::swap(chunks[i], chunks[k]);
    break;
  default:
    if (chunks[i].type() == chunks[k].type())
      chunks[i].payload = chunks[k].payload;
    else
      std::swap(chunks[i], chunks[std::min(i + 1, count - 1)]);
  }
}

} // namespace

Bytes repair_stream(const Bytes &bytes, Repair how) {
  Stream stream = split(bytes);
  repair(stream, how);
  return join(stream);
}

Bytes mutate_stream(const Bytes &bytes, size_t capacity, Random &random, MutateBytes mutate) {
  Stream stream = split(bytes);
  if (stream.chunks.empty() || !random.below(12)) {
    Bytes out = bytes;
    out.resize(std::max(capacity, bytes.size()));
    out.resize(mutate(out.data(), bytes.size(), capacity));
    return out;
  }
  for (uint32_t edits = 1 + random.below(3); edits && !stream.chunks.empty(); edits--) {
    Chunk &chunk = stream.chunks[random.below(uint32_t(stream.chunks.size()))];
    const uint32_t what = random.below(10);
    if (what < 7)
      mutate_payload(chunk, random, mutate);
    else if (what < 8)
      mutate_header(chunk, random);
    else
      mutate_order(stream.chunks, random);
  }
  const uint32_t how = random.below(10);
  repair(stream, how == 0 ? Repair::none : how < 3 ? Repair::checksums : Repair::all);
  Bytes out = join(stream);
  if (out.size() > capacity) out.resize(capacity);
  return out;
}

Bytes cross_streams(const Bytes &first, const Bytes &second, Random &random) {
  Stream a = split(first);
  const Stream b = split(second);
  a.chunks.resize(random.below(uint32_t(a.chunks.size()) + 1));
  const uint32_t from = random.below(uint32_t(b.chunks.size()) + 1);
  a.chunks.insert(a.chunks.end(), b.chunks.begin() + from, b.chunks.end());
  repair(a, random.below(4) ? Repair::all : Repair::checksums);
  return join(a);
}

} // namespace fuzz
