// fvvserve/live_channel.h: one live stream and those who listen to it. Lives in the thread of the network;
// knows no socket, only listeners with a queue.
#pragma once

#include "fvvserve/live_source.h"

#include <set>

namespace fvv::serve {

class LiveChannel;

// One client. The channel borrows it between join and leave.
class Listener {
public:
  explicit Listener(size_t queue_bytes) : queue(queue_bytes) {}
  virtual ~Listener() = default;
  // Something was put into the queue.
  virtual void wake() = 0;

  ClientQueue queue;
};

class LiveChannel {
public:
  // post: runs its argument in the thread of the network.
  using Post = std::function<void(std::function<void()>)>;
  LiveChannel(const Options &options, const LiveInput &input, Post post);

  void start() { source.start(); }
  // No piece comes in any more. To be called while what post needs is still there.
  void halt() { source.halt(); }
  // False: the stream has ended for good.
  bool join(Listener &listener);
  void leave(Listener &listener);
  // Tells everybody that no more will come.
  void close();
  bool ended() const { return over; }

private:
  void receive(const Piece &piece);

  const std::string name;
  Post post;
  Opening opening;
  bool over = false;
  std::set<Listener *> listeners;
  LiveSource source; // last: its thread ends first
};

} // namespace fvv::serve
