#include "fvvserve/client_queue.h"

#include <nlohmann/json.hpp>

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

void ClientQueue::say(const std::string &json, const Missed &told) {
  put({std::make_shared<const std::string>(json), Message::Kind::text, 0, told});
}

bool ClientQueue::fits(size_t size) const {
  // Or a chunk above the limit would never pass: what was put just before it may still be on its way.
  return bytes_waiting <= limit_bytes / 8 || bytes_waiting + size <= limit_bytes;
}

// The client gets nothing of what it did not take in time: what it would get late is of no use to it.
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
    // A skip that the client will not hear of is a part of this one.
    if (last.missed.chunks) add(last.missed.from, last.missed.chunks, last.missed.bytes);
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
  if (!in_run) {
    if (skipping)
      say(line({{"type", "skip"},
                {"from", std::to_string(missed.from)},
                {"to", std::to_string(time)},
                {"chunks", missed.chunks},
                {"bytes", missed.bytes}}),
          missed);
    else if (restarted)
      say(line({{"type", "restart"}}));
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

} // namespace fvv::serve
