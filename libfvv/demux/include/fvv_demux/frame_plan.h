// The frames of a file and their groups, as far as they can be known in a damaged file. Frames have the
// numbers of the undamaged stream: lost frames keep theirs.
#pragma once

#include "fvv/stream.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/input_file.h"
#include "fvv_demux/selection.h"

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace fvv::demux {

// Whether the frames that a caller unpacks need a track.
using NeedsTrack = std::function<bool(const fvv_configuration &configuration, const fvv_track &track)>;

class Survey {
public:
  // Error when the file cannot be read. limits NULL: defaults. needs empty: frames need all tracks.
  explicit Survey(const InputFile &file, const fvv_limits *limits = nullptr, const NeedsTrack &needs = {});

  struct Group {
    uint64_t whole = 0;         // frames from the first on of which nothing that they need is lost
    fvv_diagnostic reason = {}; // why there are no more; status 0: no frame is lost
    fvv_diagnostic behind = {}; // the first damage between this group and the next
  };
  // Keyed by the offset of GRUP. A group whose GRUP was lost has no whole frames.
  Group group(uint64_t offset) const;

private:
  std::map<uint64_t, Group> groups; // key 0: everything before the first group
};

struct CloseStream {
  void operator()(fvv_stream *stream) const { fvv_stream_close(stream); }
};
using Stream = std::unique_ptr<fvv_stream, CloseStream>;
// Error with the diagnostic when it cannot be opened. limits NULL: defaults.
Stream open_stream(const InputFile &file, const fvv_limits *limits = nullptr);

// Frames first ... last of the stream are lost; why: the rest of the message.
struct Loss {
  int64_t first, last;
  std::string why;
};
std::string text_of(const fvv_diagnostic &diagnostic);

struct GroupPlan {
  size_t group;   // for fvv_stream_group
  size_t frame;   // for fvv_stream: its first frame
  int64_t number; // of its first frame in the undamaged stream
  int64_t count;  // frames that it has or had before damage
  bool complete;  // the list of its chunks is complete, if its table is good
};

struct Plan {
  std::vector<GroupPlan> groups; // with at least one selected frame, and not entirely lost
  std::vector<Loss> losses;      // of groups that are entirely lost
  int64_t count = 0;             // frames of the stream
  bool rebuilt = false;          // the index was missing or damaged
  std::string rebuilt_why;
  std::string uncertain; // why numbers of frames are a guess; empty: they are certain
};

// The survey of a file is made when first needed, by one of the threads.
class LazySurvey {
public:
  // As of Survey; limits live as long as this object.
  explicit LazySurvey(const InputFile &file, const fvv_limits *accepted = nullptr, NeedsTrack needed = {})
      : input(file), limits(accepted), needs(std::move(needed)) {}
  Survey::Group group(uint64_t offset);

private:
  const InputFile &input;
  const fvv_limits *limits;
  const NeedsTrack needs;
  std::mutex lock;
  std::optional<Survey> survey;
};

Plan make_plan(fvv_stream *stream, const InputFile &file, const Selection &frames, LazySurvey &survey);

} // namespace fvv::demux
