// Push decoding to whole frames: any split gives the same ones, in both modes, after a seek and a late join.
#include "../fuzz.h"

#include "stream/frames.h"

#include <algorithm>
#include <vector>

namespace {

struct Outcome {
  uint32_t crc = 0;
  fvv_status status = FVV_OK;
};

void note(Outcome &outcome, const fvv_frames_event &event) {
  uint64_t numbers[] = {uint64_t(event.kind), event.offset, uint64_t(event.time), event.chunk_count,
                        event.skipped};
  // Eager or not, and whatever the split, GROUP_END and FRAME have the same content; other fields are unset.
  if (event.kind != FVV_FRAMES_FRAME && event.kind != FVV_FRAMES_BETWEEN && event.kind != FVV_FRAMES_GROUP)
    numbers[2] = 0;
  if (event.kind != FVV_FRAMES_FRAME && event.kind != FVV_FRAMES_BETWEEN) numbers[3] = 0;
  if (event.kind != FVV_FRAMES_DAMAGE) numbers[4] = 0;
  outcome.crc = fvv_crc32c(outcome.crc, numbers, sizeof numbers);
  if (event.kind == FVV_FRAMES_CONFIGURATION)
    fuzz::expect(event.configuration != nullptr, "there is a configuration");
  for (size_t i = 0; i < size_t(numbers[3]); i++) {
    const fvv_frame_chunk &chunk = event.chunks[i];
    fuzz::expect(chunk.header.time == event.time, "chunks of a frame have its time");
    if (!chunk.payload) continue;
    fuzz::expect(fvv_crc32c(0, chunk.payload, size_t(chunk.header.size)) == chunk.header.payload_crc,
                 "payloads of frames have their CRC");
  }
}

Outcome read(fvv_frames *frames, const uint8_t *data, size_t size, fuzz::Random *split) {
  Outcome outcome;
  // Byte by byte if it is short, in small portions or in large ones.
  const uint32_t mosts[] = {1, 40, 700, 9000},
                 most = split ? mosts[size < 1000 ? split->below(4) : 1 + split->below(3)] : 0;
  size_t at = 0;
  bool finished = false;
  for (;;) {
    fvv_frames_event event;
    outcome.status = fvv_frames_next(frames, &event, nullptr);
    if (outcome.status == FVV_OK) {
      note(outcome, event);
    } else if (outcome.status != FVV_NEED_DATA) {
      break;
    } else if (at == size) {
      fuzz::expect(!finished, "after finish nothing more is needed");
      finished = true;
      fvv_frames_finish(frames);
    } else {
      const size_t left = size - at, step = split ? std::min<size_t>(left, 1 + split->below(most)) : left;
      const fuzz::Bytes part(data + at, data + at + step);
      fuzz::expect_status(fvv_frames_push(frames, part.data(), step));
      at += step;
    }
  }
  fuzz::expect_status(outcome.status);
  return outcome;
}

} // namespace

FVV_FUZZ_TARGET(frames, fuzz::Form::stream) {
  fuzz::Random random(fuzz::digest(data, size));
  fvv_frames_options options;
  fvv_frames_options_default(&options);
  options.eager = random.below(2) != 0;
  const bool analyses = random.below(4) == 0;
  const bool join = random.below(4) == 0;
  std::vector<uint16_t> left_out(random.below(4));
  for (uint16_t &track : left_out) track = uint16_t(random.below(12));
  Outcome outcomes[2];
  for (int i = 0; i < 2; i++) {
    fvv_frames *frames = nullptr;
    fuzz::expect(fvv_frames_create(&options, nullptr, nullptr, &frames) == FVV_OK, "frames are created");
    if (analyses) fvv_frames_analyse(frames);
    fuzz::expect(fvv_frames_leave_out(frames, left_out.data(), left_out.size()) == FVV_OK,
                 "tracks are left out");
    if (join) fuzz::expect(fvv_frames_join(frames) == FVV_OK, "new frames join");
    outcomes[i] = read(frames, data, size, i ? &random : nullptr);
    if (i && outcomes[i].status == FVV_END) {
      // From the beginning, and from any place, as after a seek of a player.
      const bool again = fvv_frames_missed_groups(frames) != 0;
      const size_t from = again ? 0 : random.below(uint32_t(size) + 1) / 8 * 8;
      const fvv_configuration *known = again ? nullptr : fvv_frames_configuration(frames);
      if (fvv_frames_seek(frames, from, known) == FVV_OK)
        (void)read(frames, data + from, size - from, &random);
    }
    fvv_frames_destroy(frames);
  }
  fuzz::expect(outcomes[0].status == outcomes[1].status && outcomes[0].crc == outcomes[1].crc,
               "any split of the bytes gives the same frames");
}
