// fvvserve/client_queue.h: what waits for one live client, bounded, and what it is spared when it is too
// slow. Knows groups and chunks as runs of bytes; knows no socket and no clock.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

namespace fvv::serve {

// Shared by all clients that wait for them.
using Bytes = std::shared_ptr<const std::string>;

// What a client needs in front of a group.
struct Opening {
  Bytes header;          // file header of the stream
  Bytes configuration;   // the block that holds
  uint64_t version = 0;  // another one: another block, or another stream
  bool repeated = false; // the block stands in front of this very group
};

// What a client was spared.
struct Missed {
  int64_t from = 0; // ticks; of the first chunk
  uint64_t chunks = 0, bytes = 0;
};

struct Message {
  enum class Kind { opening, media, text };
  Bytes bytes;
  Kind kind;
  int64_t time;       // ticks; of media
  Missed missed = {}; // text: what it tells of
};

// What is put makes runs: file header, configuration, whole groups with further configurations between them.
// Each run is a stream by itself for a reader that joins late. A text message ends a run.

class ClientQueue {
public:
  // limit: bytes that wait at most, what is being sent included. One message may be larger when little
  // alone.
  explicit ClientQueue(size_t limit) : limit_bytes(limit) {}

  // A group begins at this time; bytes: its first chunk.
  void group(const Opening &opening, int64_t time, const Bytes &bytes);
  void chunk(int64_t time, const Bytes &bytes);
  // The group at hand will not be finished.
  void damage(const std::string &message);
  // Another stream begins: a file begins anew, or its writer does.
  void restart();
  // No more will come. message: why, or empty.
  void end(const std::string &message);

  // What is to be sent next, or NULL. It is being sent from this call on.
  const Message *next();
  void sent();
  size_t waiting_bytes() const { return bytes_waiting; }
  bool ended() const { return end_told; }

private:
  void put(Message message);
  void say(const std::string &json, const Missed &missed = {});
  bool fits(size_t size) const;
  void drop_waiting(int64_t time, size_t size);

  std::deque<Message> messages; // front: being sent, when sending
  size_t limit_bytes, bytes_waiting = 0;
  uint64_t version = 0; // of the opening that was put last
  bool in_run = false;  // else nothing is put before the next group, which opens a run
  bool restarted = false, skipping = false, sending = false, end_told = false;
  Missed missed; // while skipping
};

} // namespace fvv::serve
