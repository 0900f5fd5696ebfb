// Takes the frames of a source as they arrive, on a thread of its own, ahead of who packs them.
#pragma once

#include "mux/src/realtime/frame_source.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

namespace fvv::mux {

class Intake {
public:
  using Item = FrameSource::Item;

  // ahead: frames that may wait.
  Intake(std::unique_ptr<FrameSource> source, size_t ahead);
  ~Intake(); // waits end at once

  // Waits for the next one; the last one comes again and again. Throws what the source threw.
  Item next();

private:
  void push(Item item);
  bool is_closed();

  const std::unique_ptr<FrameSource> source;
  const size_t ahead;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Item> items;
  std::exception_ptr failure;
  bool closed = false;
  std::thread reader; // last: it uses all others
};

} // namespace fvv::mux
