#include "fvvdemux/survey.h"

#include <memory>

namespace fvv::demux {

namespace {

constexpr size_t block_size = 1 << 18;

// The group that is being read, and its frame whose chunks are coming.
struct Reading {
  Survey::Group *group;
  bool in_group = false, certain = false, frame_open = false;
  int64_t frame_time = 0;

  // A frame is whole once something behind it has come while nothing was missing.
  void close_frame() {
    if (frame_open && certain) group->whole++;
    frame_open = false;
  }
};

} // namespace

Survey::Survey(const cli::InputFile &file) {
  fvv_reader *created = nullptr;
  cli::check(fvv_reader_create(nullptr, nullptr, 0, &created), file.path(), {});
  const std::unique_ptr<fvv_reader, decltype(&fvv_reader_destroy)> reader(created, fvv_reader_destroy);
  Reading reading = {&groups[0]};
  const auto take = [&](const fvv_event &event) {
    if (event.kind == FVV_EVENT_DAMAGE) {
      fvv_diagnostic &place = reading.in_group ? reading.group->reason : reading.group->behind;
      if (place.status == FVV_OK) place = event.diagnostic;
      return;
    }
    if (event.kind != FVV_EVENT_CHUNK) return;
    const uint32_t type = event.chunk.type;
    if (type == FVV_CHUNK_GROUP) {
      reading = {&groups[event.offset], true, event.group_intact != 0};
    } else if (reading.in_group &&
               (type == FVV_CHUNK_GROUP_END || type == FVV_CHUNK_SCENE || type == FVV_CHUNK_INDEX)) {
      reading.certain = reading.certain && event.group_intact && type == FVV_CHUNK_GROUP_END;
      reading.close_frame();
      reading.in_group = false;
    } else if (reading.in_group && event.chunk.track) {
      reading.certain = reading.certain && event.group_intact;
      if (reading.frame_open && reading.frame_time == event.chunk.time) return;
      reading.close_frame();
      reading.frame_open = true;
      reading.frame_time = event.chunk.time;
    }
  };
  const fvv_input input = file.input();
  fvv_diagnostic diagnostic = {};
  fvv_event event;
  std::vector<uint8_t> block(block_size);
  fvv_status status = FVV_NEED_DATA;
  for (uint64_t at = 0; status == FVV_NEED_DATA && at < input.size;) {
    const size_t part = input.size - at < block_size ? size_t(input.size - at) : block_size;
    if (input.read_at(input.user, at, block.data(), part) != FVV_OK)
      throw cli::Failure(file.path() + ": cannot read");
    cli::check(fvv_reader_push(reader.get(), block.data(), part), file.path(), {});
    while ((status = fvv_reader_next(reader.get(), &event, &diagnostic)) == FVV_OK) take(event);
    at += part;
  }
  fvv_reader_finish(reader.get());
  while (status >= 0 && (status = fvv_reader_next(reader.get(), &event, &diagnostic)) == FVV_OK) take(event);
  // An error of the stream ends what is certain; what is behind counts as lost.
  if (status < 0 && status > FVV_ERROR_DAMAGED) cli::check(status, file.path(), diagnostic);
  if (status < 0 && reading.group->reason.status == FVV_OK) reading.group->reason = diagnostic;
}

Survey::Group Survey::group(uint64_t offset) const {
  const auto next = groups.upper_bound(offset);
  const auto found = std::prev(next); // there is one: key 0
  if (found->first == offset) return found->second;
  Group lost;
  lost.reason = found->second.behind.status ? found->second.behind : found->second.reason;
  return lost;
}

} // namespace fvv::demux
