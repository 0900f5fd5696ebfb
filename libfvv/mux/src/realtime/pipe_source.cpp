#include "mux/src/realtime/pipe_source.h"
#include "fvv_cxx/format.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <unistd.h>
#include <utility>

namespace fvv::mux {

namespace {

constexpr int look_again = 50; // milliseconds between looks at what may end a wait
// Places in a row without a frame: minutes, and far less than a description may count.
constexpr int64_t most_missing = 10'000;

// Of a frame that was filmed at a time of the system's clock.
Clock::time_point arrival_of(const FramePipe::Record &record) {
  const Clock::time_point now = Clock::now();
  if (!record.time) return now;
  using std::chrono::microseconds;
  const int64_t today =
      std::chrono::duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  constexpr int64_t hour = 3'600'000'000;
  if (record.time >= today) return now;
  return now - microseconds(record.time < today - hour ? hour : today - record.time);
}

} // namespace

size_t PipeBytes::read(void *bytes, size_t size) {
  const Clock::time_point start = Clock::now();
  while (true) {
    pollfd wait = {descriptor, POLLIN, 0};
    const int found = poll(&wait, 1, look_again);
    if (found < 0 && errno != EINTR)
      throw Error(name, std::string("cannot wait for it: ") + std::strerror(errno));
    if (found > 0) {
      const ssize_t count = ::read(descriptor, bytes, size);
      if (count > 0) return size_t(count);
      if (count < 0 && errno != EINTR && errno != EAGAIN)
        throw Error(name, std::string("cannot read: ") + std::strerror(errno));
      // Who stops a pipeline stops the writer too.
      if (count == 0 && !is_stopped()) return 0;
    }
    if (is_stopped()) throw Ended{FrameSource::Item::ended, "it was stopped"};
    if (seconds_of(Clock::now() - start) > idle)
      throw Ended{FrameSource::Item::given_up, fvv::format("no frame came for %g s", idle)};
  }
}

OpenPipe::OpenPipe(const std::string &shown, const RealtimeOptions &realtime,
                   const std::function<bool()> &is_stopped, const media::MemoryLimit &limit) try
    : bytes(shown, realtime.pipe, realtime.idle, is_stopped),
      frames([this](void *to, size_t size) { return bytes.read(to, size); }, shown, limit) {
} catch (const PipeBytes::Ended &ended) {
  throw Error(shown, "expected the description of a show: " + ended.reason);
}

PipeSource::PipeSource(std::unique_ptr<OpenPipe> from, const scene::Capture &restricted, const Options &given,
                       std::function<bool(Clock::time_point)> too_late)
    : pipe(std::move(from)), capture(restricted), options(given), is_too_late(std::move(too_late)) {}

FrameSource::Item PipeSource::failed(const std::string &text) const {
  return {Item::given_up, capture.frames.number_at(place), Clock::now(), {}, text};
}

// Below 0, or not below the count, for frames that are not sent. Throws Error for numbers between those.
int64_t PipeSource::place_of(int64_t number) const {
  const scene::Frames &frames = capture.frames;
  if (number < frames.first) return -1;
  const uint64_t after = uint64_t(number) - uint64_t(frames.first);
  if (after >= uint64_t(frames.places()) * uint64_t(frames.step)) return frames.places();
  if (after % uint64_t(frames.step))
    throw Error(capture.path,
                fvv::format("expected a frame number that is %lld and a multiple of %lld, found %lld",
                            static_cast<long long>(frames.first), static_cast<long long>(frames.step),
                            static_cast<long long>(number)));
  return int64_t(after / uint64_t(frames.step));
}

FrameSource::Item PipeSource::next() {
  if (last) return *std::exchange(last, std::nullopt);
  if (place == capture.frames.places()) return {Item::ended, 0, {}, {}, "all frames of the capture came"};
  try {
    return read();
  } catch (const PipeBytes::Ended &ended) {
    return {ended.kind, capture.frames.number_at(place), Clock::now(), {}, ended.reason};
  } catch (const Error &error) {
    return failed(error.line());
  }
}

FrameSource::Item PipeSource::read() {
  while (true) {
    if (!waiting) {
      if (pipe->bytes.is_stopped()) return {Item::ended, 0, Clock::now(), {}, "it was stopped"};
      waiting = pipe->frames.next();
    }
    if (waiting->kind == FramePipe::Record::end)
      return {Item::ended, 0, Clock::now(), {}, "its writer ended it"};
    const int64_t at = place_of(waiting->number);
    if (at == capture.frames.places())
      return {Item::ended, 0, Clock::now(), {}, "all frames of the capture came"};
    if (at < 0) {
      waiting.reset();
      continue;
    }
    if (at < place)
      return failed(capture.path + fvv::format(": expected frame %lld or a later one, found %lld",
                                               static_cast<long long>(capture.frames.number_at(place)),
                                               static_cast<long long>(waiting->number)));
    if (at > place) {
      if (at - place > most_missing)
        return failed(
            capture.path +
            fvv::format(": expected at most %lld missing frames, found frame %lld after %lld",
                        static_cast<long long>(most_missing), static_cast<long long>(waiting->number),
                        static_cast<long long>(capture.frames.number_at(place) - capture.frames.step)));
      return missing();
    }
    const FramePipe::Record record = *std::exchange(waiting, std::nullopt);
    return take(record);
  }
}

FrameSource::Item PipeSource::missing() {
  const std::vector<int64_t> &left_out = capture.frames.left_out;
  const int64_t at = place++, number = capture.frames.number_at(at);
  if (std::binary_search(left_out.begin(), left_out.end(), at)) return {Item::left_out, number};
  return {Item::lost, number, Clock::now(), {}, "it did not come"};
}

FrameSource::Item PipeSource::take(const FramePipe::Record &record) {
  const Clock::time_point arrival = arrival_of(record);
  const std::vector<int64_t> &left_out = capture.frames.left_out;
  const int64_t at = place++;
  if (std::binary_search(left_out.begin(), left_out.end(), at)) return {Item::left_out, record.number};
  if (record.kind == FramePipe::Record::lost)
    return {
        Item::lost, record.number, arrival, {}, record.reason.empty() ? "its writer lost it" : record.reason};
  if (is_too_late(arrival)) return {Item::dropped, record.number, arrival};
  try {
    Frame frame = pipe->frames.take(capture.cameras);
    if (!capture.has_mesh(record.number)) frame.mesh = {};
    if (options.bit_depth > 8)
      for (media::AnyImage &picture : frame.pictures)
        picture = media::with_samples<uint16_t>(std::get<media::Image>(std::move(picture)));
    add_calibrations(capture, record.number, frame);
    return {Item::frame, record.number, arrival, std::move(frame)};
  } catch (const PipeBytes::Ended &ended) {
    last = Item{ended.kind, record.number, Clock::now(), {}, ended.reason};
    return {Item::lost, record.number, arrival, {}, "it is not whole"};
  } catch (const Error &error) {
    return {Item::lost, record.number, arrival, {}, error.line()};
  }
}

} // namespace fvv::mux
