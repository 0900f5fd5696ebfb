// Which frames a file has, as far as that can be known, and in which group they stand. Numbers stay those of
// the undamaged stream: what is lost keeps its numbers. Knows the file's index; decodes nothing.
#pragma once

#include "cli/cli.h"
#include "fvv/stream.h"
#include "fvvdemux/selection.h"
#include "fvvdemux/survey.h"

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace fvv::demux {

struct CloseStream {
  void operator()(fvv_stream *stream) const { fvv_stream_close(stream); }
};
using Stream = std::unique_ptr<fvv_stream, CloseStream>;
// cli::Failure with the diagnostic when it cannot be opened.
Stream open_stream(const cli::InputFile &file);

// Frames first ... last of the stream are lost; why: the rest of the line that says so.
struct Loss {
  int64_t first, last;
  std::string why;
};
std::string text_of(const fvv_diagnostic &diagnostic);

struct GroupPlan {
  size_t group;   // for fvv_file_group
  size_t frame;   // for fvv_stream: its first frame
  int64_t number; // of its first frame in the undamaged stream
  int64_t count;  // frames that it has or had
  bool complete;  // the list of its chunks is complete, if its table is good
};

struct Plan {
  std::vector<GroupPlan> groups; // with at least one frame that is chosen, and not wholly lost
  std::vector<Loss> losses;      // of groups of which nothing is left
  int64_t count = 0;             // frames of the stream
  bool rebuilt = false;          // the index was missing or damaged
  std::string rebuilt_why;
  std::string uncertain; // why numbers of frames are a guess; empty: they are none
};

// The survey of a file is made when first asked for, by whichever thread comes first.
class LazySurvey {
public:
  explicit LazySurvey(const cli::InputFile &file) : input(file) {}
  Survey::Group group(uint64_t offset);

private:
  const cli::InputFile &input;
  std::mutex lock;
  std::optional<Survey> survey;
};

Plan make_plan(fvv_stream *stream, const cli::InputFile &file, const Selection &frames, LazySurvey &survey);

} // namespace fvv::demux
