// Where the frames of a show come from while it is packed.
#pragma once

#include "fvv_mux/encoder.h"
#include "mux/src/realtime/arrivals.h"

#include <string>

namespace fvv::mux {

class FrameSource {
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

  virtual ~FrameSource() = default;
  // Waits for the next one; not called after the last one. Throws what is wrong with no single frame.
  virtual Item next() = 0;
  // Makes waits end, from any thread.
  virtual void close() = 0;
};

// What is there cannot be used: waiting does not make another frame of it.
class Unusable : public Error {
public:
  using Error::Error;
};

// To frame, of each camera of the capture. Throws Unusable for one that has none at that number.
void add_calibrations(const scene::Capture &capture, int64_t number, Frame &frame);

} // namespace fvv::mux
