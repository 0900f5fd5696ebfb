#include "report.h"

#include "arrays.h"
#include "stream_pointer.h"

#include "fvv/frames.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <string>

namespace fvv::conformance {

using nlohmann::json;

namespace {

// Of a frame: the offset of its group, and its time.
using Place = std::pair<uint64_t, int64_t>;

// What the reader's events tell about a stream.
struct Seen {
  const fvv_checker *checker = nullptr; // that reads
  std::vector<Place> frames;            // in order of the stream
  uint64_t group = 0;                   // offset of the last GRUP
  bool in_block = false;                // no chunk of a group has come since SCEN
  std::set<uint64_t> sound;             // offsets of AUDI chunks before which nothing of their group is wrong
  bool has_index = false;
};

void take_event(void *user, const fvv_event *event) {
  Seen &seen = *static_cast<Seen *>(user);
  const fvv_chunk_header &chunk = event->chunk;
  if (event->kind != FVV_EVENT_CHUNK) return;
  if (chunk.type == FVV_CHUNK_GROUP) seen.group = event->offset;
  if (chunk.type == FVV_CHUNK_AUDIO && event->group_intact) seen.sound.insert(event->offset);
  if (chunk.type == FVV_CHUNK_INDEX) seen.has_index = true;
  if (chunk.type == FVV_CHUNK_SCENE) seen.in_block = true;
  if (chunk.type == FVV_CHUNK_GROUP || chunk.type == FVV_CHUNK_MESH || chunk.type == FVV_CHUNK_VIDEO_PACKET)
    seen.in_block = false;
  if (seen.in_block) return;
  const fvv_configuration *configuration = seen.checker ? fvv_checker_configuration(seen.checker) : nullptr;
  if (!chunk.track || !fvv_configuration_makes_frame(configuration, chunk.type, chunk.track)) return;
  const Place place = {seen.group, chunk.time};
  if (seen.frames.empty() || seen.frames.back() != place) seen.frames.push_back(place);
}

struct CheckerDeleter {
  void operator()(fvv_checker *checker) const { fvv_checker_destroy(checker); }
};
using Checker = std::unique_ptr<fvv_checker, CheckerDeleter>;

fvv_status check(fvv_checker *checker, const std::vector<uint8_t> &bytes, size_t piece) {
  fvv_status status = FVV_OK;
  for (size_t at = 0; at < bytes.size() && status >= 0; at += piece)
    status = fvv_checker_push(checker, bytes.data() + at, std::min(piece, bytes.size() - at));
  return status < 0 ? status : fvv_checker_finish(checker);
}

std::set<Place> whole_frames(const fvv_checker *checker, const Seen &seen) {
  std::set<Place> out;
  for (size_t i = 0; i < fvv_checker_run_count(checker); i++) {
    const fvv_frame_run &run = *fvv_checker_run(checker, i);
    for (uint64_t k = run.first; k < run.first + run.count && k < seen.frames.size(); k++)
      out.insert(seen.frames[k]);
  }
  return out;
}

json issues(const fvv_checker *checker) {
  std::vector<std::pair<uint64_t, uint32_t>> found;
  for (size_t i = 0; i < fvv_checker_problem_count(checker); i++) {
    const fvv_diagnostic &problem = *fvv_checker_problem(checker, i);
    if (problem.issue) found.push_back({problem.chunk_offset, problem.issue});
  }
  std::stable_sort(found.begin(), found.end(), [](auto &a, auto &b) { return a.first < b.first; });
  json out = json::array();
  for (const auto &[offset, issue] : found)
    out.push_back({{"issue", "FVV-" + std::to_string(issue)}, {"offset", offset}});
  return out;
}

std::string four_characters(uint32_t code) {
  std::string out;
  for (int i = 0; i < 4; i++) out += char(code >> (8 * i) & 255);
  return out;
}

const char *kind_name(uint8_t kind) {
  static const char *const names[] = {
      "", "mesh", "video", "calibration", "visibility", "environment", "data", "audio", "colours"};
  return kind && kind < std::size(names) ? names[kind] : "unknown";
}

json summary(const fvv_checker *checker, const Seen &seen) {
  const fvv_check_summary &found = *fvv_checker_summary(checker);
  const fvv_configuration *configuration = fvv_checker_configuration(checker);
  json tracks = json::array(), cameras = json::array();
  for (size_t i = 0; configuration && i < configuration->track_count; i++) {
    const fvv_track &track = configuration->tracks[i];
    json row = {{"id", track.id}, {"kind", kind_name(track.kind)}};
    const fvv_video_layout *video = fvv_configuration_video(configuration, track.id);
    const fvv_audio_config *audio = fvv_configuration_audio(configuration, track.id);
    if (video) row["codec"] = four_characters(video->config.codec);
    if (audio) row["codec"] = four_characters(audio->codec);
    tracks.push_back(row);
  }
  for (size_t i = 0; configuration && i < configuration->camera_count; i++)
    cameras.push_back(configuration->cameras[i].id);
  return {{"groups", found.groups}, {"frames", found.frames},         {"tracks", tracks},
          {"cameras", cameras},     {"ended", found.has_footer != 0}, {"indexed", seen.has_index}};
}

} // namespace

json report(const std::vector<uint8_t> &bytes, bool live) {
  Seen seen;
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = 1;
  options.event = take_event;
  options.user = &seen;
  fvv_checker *created = nullptr;
  if (fvv_checker_create(&options, nullptr, nullptr, &created) != FVV_OK) throw std::bad_alloc();
  const Checker checker(created);
  seen.checker = created;
  const size_t piece = live ? 977 : std::max<size_t>(bytes.size(), 1);
  fvv_status status = check(created, bytes, piece);
  // A repetition of a damaged configuration block may come after the groups that need it.
  if (status == FVV_NEED_DATA && !live) {
    seen = Seen();
    seen.checker = created;
    status = check(created, bytes, piece);
  }
  const bool is_whole = status >= 0 && !fvv_checker_summary(created)->problems;
  json out = {{"status", status < 0 ? "refused"
                         : is_whole ? "whole"
                                    : "damaged"},
              {"issues", issues(created)},
              {"frames", json::array()},
              {"sounds", json::object()},
              {"environment", json::object()},
              {"summary", summary(created, seen)}};
  const fvv_input input = fvv_input_memory(bytes.data(), bytes.size());
  fvv_stream *opened = nullptr;
  if (fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) != FVV_OK) return out;
  const StreamPointer stream(opened);
  const std::set<Place> whole = whole_frames(created, seen);
  for (size_t i = 0; i < fvv_stream_frame_count(opened); i++) {
    fvv_frame frame;
    if (fvv_stream_frame(opened, i, &frame, nullptr) != FVV_OK) continue;
    const fvv_group_info &group = *fvv_stream_group(opened, frame.group);
    if (!whole.count({group.offset, frame.time})) continue;
    const json arrays = frame_arrays(opened, i);
    if (!arrays.is_null()) out["frames"].push_back(arrays);
  }
  out["sounds"] = sounds(opened, seen.sound);
  out["environment"] = environments(opened);
  return out;
}

namespace {

struct FramesDeleter {
  void operator()(fvv_frames *frames) const { fvv_frames_destroy(frames); }
};

// What a reader of whole frames reports of a stream that it joined late.
struct Late {
  std::set<int64_t> whole;
  json issues = json::array();
  fvv_status status = FVV_OK;

  void take(const fvv_frames_event &event) {
    if (event.kind == FVV_FRAMES_FRAME) whole.insert(event.time);
    if (event.kind == FVV_FRAMES_DAMAGE && event.diagnostic.issue)
      issues.push_back({{"issue", "FVV-" + std::to_string(event.diagnostic.issue)},
                        {"offset", event.diagnostic.chunk_offset}});
  }
};

Late read_late(const std::vector<uint8_t> &bytes) {
  fvv_frames *created = nullptr;
  if (fvv_frames_create(nullptr, nullptr, nullptr, &created) != FVV_OK) throw std::bad_alloc();
  const std::unique_ptr<fvv_frames, FramesDeleter> frames(created);
  Late late;
  late.status = fvv_frames_join(created);
  if (late.status == FVV_OK) late.status = fvv_frames_push(created, bytes.data(), bytes.size());
  fvv_frames_finish(created);
  fvv_frames_event event;
  while (late.status == FVV_OK) {
    late.status = fvv_frames_next(created, &event, nullptr);
    if (late.status == FVV_OK) late.take(event);
  }
  return late;
}

} // namespace

json joined_report(const std::vector<uint8_t> &bytes) {
  const Late late = read_late(bytes);
  json out = {{"status", late.status < 0       ? "refused"
                         : late.issues.empty() ? "whole"
                                               : "damaged"},
              {"issues", late.issues},
              {"frames", json::array()},
              {"sounds", json::object()},
              {"environment", json::object()}};
  const fvv_input input = fvv_input_memory(bytes.data(), bytes.size());
  fvv_stream *opened = nullptr;
  if (fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) != FVV_OK) return out;
  const StreamPointer stream(opened);
  for (size_t i = 0; i < fvv_stream_frame_count(opened); i++) {
    const json arrays = frame_arrays(opened, i);
    if (!arrays.is_null() && late.whole.count(arrays.at("time"))) out["frames"].push_back(arrays);
  }
  return out;
}

} // namespace fvv::conformance
