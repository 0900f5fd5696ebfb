// The chunks of a file that is damaged anywhere, its file header included; and what is collected of them
// before groups are rebuilt.
#pragma once

#include "recover/src/chunk.h"

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>

namespace fvv::recover {

class Scanner {
public:
  Scanner(const InputFile &input, const std::function<void(uint64_t)> &on_progress);
  // The next event of fvv_reader; false: nothing further comes.
  bool next(fvv_event &event);
  // Why reading ended before the end of the file; status FVV_OK: it did not.
  const fvv_diagnostic &stopped() const { return stop; }
  // Of the file, if it is intact.
  const std::optional<std::array<uint8_t, 24>> &file_header() const { return header; }

private:
  void begin(uint64_t at);
  bool push();
  const InputFile &file;
  const std::function<void(uint64_t)> progress;
  std::unique_ptr<fvv_reader, void (*)(fvv_reader *)> reader;
  uint64_t offset = 0; // of the next byte to push
  std::vector<uint8_t> portion;
  fvv_diagnostic stop = {};
  std::optional<std::array<uint8_t, 24>> header;
};

// An intact configuration block.
struct Block {
  uint32_t digest = 0;
  std::vector<Chunk> chunks;
  std::set<uint16_t> tiled; // video tracks that show tiles
};

struct Survey {
  std::map<uint32_t, Block> blocks;       // by digest
  std::optional<uint64_t> frames, groups; // of the undamaged stream, by its index
};

Survey survey(const InputFile &file, const std::function<void(uint64_t)> &progress);

} // namespace fvv::recover
