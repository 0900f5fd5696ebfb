// Chunks of the input: what their headers say, and their payloads read again.
#pragma once

#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"
#include "fvv_cxx/layout.h"

#include <vector>

namespace fvv::recover {

using Place = layout::ChunkPlace;
Place place_of(uint32_t type, uint8_t flags);

// Whether flags, track and time are those of the type (clauses 4.2 and 4.6): a writer would put right what is
// not, and the bytes of a group must not change unnoticed.
bool is_regular(const fvv_chunk_header &header);

// Sound and environments last longer than the frame whose time they have: frames are whole without them.
inline bool is_of_frame(const fvv_chunk_header &header) {
  return header.track && header.type != FVV_CHUNK_AUDIO && header.type != FVV_CHUNK_ENVIRONMENT;
}
inline bool makes_frame(const fvv_chunk_header &header) {
  return header.type == FVV_CHUNK_MESH || header.type == FVV_CHUNK_VIDEO_PACKET;
}

// A chunk whose header is intact.
struct Chunk {
  fvv_chunk_header header;
  uint64_t offset; // of the header
  bool intact;     // the payload, too
};

// Continues the digest of a block or the chain of a group (clauses 5 and 6.3).
uint32_t continue_chain(uint32_t crc, const fvv_chunk_header &header);

class Payloads {
public:
  explicit Payloads(const InputFile &input) : file(input) {}
  // Valid until the next call. Throws Error when the CRC does not match: it did when the chunk was found.
  const std::vector<uint8_t> &read(const Chunk &chunk);

private:
  const InputFile &file;
  std::vector<uint8_t> bytes;
};

} // namespace fvv::recover
