// The files of frames as they appear in the folder of a capture.
#pragma once

#include "fvv_mux/realtime.h"
#include "fvv_scene/capture.h"

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>

namespace fvv::mux {

using Clock = std::chrono::steady_clock;
inline double seconds_of(Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

class Arrivals {
public:
  // What becomes of the frame at a place of the capture.
  struct Fate {
    enum Kind { arrived, lost, ended, given_up }; // given_up: no frame came for too long
    Kind kind;
    Clock::time_point time; // of the arrival
    std::string reason;     // else
  };

  // capture: borrowed; every picture and mesh is a file, for each frame or for all of them.
  Arrivals(const scene::Capture &capture, const RealtimeOptions &options, std::function<bool()> is_stopped);
  ~Arrivals(); // waits end at once

  // Waits until that is known. Places come in order; is_stopped and the idle time end the wait.
  Fate await(int64_t place);
  // How long a frame is waited for after a later one is whole, and how long a file may be unreadable.
  static constexpr std::chrono::milliseconds patience{500};
  // Whether nothing more arrives.
  bool has_ended();
  // Makes all waits end.
  void close();

private:
  void watch();
  void look();
  std::string missing_file(int64_t place, bool all) const; // empty: the frame is whole
  bool is_whole(const std::function<std::string(int64_t)> &file, int64_t place, bool all) const;

  const scene::Capture &capture;
  const RealtimeOptions options;
  const std::function<bool()> is_stopped;
  const std::string marker;
  std::mutex mutex;
  std::condition_variable changed;
  std::map<int64_t, Clock::time_point> whole; // by place, of those that were not awaited yet
  int64_t next = 0;                           // place that is awaited, or was last plus one
  Clock::time_point last;                     // arrival, or start
  std::string end;                            // why nothing more arrives; empty: something may
  bool closed = false;
  std::thread watcher; // last: it uses all others
};

} // namespace fvv::mux
