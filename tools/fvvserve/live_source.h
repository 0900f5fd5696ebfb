// fvvserve/live_source.h: a stream as it comes or at the pace of its time stamps, cut into whole chunks whose
// CRCs are right. Runs in a thread of its own, since files and pipes block; knows no client and no socket.
#pragma once

#include "fvvserve/client_queue.h"
#include "fvvserve/options.h"
#include "fvvserve/site.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

struct fvv_event;

namespace fvv::serve {

struct Piece {
  enum class Kind {
    header,        // a stream begins: its file header
    configuration, // a whole block
    group,         // first chunk of a group that is intact so far
    chunk,         // any further one, the last with it
    damage,        // text; the group at hand, if any, will not be finished
    end,           // of the stream; text: what went wrong, or empty. last: there will not be another stream
  };
  explicit Piece(Kind of) : kind(of) {}
  Kind kind;
  int64_t time = 0; // ticks; of group and chunk
  Bytes bytes;
  std::string text;
  bool last = false;
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
  // How many listen now. A file that is played begins when the first one comes.
  void audience(size_t listeners);
  void taken();

private:
  enum class Input { played_file, growing_file, pipe, fifo };

  void run();
  bool play_once(); // false: there will not be another stream
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
  bool catching_up = false; // of a growing file: what was there before we came is not sent

  std::mutex mutex;
  std::condition_variable changed;
  bool stop = false, wanted = false;
  size_t listeners = 0, untaken = 0;
  std::thread thread;
};

} // namespace fvv::serve
