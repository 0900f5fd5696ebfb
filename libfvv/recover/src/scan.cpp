#include "recover/src/scan.h"

#include "fvv_cxx/untrusted.h"

#include <algorithm>

namespace fvv::recover {

Scanner::Scanner(const InputFile &input, const std::function<void(uint64_t)> &on_progress)
    : file(input), progress(on_progress), reader(nullptr, fvv_reader_destroy), portion(size_t(1) << 18) {
  begin(0);
}

void Scanner::begin(uint64_t at) {
  fvv_reader *created = nullptr;
  if (fvv_reader_create(nullptr, nullptr, at, &created) != FVV_OK) throw std::bad_alloc();
  reader.reset(created);
  offset = at;
}

// False at the end of the file.
bool Scanner::push() {
  const uint64_t left = file.size() - std::min(offset, file.size());
  const auto size = static_cast<size_t>(std::min<uint64_t>(left, portion.size()));
  if (!size) return false;
  const fvv_input input = file.input();
  if (input.read_at(input.user, offset, portion.data(), size) != FVV_OK)
    throw Error(file.path(), "cannot read");
  if (fvv_reader_push(reader.get(), portion.data(), size) != FVV_OK) throw std::bad_alloc();
  if (progress) progress(size);
  offset += size;
  return true;
}

bool Scanner::next(fvv_event &event) {
  for (;;) {
    fvv_diagnostic why = {};
    const fvv_status status = fvv_reader_next(reader.get(), &event, &why);
    if (status == FVV_OK && event.kind == FVV_EVENT_HEADER) {
      std::array<uint8_t, layout::file_header::size> bytes;
      const fvv_input input = file.input();
      if (input.read_at(input.user, 0, bytes.data(), bytes.size()) == FVV_OK) header = bytes;
    }
    if (status == FVV_OK) return true;
    if (status == FVV_END) return false;
    if (status == FVV_NEED_DATA) {
      if (!push()) fvv_reader_finish(reader.get());
    } else if (status == FVV_ERROR_MEMORY) {
      throw std::bad_alloc();
    } else if (why.issue == FVV_ISSUE_SIGNATURE && file.size() > 1) {
      // Without its beginning, too, a file has chunks: one is looked for at every byte.
      begin(1);
    } else {
      stop = why;
      return false;
    }
  }
}

namespace {

// Puts blocks together as they pass.
class Blocks {
public:
  explicit Blocks(std::map<uint32_t, Block> &all) : known(all) {}
  void add(const Chunk &chunk) {
    const Place place = place_of(chunk.header.type, chunk.header.flags);
    if (chunk.header.type == FVV_CHUNK_SCENE) {
      close();
      is_open = true;
    }
    if (place != Place::configuration && place != Place::unknown) close();
    if (!is_open) return;
    is_good = is_good && is_regular(chunk.header);
    block.digest = continue_chain(block.digest, chunk.header);
    if (chunk.header.type == FVV_CHUNK_TILES) block.tiled.insert(chunk.header.track);
    block.chunks.push_back(chunk);
  }
  void close() {
    if (is_open && is_good) known.emplace(block.digest, block);
    is_open = false;
    is_good = true;
    block = Block();
  }

private:
  std::map<uint32_t, Block> &known;
  Block block;
  bool is_open = false, is_good = true;
};

void read_index(const fvv_event &event, Survey &out) {
  namespace at = layout::indx;
  namespace of_block = layout::indx_block;
  namespace of_entry = layout::indx_entry;
  const uint8_t *payload = event.payload;
  const uint64_t size = event.chunk.size;
  if (size < at::size) return;
  const uint64_t groups = load_u32(payload + at::group_count);
  const uint64_t blocks = load_u32(payload + at::block_count);
  if (size != at::size + blocks * of_block::size + groups * of_entry::size) return;
  const uint8_t *entry = payload + at::size + blocks * of_block::size;
  uint64_t frames = 0;
  for (uint64_t i = 0; i < groups; i++, entry += of_entry::size)
    frames += load_u32(entry + of_entry::frame_count);
  out.frames = frames;
  out.groups = groups;
}

} // namespace

Survey survey(const InputFile &file, const std::function<void(uint64_t)> &progress) {
  Survey out;
  Scanner scanner(file, progress);
  Blocks blocks(out.blocks);
  fvv_event event;
  uint64_t indices = 0;
  while (scanner.next(event)) {
    if (event.kind != FVV_EVENT_CHUNK) continue;
    blocks.add({event.chunk, event.offset, true});
    if (event.chunk.type != FVV_CHUNK_INDEX) continue;
    indices++;
    read_index(event, out);
  }
  blocks.close();
  // Of files that were joined, no index describes the whole.
  if (indices > 1) out.frames = out.groups = std::nullopt;
  return out;
}

} // namespace fvv::recover
