// The checker in all ways of use: with and without decoding, in portions, and a second reading.
#include "../fuzz.h"

#include "fvv/stream.h"

#include <algorithm>

namespace {

void count_events(void *user, const fvv_event *event) {
  fuzz::expect(event != nullptr, "the callback gets an event");
  ++*static_cast<size_t *>(user);
}

// What fvv_checker_finish returns.
fvv_status push_all(fvv_checker *checker, const uint8_t *data, size_t size, fuzz::Random &random) {
  for (size_t at = 0; at < size;) {
    const size_t step = std::min<size_t>(size - at, 1 + random.below(4096));
    const fuzz::Bytes part(data + at, data + at + step);
    fuzz::expect_status(fvv_checker_push(checker, part.data(), step));
    at += step;
  }
  const fvv_status status = fvv_checker_finish(checker);
  fuzz::expect_status(status);
  return status;
}

void look(const fvv_checker *checker) {
  const fvv_check_summary *summary = fvv_checker_summary(checker);
  fuzz::expect(summary->whole_frames <= summary->frames, "whole frames are frames");
  fuzz::expect(fvv_checker_problem_count(checker) <= summary->problems, "problems are counted");
  for (size_t i = 0; i < fvv_checker_problem_count(checker); i++) {
    char line[300];
    const fvv_diagnostic *problem = fvv_checker_problem(checker, i);
    fuzz::expect(problem->status < 0, "a problem has a status");
    fuzz::expect(std::memchr(problem->message, 0, sizeof problem->message), "messages end");
    (void)fvv_diagnostic_format(problem, "input", line, sizeof line);
  }
  uint64_t whole = 0;
  for (size_t i = 0; i < fvv_checker_run_count(checker); i++) whole += fvv_checker_run(checker, i)->count;
  fuzz::expect(whole == summary->whole_frames, "runs are the whole frames");
  for (size_t i = 0; i < fvv_checker_track_count(checker); i++)
    fuzz::expect(fvv_checker_track(checker, i) != nullptr, "there is each track");
}

} // namespace

FVV_FUZZ_TARGET(checker, fuzz::Form::stream) {
  fuzz::Random random(fuzz::digest(data, size));
  size_t events = 0;
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = random.below(8) != 0;
  options.event = count_events;
  options.user = &events;
  fvv_checker *checker = nullptr;
  fuzz::expect(fvv_checker_create(&options, nullptr, nullptr, &checker) == FVV_OK, "a checker is created");
  const fvv_status status = push_all(checker, data, size, random);
  look(checker);
  if (status == FVV_NEED_DATA) {
    fuzz::expect(push_all(checker, data, size, random) != FVV_NEED_DATA, "two readings are enough");
    look(checker);
  }
  fvv_checker_destroy(checker);
}
