#include "fvv_cxx/parallel.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <numeric>
#include <thread>

namespace fvv {

namespace {

class Pool {
public:
  Pool(unsigned threads, const std::vector<size_t> &groups, const std::function<void(size_t)> &piece_work,
       const std::function<void()> &at_end)
      : window(size_t(threads) + 1), group_of(groups), work(piece_work), rest(at_end),
        failed_piece(groups.size()) {
    waiting.resize(groups.empty() ? 0 : *std::max_element(groups.begin(), groups.end()) + 1);
    for (const size_t group : groups) waiting[group]++;
    try {
      for (unsigned i = 0; i < threads; i++) pool.emplace_back([this] { serve(); });
    } catch (...) {
      stop();
      throw;
    }
  }
  Pool(const Pool &) = delete;
  Pool &operator=(const Pool &) = delete;
  ~Pool() { stop(); }

  size_t groups() const { return waiting.size(); }

  void await(size_t group) {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock, [&] { return stopped || waiting[group] == 0; });
    if (!stopped) return;
    lock.unlock();
    stop();
    std::rethrow_exception(failure);
  }

  void release() {
    const std::lock_guard<std::mutex> lock(mutex);
    collected++;
    changed.notify_all();
  }

private:
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      stopped = true;
      changed.notify_all();
    }
    for (std::thread &thread : pool) thread.join();
    pool.clear();
  }

  bool take(size_t &piece) {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock,
                 [&] { return stopped || next == group_of.size() || group_of[next] < collected + window; });
    if (stopped || next == group_of.size()) return false;
    piece = next++;
    return true;
  }

  void serve() {
    for (size_t piece; take(piece);) {
      std::exception_ptr problem;
      try {
        work(piece);
      } catch (...) {
        problem = std::current_exception();
      }
      const std::lock_guard<std::mutex> lock(mutex);
      if (!problem) {
        waiting[group_of[piece]]--;
      } else {
        stopped = true;
        if (piece < failed_piece) {
          failed_piece = piece;
          failure = problem;
        }
      }
      changed.notify_all();
    }
    rest();
  }

  const size_t window;
  const std::vector<size_t> &group_of;
  const std::function<void(size_t)> &work;
  const std::function<void()> &rest;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<size_t> waiting; // pieces of each group that are not done
  size_t next = 0, collected = 0, failed_piece;
  bool stopped = false;
  std::exception_ptr failure;
  std::vector<std::thread> pool;
};

} // namespace

void run_ordered(unsigned threads, const std::vector<size_t> &group_of,
                 const std::function<void(size_t)> &work, const std::function<void(size_t)> &collect,
                 const std::function<void()> &rest) {
  Pool pool(threads, group_of, work, rest);
  for (size_t group = 0; group < pool.groups(); group++) {
    pool.await(group);
    collect(group);
    pool.release();
  }
}

void parallel(unsigned threads, size_t count, const std::function<void(size_t)> &work,
              const std::function<void()> &done) {
  std::vector<size_t> group_of(count);
  std::iota(group_of.begin(), group_of.end(), 0);
  run_ordered(threads, group_of, work, [&](size_t) { done(); });
}

} // namespace fvv
