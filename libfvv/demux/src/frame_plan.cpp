#include "fvv_demux/frame_plan.h"

#include "fvv/frames.h"

#include <algorithm>
#include <memory>

namespace fvv::demux {

namespace {

constexpr size_t block_size = 1 << 18;

// Calls push with the bytes of a file, block by block, as long as it returns true.
template <class Push> void read_blocks(const InputFile &file, const Push &push) {
  const fvv_input input = file.input();
  std::vector<uint8_t> block(block_size);
  for (uint64_t at = 0, part = 0; at < input.size; at += part) {
    part = std::min<uint64_t>(input.size - at, block_size);
    if (input.read_at(input.user, at, block.data(), size_t(part)) != FVV_OK)
      throw Error(file.path() + ": cannot read");
    if (!push(block.data(), size_t(part))) return;
  }
}

// Leaves out the tracks that frames do not need, so that their damage costs nothing.
void leave_out(fvv_frames *frames, const fvv_configuration &configuration, const NeedsTrack &needs) {
  std::vector<uint16_t> others;
  for (size_t i = 0; needs && i < configuration.track_count; i++)
    if (!needs(configuration, configuration.tracks[i])) others.push_back(configuration.tracks[i].id);
  fvv::check(fvv_frames_leave_out(frames, others.data(), others.size()), "memory", {});
}

} // namespace

Survey::Survey(const InputFile &file, const fvv_limits *limits, const NeedsTrack &needs) {
  // A frame counts once something follows it without a gap.
  fvv_frames_options options;
  fvv_frames_options_default(&options);
  options.eager = 0;
  fvv_frames *created = nullptr;
  fvv::check(fvv_frames_create(&options, limits, nullptr, &created), file.path(), {});
  const std::unique_ptr<fvv_frames, decltype(&fvv_frames_destroy)> frames(created, fvv_frames_destroy);
  Group *group = &groups[0];
  bool in_group = false;
  const auto take = [&](const fvv_frames_event &event) {
    if (event.kind == FVV_FRAMES_CONFIGURATION) {
      leave_out(frames.get(), *event.configuration, needs);
    } else if (event.kind == FVV_FRAMES_GROUP) {
      group = &groups[event.offset];
      in_group = true;
    } else if (event.kind == FVV_FRAMES_GROUP_END) {
      in_group = false;
    } else if (event.kind == FVV_FRAMES_FRAME) {
      group->whole++;
    } else if (event.kind == FVV_FRAMES_DAMAGE && !(event.whole && in_group)) {
      fvv_diagnostic &place = in_group ? group->reason : group->behind;
      if (place.status == FVV_OK) place = event.diagnostic;
    }
  };
  fvv_diagnostic diagnostic = {};
  fvv_frames_event event;
  fvv_status status = FVV_OK;
  const auto drain = [&] {
    while ((status = fvv_frames_next(frames.get(), &event, &diagnostic)) == FVV_OK) {
      take(event);
      // What follows the footer is no part of the stream.
      if (event.kind == FVV_FRAMES_END) return false;
    }
    return status == FVV_NEED_DATA;
  };
  const auto read = [&] {
    status = FVV_NEED_DATA;
    read_blocks(file, [&](const uint8_t *bytes, size_t size) {
      fvv::check(fvv_frames_push(frames.get(), bytes, size), file.path(), {});
      return drain();
    });
    fvv_frames_finish(frames.get());
    if (status >= 0) drain();
  };
  read();
  // A repetition of a damaged configuration block may come after the groups that need it.
  if (status >= 0 && fvv_frames_missed_groups(frames.get())) {
    groups.clear();
    group = &groups[0];
    in_group = false;
    fvv::check(fvv_frames_seek(frames.get(), 0, nullptr), file.path(), {});
    read();
  }
  // After an error of the stream everything counts as lost.
  if (status < 0 && status > FVV_ERROR_DAMAGED) fvv::check(status, file.path(), diagnostic);
  if (status < 0 && group->reason.status == FVV_OK) group->reason = diagnostic;
}

Survey::Group Survey::group(uint64_t offset) const {
  const auto next = groups.upper_bound(offset);
  const auto found = std::prev(next); // there is one: key 0
  if (found->first == offset) {
    Group group = found->second;
    // Its configuration was lost before it.
    if (group.reason.status == FVV_OK && !group.whole && found != groups.begin())
      group.reason = std::prev(found)->second.behind;
    return group;
  }
  Group lost;
  lost.reason = found->second.behind.status ? found->second.behind : found->second.reason;
  return lost;
}

namespace {

constexpr int64_t most_frames = INT32_MAX;
// A frame has a chunk, and a chunk a header of 32 bytes.
constexpr uint64_t smallest_frame = 32;
const char unknown_count[] =
    "the number of lost frames is unknown: later frames are numbered as if none were lost";

// How many frames of the nominal duration fill [start, end); 0 when they do not fill it exactly.
int64_t frames_between(int64_t start, int64_t end, int64_t duration) {
  if (duration <= 0 || start >= end) return 0;
  const uint64_t span = uint64_t(end) - uint64_t(start);
  const uint64_t count = span / uint64_t(duration);
  return span % uint64_t(duration) || count > uint64_t(most_frames) ? 0 : int64_t(count);
}

int64_t frame_duration(fvv_stream *stream, size_t group) {
  const fvv_configuration *configuration = nullptr;
  return fvv_stream_configuration(stream, group, &configuration, nullptr) == FVV_OK
             ? configuration->scene.frame_duration
             : 0;
}

// With an index all numbers are known; only tables and chunks may be found damaged later.
void plan_by_index(const fvv_stream *stream, const std::string &name, Plan &plan) {
  for (size_t g = 0; g < fvv_stream_group_count(stream); g++) {
    const fvv_group_info &group = *fvv_stream_group(stream, g);
    if (group.frame_count > group.size / smallest_frame || plan.count + group.frame_count > most_frames)
      throw Error(name + ": group " + std::to_string(group.sequence) + " claims " +
                  std::to_string(group.frame_count) + " frames in " + std::to_string(group.size) + " bytes");
    plan.groups.push_back({g, size_t(plan.count), plan.count, group.frame_count, true});
    plan.count += group.frame_count;
  }
}

// The file was scanned: whole groups have a frame count, for others it follows from their time range.
class Scanned {
public:
  Scanned(fvv_stream *opened, Plan &out, LazySurvey &surveyed)
      : stream(opened), plan(out), survey(surveyed) {}

  void add(size_t index, const fvv_group_info &group) {
    const size_t frame = next_frame;
    next_frame += group.frame_count;
    if (index && group.sequence < next_sequence) return; // repeated
    if (group.sequence > next_sequence) add_lost_groups(index, group);
    int64_t count = group.frame_count;
    if (!group.intact) {
      const int64_t nominal = frames_between(group.start, group.end, frame_duration(stream, index));
      if (nominal >= count)
        count = nominal;
      else
        plan.uncertain = unknown_count;
    }
    if (plan.count + count > most_frames) {
      plan.uncertain = unknown_count;
      count = group.frame_count;
    }
    plan.groups.push_back({index, frame, plan.count, count, group.intact != 0});
    plan.count += count;
    next_sequence = uint64_t(group.sequence) + 1;
    end = group.end;
  }

private:
  void add_lost_groups(size_t index, const fvv_group_info &group) {
    // Most writers begin at tick 0, but they do not have to.
    if (!next_sequence)
      plan.uncertain = "the first group is missing: frames are numbered by their times, from tick 0 on";
    const int64_t lost = frames_between(end, group.start, frame_duration(stream, index));
    if (!lost || plan.count + lost > most_frames) {
      plan.uncertain = unknown_count;
      return;
    }
    plan.losses.push_back(
        {plan.count, plan.count + lost - 1, text_of(survey.group(group.offset - 1).reason)});
    plan.count += lost;
  }

  fvv_stream *stream;
  Plan &plan;
  LazySurvey &survey;
  size_t next_frame = 0;
  uint64_t next_sequence = 0;
  int64_t end = 0; // of the group before
};

} // namespace

Stream open_stream(const InputFile &file, const fvv_limits *limits) {
  const fvv_input input = file.input();
  fvv_stream *stream = nullptr;
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_stream_open(&input, limits, nullptr, &stream, &diagnostic), file.path(), diagnostic);
  return Stream(stream);
}

std::string text_of(const fvv_diagnostic &diagnostic) {
  char line[1024];
  fvv_diagnostic_format(&diagnostic, nullptr, line, sizeof line);
  return line;
}

Survey::Group LazySurvey::group(uint64_t offset) {
  const std::lock_guard<std::mutex> guard(lock);
  if (!survey) survey.emplace(input, limits, needs);
  return survey->group(offset);
}

Plan make_plan(fvv_stream *stream, const InputFile &file, const Selection &frames, LazySurvey &survey) {
  Plan plan;
  plan.rebuilt = fvv_stream_index_state(stream) == FVV_INDEX_REBUILT;
  if (!plan.rebuilt) {
    plan_by_index(stream, file.path(), plan);
  } else {
    plan.rebuilt_why = fvv_stream_damage_count(stream) ? text_of(*fvv_stream_damage(stream, 0))
                                                       : "no footer: the stream is live or truncated";
    Scanned scanned(stream, plan, survey);
    for (size_t g = 0; g < fvv_stream_group_count(stream); g++) scanned.add(g, *fvv_stream_group(stream, g));
  }
  std::vector<GroupPlan> chosen;
  for (const GroupPlan &group : plan.groups)
    if (!frames.within(group.number, group.number + group.count - 1).empty()) chosen.push_back(group);
  plan.groups = chosen;
  return plan;
}

} // namespace fvv::demux
