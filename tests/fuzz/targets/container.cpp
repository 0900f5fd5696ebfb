// The push reader: any split of the bytes gives the same events, and payloads are what their CRCs cover.
#include "../fuzz.h"

#include "fvv/container.h"

#include <algorithm>

namespace {

struct Outcome {
  uint32_t crc = 0; // of all events
  size_t events = 0;
  fvv_status status = FVV_OK;
};

void note(Outcome &outcome, const fvv_event &event) {
  // Fields that are not set for a kind of event are left out.
  const bool damage = event.kind == FVV_EVENT_DAMAGE, chunk = event.kind == FVV_EVENT_CHUNK;
  const uint64_t numbers[] = {uint64_t(event.kind),        event.offset,
                              damage ? event.skipped : 0,  damage && event.has_chunk,
                              chunk && event.group_intact, damage ? event.diagnostic.issue : 0};
  outcome.crc = fvv_crc32c(outcome.crc, numbers, sizeof numbers);
  outcome.events++;
  if (event.kind != FVV_EVENT_CHUNK) return;
  fuzz::expect(reinterpret_cast<uintptr_t>(event.payload) % 8 == 0, "payloads are aligned");
  fuzz::expect(fvv_crc32c(0, event.payload, size_t(event.chunk.size)) == event.chunk.payload_crc,
               "intact payloads have their CRC");
  outcome.crc = fvv_crc32c(outcome.crc, &event.chunk.type, sizeof event.chunk.type);
}

Outcome read(const uint8_t *data, size_t size, fuzz::Random *split, bool join) {
  Outcome outcome;
  fvv_reader *reader = nullptr;
  fuzz::expect(fvv_reader_create(nullptr, nullptr, 0, &reader) == FVV_OK, "a reader is created");
  if (join) fuzz::expect(fvv_reader_join(reader) == FVV_OK, "a new reader joins");
  // Byte by byte if it is short, in small portions or in large ones.
  const uint32_t mosts[] = {1, 40, 700, 9000},
                 most = split ? mosts[size < 1000 ? split->below(4) : 1 + split->below(3)] : 0;
  size_t at = 0;
  for (;;) {
    fvv_event event;
    fvv_diagnostic diagnostic;
    outcome.status = fvv_reader_next(reader, &event, &diagnostic);
    if (outcome.status == FVV_OK) {
      note(outcome, event);
    } else if (outcome.status != FVV_NEED_DATA) {
      break;
    } else if (at == size) {
      fvv_reader_finish(reader);
    } else {
      const size_t left = size - at, step = split ? std::min<size_t>(left, 1 + split->below(most)) : left;
      const fuzz::Bytes part(data + at, data + at + step);
      fuzz::expect_status(fvv_reader_push(reader, part.data(), part.size()));
      at += step;
    }
  }
  fuzz::expect_status(outcome.status);
  fvv_event event;
  fuzz::expect(fvv_reader_next(reader, &event, nullptr) == outcome.status, "the last result repeats");
  fvv_reader_destroy(reader);
  return outcome;
}

} // namespace

FVV_FUZZ_TARGET(container, fuzz::Form::stream) {
  fuzz::Random split(fuzz::digest(data, size));
  const bool join = split.below(4) == 0;
  const Outcome whole = read(data, size, nullptr, join), parts = read(data, size, &split, join);
  fuzz::expect(whole.status == parts.status && whole.crc == parts.crc && whole.events == parts.events,
               "any split of the bytes gives the same events");
}
