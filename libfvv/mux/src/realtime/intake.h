// Reads the frames of a capture as they arrive, on a thread of its own, ahead of who packs them.
#pragma once

#include "fvv_media/mask.h"
#include "fvv_media/video.h"
#include "fvv_mux/encoder.h"
#include "fvv_scene/pictures.h"
#include "mux/src/realtime/arrivals.h"

#include <deque>
#include <exception>
#include <optional>

namespace fvv::mux {

class Intake {
public:
  struct Item {
    enum Kind { frame, left_out, lost, dropped, ended, given_up };
    Kind kind;
    int64_t number = 0; // in file names
    Clock::time_point arrival = {};
    Frame content = {};      // of frame
    std::string reason = ""; // of lost, ended and given_up

    bool is_last() const { return kind == ended || kind == given_up; }
  };

  // capture: borrowed, restricted to what is sent. options: filled in. ahead: frames that may wait.
  // is_too_late: of the time at which a frame arrived; such a frame is not read. Called on this thread.
  Intake(const scene::Capture &capture, const Options &options, const RealtimeOptions &realtime, size_t ahead,
         std::function<bool()> is_stopped, std::function<bool(Clock::time_point)> is_too_late);
  ~Intake();

  // Waits for the next one; the last one comes again and again. Throws what is wrong with no single frame.
  Item next();

private:
  void run();
  Item read(int64_t place, const Arrivals::Fate &fate);
  Frame read_frame(int64_t number);
  media::MaskRule mask_rule(size_t camera, const std::string &path);
  void push(Item item);
  bool is_closed();

  const scene::Capture &capture;
  const Options options;
  const size_t ahead;
  const std::function<bool(Clock::time_point)> is_too_late;
  scene::Videos videos;
  std::vector<scene::Camera> cameras; // with the rules of their masks, once these are decided
  std::vector<std::optional<media::MaskFacts>> mask_facts;
  Arrivals arrivals;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Item> items;
  std::exception_ptr failure;
  bool closed = false;
  std::thread reader; // last: it uses all others
};

} // namespace fvv::mux
