// From a capture whose frames arrive while it is packed to a stream, with a bounded delay. docs/guide/live.md
#pragma once

#include "fvv_mux/options.h"
#include "fvv_mux/report.h"

#include <functional>
#include <string>

namespace fvv::mux {

// When a file of a frame is whole.
enum class Arrival {
  by_name,      // as soon as it has its name: writers give it when they are done, by renaming
  by_successor, // as soon as its source has a file of a later frame, or the show has ended
};

// Beside capture.json: the show has ended, and all files that will come are there.
constexpr const char *end_marker = "capture.end";

struct RealtimeOptions {
  Arrival arrival = Arrival::by_name;
  double most_delay = 2; // seconds from the arrival of a frame to the last byte of its group
  double idle = 10;      // seconds without a frame after which the stream ends
  // If not below 0, a descriptor that is read in place of the capture that options name, as
  // spec/frame-pipe.md has it; borrowed. Messages call it by that name.
  int pipe = -1;
};

// At most half a second.
uint32_t realtime_group_size(const fvv_rational &frame_duration);

// Something that viewers may notice.
struct RealtimeEvent {
  enum Kind {
    lost,    // a frame that did not become whole, or whose files cannot be used
    dropped, // a frame that was too old to be packed
    lowered, // from this frame on less effort, so that the stream keeps up
    raised,  // more again
    ended,   // because no frame came for too long
  };
  Kind kind;
  int64_t frame;    // number in file names; of ended that which did not come
  double age;       // seconds since the frame arrived; 0 if it did not
  std::string text; // a sentence
};
const char *name_of(RealtimeEvent::Kind kind);

// Packs the capture that options name, whose capture.json is there, until its last frame, the end marker, a
// pause of RealtimeOptions::idle, or until is_stopped returns true; frames that have arrived by then are
// packed. A group is written as soon as it is encoded. Without Options::group it lasts half a second.
// Files that are there at the start count as if they arrived at the capture's rate. A pipe ends with its
// record ENDS; where it ends otherwise, what was read is packed, and the report warns. sink and on_event are
// called on the calling thread, is_stopped on another one. Throws Error, also when no frame arrives.
Report pack_arriving(const Options &options, const RealtimeOptions &realtime, const Sink &sink,
                     const Observer &observer, const std::function<void(const RealtimeEvent &)> &on_event,
                     const std::function<bool()> &is_stopped);

} // namespace fvv::mux
