#include "cli/parallel.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace fvv::cli {

namespace {

struct Queue {
  std::mutex mutex;
  std::condition_variable changed;
  size_t next = 0, count, ended = 0;
  uint32_t working;
  std::exception_ptr failure;

  bool take(size_t &piece) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (next >= count) return false;
    piece = next++;
    return true;
  }
  void end() {
    const std::lock_guard<std::mutex> lock(mutex);
    ended++;
    changed.notify_one();
  }
  void fail(std::exception_ptr reason) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!failure) failure = reason;
    next = count;
  }
  void leave() {
    const std::lock_guard<std::mutex> lock(mutex);
    working--;
    changed.notify_one();
  }
};

} // namespace

void parallel(uint32_t threads, size_t count, const std::function<void(size_t)> &work,
              const std::function<void()> &done) {
  Queue queue;
  queue.count = count;
  queue.working = threads;
  std::vector<std::thread> pool;
  for (uint32_t i = 0; i < threads; i++)
    pool.emplace_back([&] {
      try {
        for (size_t piece; queue.take(piece);) {
          work(piece);
          queue.end();
        }
      } catch (...) {
        queue.fail(std::current_exception());
      }
      queue.leave();
    });
  size_t reported = 0;
  std::unique_lock<std::mutex> lock(queue.mutex);
  while (queue.working > 0 || reported < queue.ended) {
    queue.changed.wait(lock, [&] { return queue.working == 0 || reported < queue.ended; });
    for (const size_t ended = queue.ended; reported < ended; reported++) {
      lock.unlock();
      done();
      lock.lock();
    }
  }
  lock.unlock();
  for (std::thread &thread : pool) thread.join();
  if (queue.failure) std::rethrow_exception(queue.failure);
}

} // namespace fvv::cli
