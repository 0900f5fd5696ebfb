#include "fvvserve/live_stream.h"

#include "cli/cli.h"
#include "fvv/container.h"
#include "fvv_cxx/untrusted.h"

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>

namespace fvv::serve {

namespace {

using Json = nlohmann::ordered_json;

std::string line(const Json &json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

} // namespace

void ClientQueue::put(Message message) {
  bytes_waiting += message.bytes->size();
  messages.push_back(std::move(message));
}

void ClientQueue::say(const std::string &json, const Missed &reported) {
  put({std::make_shared<const std::string>(json), Message::Kind::text, 0, reported});
}

bool ClientQueue::fits(size_t size) const {
  // Otherwise a chunk above the limit would never pass: the one before it may still be in transit.
  return bytes_waiting <= limit_bytes / 8 || bytes_waiting + size <= limit_bytes;
}

// A client does not get chunks that it did not take in time: late data are useless to it.
void ClientQueue::drop_waiting(int64_t time, size_t size) {
  if (!skipping) missed = {time, 0, 0};
  skipping = true;
  in_run = false;
  const auto add = [this](int64_t from, uint64_t chunks, uint64_t bytes) {
    missed.from = from; // from back to front: the earliest stays
    missed.chunks += chunks;
    missed.bytes += bytes;
  };
  missed.chunks++;
  missed.bytes += size;
  const size_t kept = sending ? 1 : 0;
  while (messages.size() > kept) {
    const Message &last = messages.back();
    if (last.kind == Message::Kind::media) add(last.time, 1, last.bytes->size());
    // A skip that was not sent to the client is a part of this one.
    if (last.missed.chunks) add(last.missed.from, last.missed.chunks, last.missed.bytes);
    if (last.bytes == ladder) ladder = nullptr; // it was not sent
    bytes_waiting -= last.bytes->size();
    messages.pop_back();
  }
}

void ClientQueue::group(const Opening &opening, int64_t time, const Bytes &bytes) {
  if (end_told) return;
  // Half of the queue has to be free, or the next chunks would only be skipped again.
  const size_t needed = bytes->size() + opening.header->size() + opening.configuration->size();
  if (!fits(needed) || (skipping && bytes_waiting > limit_bytes / 2))
    return drop_waiting(time, bytes->size());
  const bool other_ladder = opening.ladder && (!ladder || *ladder != *opening.ladder);
  if (!in_run || other_ladder) {
    if (skipping)
      say(line({{"type", "skip"},
                {"from", std::to_string(missed.from)},
                {"to", std::to_string(time)},
                {"chunks", missed.chunks},
                {"bytes", missed.bytes}}),
          missed);
    else if (restarted)
      say(line({{"type", "restart"}}));
    if (other_ladder) {
      ladder = std::make_shared<const std::string>(*opening.ladder);
      put({ladder, Message::Kind::text, 0});
    }
    put({std::make_shared<const std::string>(*opening.header + *opening.configuration),
         Message::Kind::opening, time});
  } else if (version != opening.version || opening.repeated) {
    put({opening.configuration, Message::Kind::opening, time});
  }
  in_run = true;
  skipping = restarted = false;
  version = opening.version;
  put({bytes, Message::Kind::media, time});
}

void ClientQueue::chunk(int64_t time, const Bytes &bytes) {
  if (end_told || (!in_run && !skipping)) return;
  if (skipping || !fits(bytes->size())) return drop_waiting(time, bytes->size());
  put({bytes, Message::Kind::media, time});
}

void ClientQueue::restart() {
  restarted = restarted || in_run;
  in_run = false;
}

void ClientQueue::damage(const std::string &message) {
  if (end_told) return;
  if (in_run) say(line({{"type", "damage"}, {"message", message}}));
  in_run = false;
}

void ClientQueue::end(const std::string &message) {
  if (end_told) return;
  end_told = true;
  if (message.empty())
    say(line({{"type", "end"}}));
  else
    say(line({{"type", "error"}, {"message", message}}));
}

void ClientQueue::restarting() {
  if (end_told) return;
  end_told = restart_told = true;
  say(line({{"type", "restarting"}}));
}

const Message *ClientQueue::next() {
  if (messages.empty()) return nullptr;
  sending = true;
  return &messages.front();
}

void ClientQueue::sent() {
  bytes_waiting -= messages.front().bytes->size();
  messages.pop_front();
  sending = false;
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t portion = 64 << 10;
constexpr size_t largest_kept = (size_t(256) << 20) + 2 * portion; // the largest chunk that is read, and more
constexpr uint64_t chunk_header = 32, file_header = 24;            // clauses 4.1 and 3.1 of spec/fvv.md
constexpr size_t most_untaken = 64;                                // pieces on their way to the receiver
constexpr std::chrono::milliseconds look_again{50}; // whether a file has grown, or stop was called
// Beyond these time stamps are assumed to restart: a gap in the recording, a suspended machine.
constexpr double longest_wait = 10, longest_delay = 1;
// A file that plays in no time is not read again and again: a damaged one, or one of very short frames.
constexpr std::chrono::milliseconds pause_of_damaged{1000}, shortest_round{20};
constexpr double warnings_at_once = 10, warnings_a_second = 1;

struct ReaderDeleter {
  void operator()(fvv_reader *reader) const { fvv_reader_destroy(reader); }
};

} // namespace

// A stream while it is read.
struct Reader {
  std::unique_ptr<fvv_reader, ReaderDeleter> handle;
  std::string bytes;                                                 // pushed, and not yet consumed
  uint64_t offset = 0;                                               // of their first in the stream
  enum class Where { nowhere, block, group } where = Where::nowhere; // group: one that is passed on
  std::string configuration;                                         // the block, as far as it has been read
  std::shared_ptr<ConfigurationBlock> block;                         // the same
  double seconds_per_tick = 0;
  int64_t frame_duration = 1, last_time = 0, anchor_time = 0;
  std::optional<Clock::time_point> anchor; // when anchor_time was due
};

LiveSource::LiveSource(const Options &chosen, const LiveInput &live, Sink receiver)
    : options(chosen), name(live.name), path(live.file), sink(std::move(receiver)) {
  const bool standard = path == "-";
  descriptor =
      Descriptor(standard ? dup(STDIN_FILENO) : open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status;
  if (descriptor.get() < 0 || fstat(descriptor.get(), &status) != 0)
    throw Error("--live: " + path + ": cannot open: " + std::strerror(errno));
  if (standard && isatty(descriptor.get()))
    throw Error("--live: standard input is a terminal: expected a stream", Error::usage);
  if (S_ISDIR(status.st_mode)) throw Error("--live: " + path + ": is a folder");
  if (standard)
    input = Input::pipe;
  else if (S_ISREG(status.st_mode))
    input = options.follow ? Input::growing_file : Input::played_file;
  else
    input = S_ISFIFO(status.st_mode) ? Input::fifo : Input::pipe;
}

void LiveSource::halt() {
  {
    const std::lock_guard<std::mutex> lock(mutex);
    stop = true;
  }
  changed.notify_all();
  if (thread.joinable()) thread.join();
}

void LiveSource::start() {
  thread = std::thread([this] {
    try {
      run();
    } catch (const std::exception &exception) {
      Piece piece(Piece::Kind::end);
      piece.text = exception.what();
      piece.last = true;
      give(std::move(piece));
    }
  });
}

void LiveSource::audience(size_t now) {
  {
    const std::lock_guard<std::mutex> lock(mutex);
    if (now > listeners) wanted = true;
    listeners = now;
  }
  changed.notify_all();
}

void LiveSource::taken() {
  {
    const std::lock_guard<std::mutex> lock(mutex);
    untaken--;
  }
  changed.notify_all();
}

bool LiveSource::stopped() {
  const std::lock_guard<std::mutex> lock(mutex);
  return stop;
}

void LiveSource::give(Piece piece) {
  {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock, [&] { return stop || untaken < most_untaken; });
    if (stop) return;
    untaken++;
  }
  sink(std::move(piece));
}

void LiveSource::run() {
  while (!stopped()) {
    try {
      if (!play_once()) return;
    } catch (const Error &error) {
      if (input != Input::fifo) throw;
      drop_writer(error.what());
    }
  }
}

// One bad writer does not end the channel.
void LiveSource::drop_writer(const std::string &reason) {
  Piece piece(received ? Piece::Kind::end : Piece::Kind::damage);
  piece.text = received ? reason : path + ": a writer has left without a byte";
  give(std::move(piece));
  std::string rest(portion, '\0');
  while (received && read_some(rest.data(), rest.size())) {}
  next_writer();
}

// It begins a stream of its own.
void LiveSource::next_writer() {
  for (;;) {
    descriptor = Descriptor(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (descriptor.get() >= 0 || stopped()) return;
    // Not an Error, after which there would be a next writer.
    if (errno != EMFILE && errno != ENFILE)
      throw std::runtime_error(path + ": cannot open: " + std::strerror(errno));
    std::this_thread::sleep_for(look_again); // until a connection ends
  }
}

bool LiveSource::wait_for_audience() {
  std::unique_lock<std::mutex> lock(mutex);
  changed.wait(lock, [&] { return stop || wanted || (options.loop && listeners); });
  wanted = false;
  return !stop;
}

// Poll with a time limit, in order to notice stop.
bool LiveSource::wait_for_input() {
  while (!stopped()) {
    pollfd entry = {descriptor.get(), POLLIN, 0};
    const int n = poll(&entry, 1, int(look_again.count()));
    if (n > 0) return true;
    if (n < 0 && errno != EINTR) return false;
  }
  return false;
}

size_t LiveSource::read_some(char *out, size_t size) {
  while (!stopped()) {
    if (input != Input::played_file && input != Input::growing_file && !wait_for_input()) return 0;
    const ssize_t n = read(descriptor.get(), out, size);
    if (n > 0) return static_cast<size_t>(n);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n < 0) throw Error(path + ": cannot read: " + std::strerror(errno));
    if (input != Input::growing_file) return 0;
    catching_up = false;
    struct stat status;
    const off_t here = lseek(descriptor.get(), 0, SEEK_CUR);
    if (fstat(descriptor.get(), &status) == 0 && status.st_size < here)
      throw Error(path + ": has become shorter while it was read");
    std::this_thread::sleep_for(look_again);
  }
  return 0;
}

bool LiveSource::play_once() {
  if (input == Input::played_file) {
    if (!wait_for_audience()) return false;
    if (lseek(descriptor.get(), 0, SEEK_SET) != 0) throw Error(path + ": cannot seek");
  }
  catching_up = input == Input::growing_file;
  Reader reader;
  fvv_reader *handle = nullptr;
  if (fvv_reader_create(nullptr, nullptr, 0, &handle) < 0) throw std::bad_alloc();
  reader.handle.reset(handle);
  std::string bytes(portion, '\0');
  const auto began = Clock::now();
  received = 0;
  damaged = false;
  bool more = true;
  while (more) {
    const size_t n = read_some(bytes.data(), bytes.size());
    if (stopped()) return false;
    if (n) {
      if (fvv_reader_push(handle, bytes.data(), n) < 0) throw std::bad_alloc();
      reader.bytes.append(bytes, 0, n);
      received += n;
    } else {
      fvv_reader_finish(handle);
    }
    more = drain(reader) && n;
    // Of endless garbage only as much is kept as an incomplete chunk may have.
    if (reader.bytes.size() > largest_kept) {
      const size_t surplus = reader.bytes.size() - largest_kept;
      reader.bytes.erase(0, surplus);
      reader.offset += surplus;
    }
  }
  if (input == Input::fifo) next_writer();
  if (input == Input::played_file && reader.last_time <= INT64_MAX - reader.frame_duration)
    wait_until_due(reader.last_time + reader.frame_duration, reader);
  if (input == Input::played_file && options.loop) pause_after(reader.anchor && !damaged, began);
  return end_stream();
}

void LiveSource::pause_after(bool played, Clock::time_point began) {
  const auto due = began + (played ? shortest_round : pause_of_damaged);
  std::unique_lock<std::mutex> lock(mutex);
  changed.wait_until(lock, due, [&] { return stop; });
}

bool LiveSource::end_stream() {
  const bool again = input == Input::fifo || input == Input::played_file;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    if (input == Input::played_file && options.loop && listeners) return true;
  }
  Piece piece(Piece::Kind::end);
  piece.last = !again;
  give(std::move(piece));
  return again;
}

bool LiveSource::drain(Reader &reader) {
  while (!stopped()) {
    fvv_event event;
    fvv_diagnostic diagnostic;
    const fvv_status status = fvv_reader_next(reader.handle.get(), &event, &diagnostic);
    if (status == FVV_NEED_DATA) return true;
    if (status == FVV_END) return false;
    fvv::check(status, path, diagnostic);
    if (event.kind == FVV_EVENT_END) return false;
    take(event, reader);
  }
  return false;
}

void LiveSource::take(const fvv_event &event, Reader &reader) {
  if (event.kind == FVV_EVENT_HEADER) {
    Piece piece(Piece::Kind::header);
    piece.bytes = std::make_shared<const std::string>(reader.bytes, 0, file_header);
    give(std::move(piece));
  } else if (event.kind == FVV_EVENT_CHUNK) {
    take_chunk(event, reader);
  } else {
    char text[1024];
    fvv_diagnostic_format(&event.diagnostic, path.c_str(), text, sizeof text);
    Piece piece(Piece::Kind::damage);
    piece.text = text;
    damaged = true;
    give(std::move(piece));
    // An incomplete block is not used; the one before it may still apply.
    reader.configuration.clear();
    reader.where = Reader::Where::nowhere;
  }
}

void LiveSource::take_chunk(const fvv_event &event, Reader &reader) {
  const fvv_chunk_header &chunk = event.chunk;
  reader.bytes.erase(0, static_cast<size_t>(event.offset - reader.offset));
  reader.offset = event.offset;
  const auto extent = static_cast<size_t>(chunk_header + (chunk.size + 7) / 8 * 8);
  auto bytes = std::make_shared<const std::string>(reader.bytes, 0, extent);
  using Where = Reader::Where;
  if (chunk.type == FVV_CHUNK_SCENE) begin_block(event, reader);
  if (reader.where == Where::block && chunk.type != FVV_CHUNK_GROUP) {
    reader.configuration += *bytes;
    reader.block->add(chunk, event.payload);
  }
  // INDX and FOOT: offsets of a file are of no use to those who joined late.
  if (chunk.type == FVV_CHUNK_INDEX) reader.where = Where::nowhere;
  if (chunk.type == FVV_CHUNK_GROUP) {
    if (!reader.configuration.empty()) {
      Piece piece(Piece::Kind::configuration);
      piece.bytes = std::make_shared<const std::string>(std::move(reader.configuration));
      piece.block = std::move(reader.block);
      give(std::move(piece));
      reader.configuration.clear();
    }
    reader.where = catching_up ? Where::nowhere : Where::group;
  }
  if (reader.where != Where::group || !event.group_intact) return; // the reason was reported as damage
  // The end of a group is sent at once.
  const bool ends = chunk.type == FVV_CHUNK_GROUP_END;
  if (!ends) {
    wait_until_due(chunk.time, reader);
    reader.last_time = chunk.time;
  }
  Piece piece(chunk.type == FVV_CHUNK_GROUP ? Piece::Kind::group : Piece::Kind::chunk);
  piece.time = chunk.time;
  piece.chunk = chunk;
  piece.bytes = std::move(bytes);
  give(std::move(piece));
  if (ends) reader.where = Where::nowhere;
}

void LiveSource::begin_block(const fvv_event &event, Reader &reader) {
  reader.configuration.clear();
  reader.block = std::make_shared<ConfigurationBlock>();
  reader.where = Reader::Where::block;
  fvv_scene scene;
  fvv_diagnostic diagnostic;
  if (fvv_scene_decode(&scene, event.payload, event.chunk.size, &diagnostic) < 0)
    return; // reported by the reader
  reader.seconds_per_tick = double(scene.time_base.numerator) / scene.time_base.denominator;
  reader.frame_duration = scene.frame_duration;
}

void LiveSource::wait_until_due(int64_t time, Reader &reader) {
  if (input != Input::played_file && !options.pace) return;
  const auto now = Clock::now();
  if (reader.anchor) {
    const double wait = (double(time) - double(reader.anchor_time)) * reader.seconds_per_tick -
                        std::chrono::duration<double>(now - *reader.anchor).count();
    if (wait < longest_wait && wait > -longest_delay) {
      const auto due = now + std::chrono::duration_cast<Clock::duration>(
                                 std::chrono::duration<double>(wait > 0 ? wait : 0));
      std::unique_lock<std::mutex> lock(mutex);
      changed.wait_until(lock, due, [&] { return stop; });
      return;
    }
  }
  reader.anchor = now;
  reader.anchor_time = time;
}

LiveChannel::LiveChannel(const Options &options, const LiveInput &input, Post to_network)
    : name(input.name), post(std::move(to_network)), source(options, input, [this](Piece piece) {
        auto shared = std::make_shared<const Piece>(std::move(piece));
        post([this, shared] {
          receive(*shared);
          source.taken();
        });
      }) {}

bool LiveChannel::join(Listener &listener) {
  if (over || stopping) return false;
  listeners.insert(&listener);
  source.audience(listeners.size());
  return true;
}

void LiveChannel::leave(Listener &listener) {
  if (listeners.erase(&listener)) source.audience(listeners.size());
}

void LiveChannel::close() {
  stopping = true;
  for (Listener *listener : listeners) {
    listener->queue.restarting();
    listener->wake();
  }
}

void LiveChannel::configure(const Piece &piece) {
  opening.repeated = opening.configuration && *opening.configuration == *piece.bytes;
  if (!opening.repeated) opening.version++;
  opening.configuration = piece.bytes;
  block = piece.block;
  rungs.clear();
  const fvv_rational ticks = block->time_base();
  Json text = {
      {"type", "rungs"}, {"time_base", {ticks.numerator, ticks.denominator}}, {"rungs", Json::array()}};
  for (const RungInfo &rung : block->rungs()) text["rungs"].push_back(json_of<Json>(rung));
  ladder = std::make_shared<const std::string>(line(text));
}

namespace {

constexpr uint64_t most_rungs = 65536; // of a stream, which has no more tracks

int64_t load_i64(const uint8_t *bytes) {
  return int64_t(load_u32(bytes) | uint64_t(load_u32(bytes + 4)) << 32);
}

} // namespace

void LiveChannel::begin_group(const Piece &piece) {
  for (auto &[number, rung] : rungs) {
    rung.group.reset();
    rung.waiting.clear();
  }
  // Without a file header the stream has lost its beginning: no client can join.
  const bool repeated = std::exchange(opening.repeated, false);
  if (!opening.header || !opening.configuration) return;
  for (Listener *listener : listeners) {
    listener->current.reset();
    if (listener->wanted) listener->current = std::min(*listener->wanted, block->rung_count() - 1);
    if (listener->current)
      rungs[*listener->current].waiting.push_back(listener);
    else
      listener->queue.group({opening.header, opening.configuration, opening.version, repeated, nullptr},
                            piece.time, piece.bytes);
  }
  const auto *payload = reinterpret_cast<const uint8_t *>(piece.bytes->data()) + chunk_header;
  for (auto &[number, rung] : rungs) {
    if (rung.waiting.empty()) continue;
    try {
      Bytes &configuration = rung.opening.configuration;
      if (!configuration) configuration = std::make_shared<const std::string>(block->of_rung(number));
      rung.opening = {opening.header, configuration, opening.version * most_rungs + number + 1, repeated,
                      ladder};
      auto group = std::make_unique<RungGroup>(*block, number);
      const auto bytes = std::make_shared<const std::string>(
          group->begin(load_u32(payload), load_i64(payload + 8), load_i64(payload + 16)));
      for (Listener *listener : rung.waiting) listener->queue.group(rung.opening, piece.time, bytes);
      rung.group = std::move(group);
    } catch (const Error &error) {
      lose(number, error.what());
    }
  }
}

void LiveChannel::pass_on(const Piece &piece) {
  std::map<size_t, Bytes> of_rungs;
  const auto *payload = reinterpret_cast<const uint8_t *>(piece.bytes->data()) + chunk_header;
  const bool ends = piece.chunk.type == FVV_CHUNK_GROUP_END;
  for (auto &[number, rung] : rungs) {
    if (!rung.group) continue;
    try {
      of_rungs[number] = std::make_shared<const std::string>(ends ? rung.group->end()
                                                                  : rung.group->chunk(piece.chunk, payload));
      if (ends) rung.group.reset();
    } catch (const Error &error) {
      lose(number, error.what());
    }
  }
  for (Listener *listener : listeners) {
    if (!listener->current) {
      listener->queue.chunk(piece.time, piece.bytes);
      continue;
    }
    const auto bytes = of_rungs.find(*listener->current);
    if (bytes != of_rungs.end() && !bytes->second->empty()) listener->queue.chunk(piece.time, bytes->second);
  }
}

void WarningLimit::warn(const std::string &text, Clock::time_point now) {
  if (last)
    left = std::min(warnings_at_once,
                    left + warnings_a_second * std::chrono::duration<double>(now - *last).count());
  last = now;
  if (left < 1) {
    dropped++;
    return;
  }
  left--;
  if (dropped)
    cli::warn(text + " (and " + std::to_string(dropped) + (dropped == 1 ? " warning" : " warnings") +
              " before it that " + (dropped == 1 ? "is" : "are") + " not shown)");
  else
    cli::warn(text);
  dropped = 0;
}

void LiveChannel::warn(const std::string &text) {
  warnings.warn("/live/" + name + ": " + text, Clock::now());
}

// What the reader lets pass and the writer does not, such as metadata beyond a limit.
void LiveChannel::lose(size_t number, const std::string &why) {
  const std::string text = "rung " + std::to_string(number) + ": " + why;
  warn(text);
  rungs[number].group.reset();
  for (Listener *listener : listeners)
    if (listener->current == number) listener->queue.damage(text);
}

void LiveChannel::receive(const Piece &piece) {
  switch (piece.kind) {
  case Piece::Kind::header:
    opening = {piece.bytes, nullptr, opening.version + 1, false, nullptr};
    rungs.clear();
    for (Listener *listener : listeners) listener->queue.restart();
    return;
  case Piece::Kind::configuration:
    configure(piece);
    return;
  case Piece::Kind::group:
    begin_group(piece);
    break;
  case Piece::Kind::chunk:
    pass_on(piece);
    break;
  case Piece::Kind::damage:
    for (auto &[number, rung] : rungs) rung.group.reset();
    warn(piece.text);
    for (Listener *listener : listeners) listener->queue.damage(piece.text);
    break;
  case Piece::Kind::end:
    if (!piece.text.empty()) warn(piece.text);
    over = piece.last;
    for (Listener *listener : listeners) listener->queue.end(piece.text);
    break;
  }
  for (Listener *listener : listeners) listener->wake();
}

} // namespace fvv::serve
