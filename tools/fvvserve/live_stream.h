// A live stream: the thread that reads its input and cuts it into whole chunks whose CRCs are right, the
// channel that passes them on in the thread of the network, and the bounded queue of each client.
#pragma once

#include "fvv_cxx/rung.h"
#include "fvvserve/options.h"
#include "fvvserve/site.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

struct fvv_event;

namespace fvv::serve {

// Shared by all clients that wait for them.
using Bytes = std::shared_ptr<const std::string>;

// The chunks that a client needs before a group.
struct Opening {
  Bytes header;          // file header of the stream
  Bytes configuration;   // the current block
  uint64_t version = 0;  // another one: another block, or another stream
  bool repeated = false; // the block is right before this group
  Bytes ladder = {};     // the text about rungs, for clients that take one; NULL: for others
};

// The chunks that a client missed.
struct Missed {
  int64_t from = 0; // ticks; of the first chunk
  uint64_t chunks = 0, bytes = 0;
};

struct Message {
  enum class Kind { opening, media, text };
  Bytes bytes;
  Kind kind;
  int64_t time;       // ticks; of media
  Missed missed = {}; // text: what it reports
};

// Messages form runs: file header, configuration, whole groups with further configurations between them. Each
// run is a stream by itself for a reader that joins late. A text message ends a run.

class ClientQueue {
public:
  // limit: of waiting bytes, including those being sent. One message may be larger if it waits alone.
  explicit ClientQueue(size_t limit) : limit_bytes(limit) {}

  // A group begins at this time; bytes: its first chunk.
  void group(const Opening &opening, int64_t time, const Bytes &bytes);
  void chunk(int64_t time, const Bytes &bytes);
  // The open group will not be finished.
  void damage(const std::string &message);
  // Another stream begins: the file or its writer restarted.
  void restart();
  // There are no more messages. message: why, or empty.
  void end(const std::string &message);
  // There are no more messages from this server process; the stream itself goes on.
  void restarting();

  // The next message to send, or NULL. It is being sent from this call on.
  const Message *next();
  void sent();
  size_t waiting_bytes() const { return bytes_waiting; }
  bool ended() const { return end_told; }
  // Whether it ended by restarting().
  bool comes_back() const { return restart_told; }

private:
  void put(Message message);
  void say(const std::string &json, const Missed &reported = {});
  bool fits(size_t size) const;
  void drop_waiting(int64_t time, size_t size);

  std::deque<Message> messages; // front: being sent, when sending
  size_t limit_bytes, bytes_waiting = 0;
  uint64_t version = 0; // of the opening that was put last
  bool in_run = false;  // else nothing is put before the next group, which opens a run
  bool restarted = false, skipping = false, sending = false, end_told = false, restart_told = false;
  Missed missed; // while skipping
  Bytes ladder;  // the text that was put last
};

struct Piece {
  enum class Kind {
    header,        // a stream begins: its file header
    configuration, // a whole block
    group,         // first chunk of a group that is intact so far
    chunk,         // any further one, the last with it
    damage,        // text; the open group, if any, will not be finished
    end,           // of the stream; text: what went wrong, or empty. last: there will not be another stream
  };
  explicit Piece(Kind of) : kind(of) {}
  Kind kind;
  int64_t time = 0; // ticks; of group and chunk
  Bytes bytes;
  fvv_chunk_header chunk = {};                          // of group and chunk; the payload follows it in bytes
  std::shared_ptr<const ConfigurationBlock> block = {}; // of configuration
  std::string text;
  bool last = false;
};

// Warnings about a channel: as they come, but a few a second where its input has many.
class WarningLimit {
public:
  void warn(const std::string &text, std::chrono::steady_clock::time_point now);

private:
  double left = 10; // lines that may be printed now
  std::optional<std::chrono::steady_clock::time_point> last;
  uint64_t dropped = 0;
};

class LiveSource {
public:
  using Sink = std::function<void(Piece)>;

  // Opens the input; throws Error when that is not possible. sink is called in the thread of the
  // source, and for each piece the receiver calls taken() once, when it is through with it.
  LiveSource(const Options &options, const LiveInput &input, Sink sink);
  ~LiveSource() { halt(); }
  LiveSource(const LiveSource &) = delete;
  LiveSource &operator=(const LiveSource &) = delete;

  void start();
  void halt(); // returns when the thread has ended
  // The number of clients. A file that is played begins with the first one.
  void audience(size_t listeners);
  void taken();

private:
  enum class Input { played_file, growing_file, pipe, fifo };

  void run();
  bool play_once();                            // false: there will not be another stream
  bool end_stream();                           // as play_once()
  void next_writer();                          // of a FIFO
  void drop_writer(const std::string &reason); // likewise: what it sends from now on is not read
  void pause_after(bool played, std::chrono::steady_clock::time_point began);
  bool wait_for_audience();
  bool wait_for_input();                    // of a pipe; false: stopped
  size_t read_some(char *out, size_t size); // 0: the end, or stopped
  bool drain(struct Reader &reader);        // false: the stream is over
  void take(const fvv_event &event, struct Reader &reader);
  void take_chunk(const fvv_event &event, struct Reader &reader);
  void begin_block(const fvv_event &event, struct Reader &reader);
  void wait_until_due(int64_t time, struct Reader &reader);
  void give(Piece piece);
  bool stopped();

  const Options &options;
  const std::string name, path;
  Sink sink;
  Input input;
  Descriptor descriptor;
  bool catching_up = false; // of a growing file: bytes before the start are not sent
  uint64_t received = 0;    // bytes of this stream
  bool damaged = false;     // this stream

  std::mutex mutex;
  std::condition_variable changed;
  bool stop = false, wanted = false;
  size_t listeners = 0, untaken = 0;
  std::thread thread;
};

class LiveChannel;

// One client. The channel borrows it between join and leave.
class Listener {
public:
  explicit Listener(size_t queue_bytes) : queue(queue_bytes) {}
  virtual ~Listener() = default;
  // Something was put into the queue.
  virtual void wake() = 0;

  ClientQueue queue;
  std::optional<size_t> wanted = {};  // rung, from the next group on; none: all tracks
  std::optional<size_t> current = {}; // of the open group
};

class LiveChannel {
public:
  // post: runs its argument in the thread of the network.
  using Post = std::function<void(std::function<void()>)>;
  LiveChannel(const Options &options, const LiveInput &input, Post post);

  void start() { source.start(); }
  // Stops the input. To be called while the objects that post needs still exist.
  void halt() { source.halt(); }
  // False: the stream has ended for good, or the server stops.
  bool join(Listener &listener);
  void leave(Listener &listener);
  // The server stops: sends "restarting" to the clients of a stream that has not ended.
  void close();
  bool ended() const { return over; }
  bool closed() const { return stopping; }

private:
  // A rung in the open group, if any client takes it.
  struct Rung {
    Opening opening;
    std::unique_ptr<RungGroup> group = {}; // NULL: none is open
    std::vector<Listener *> waiting = {};  // that take the open group
  };

  void receive(const Piece &piece);
  void configure(const Piece &piece);
  void begin_group(const Piece &piece);
  void pass_on(const Piece &piece);
  void lose(size_t number, const std::string &why);
  void warn(const std::string &text);

  const std::string name;
  Post post;
  Opening opening;
  std::shared_ptr<const ConfigurationBlock> block;
  Bytes ladder; // the text about rungs
  std::map<size_t, Rung> rungs;
  bool over = false, stopping = false;
  WarningLimit warnings;
  std::set<Listener *> listeners;
  LiveSource source; // last: its thread ends first
};

} // namespace fvv::serve
