#include "fvvdemux/survey.h"

#include "fvv/frames.h"

#include <memory>

namespace fvv::demux {

namespace {

constexpr size_t block_size = 1 << 18;

} // namespace

Survey::Survey(const cli::InputFile &file) {
  // A frame counts once something that follows it has come while nothing was missing.
  fvv_frames_options options;
  fvv_frames_options_default(&options);
  options.eager = 0;
  options.detail = 1;
  fvv_frames *created = nullptr;
  cli::check(fvv_frames_create(&options, nullptr, nullptr, &created), file.path(), {});
  const std::unique_ptr<fvv_frames, decltype(&fvv_frames_destroy)> frames(created, fvv_frames_destroy);
  Group *group = &groups[0];
  bool in_group = false;
  const auto take = [&](const fvv_frames_event &event) {
    if (event.kind == FVV_FRAMES_GROUP) {
      group = &groups[event.offset];
      in_group = true;
    } else if (event.kind == FVV_FRAMES_GROUP_END) {
      in_group = false;
    } else if (event.kind == FVV_FRAMES_FRAME) {
      group->whole += event.whole != 0;
    } else if (event.kind == FVV_FRAMES_DAMAGE) {
      fvv_diagnostic &place = in_group ? group->reason : group->behind;
      if (place.status == FVV_OK) place = event.diagnostic;
    }
  };
  const fvv_input input = file.input();
  fvv_diagnostic diagnostic = {};
  fvv_frames_event event;
  std::vector<uint8_t> block(block_size);
  fvv_status status = FVV_NEED_DATA;
  for (uint64_t at = 0; status == FVV_NEED_DATA && at < input.size;) {
    const size_t part = input.size - at < block_size ? size_t(input.size - at) : block_size;
    if (input.read_at(input.user, at, block.data(), part) != FVV_OK)
      throw cli::Failure(file.path() + ": cannot read");
    cli::check(fvv_frames_push(frames.get(), block.data(), part), file.path(), {});
    while ((status = fvv_frames_next(frames.get(), &event, &diagnostic)) == FVV_OK) take(event);
    at += part;
  }
  fvv_frames_finish(frames.get());
  while (status >= 0 && (status = fvv_frames_next(frames.get(), &event, &diagnostic)) == FVV_OK) take(event);
  // An error of the stream ends what is certain; what follows counts as lost.
  if (status < 0 && status > FVV_ERROR_DAMAGED) cli::check(status, file.path(), diagnostic);
  if (status < 0 && group->reason.status == FVV_OK) group->reason = diagnostic;
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
