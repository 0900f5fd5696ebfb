#include "mux/src/data/data_tracks.h"

#include "fvv_demux/data.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>

namespace fvv::mux {

namespace {

// Of one file; of captions all together.
constexpr uint64_t most_bytes = uint64_t(256) << 20, most_captions = uint64_t(16) << 20;

std::string extension_of(const std::filesystem::path &path) {
  std::string out = path.extension().string();
  if (!out.empty()) out.erase(0, 1);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return out;
}

// [hours:]minutes:seconds.thousandths, in seconds.
bool parse_time(const std::string &text, double &seconds) {
  unsigned hours = 0, minutes = 0, whole = 0, part = 0;
  int read = -1;
  if (std::sscanf(text.c_str(), "%u:%2u:%2u.%3u%n", &hours, &minutes, &whole, &part, &read) != 4) {
    hours = 0;
    read = -1;
    if (std::sscanf(text.c_str(), "%2u:%2u.%3u%n", &minutes, &whole, &part, &read) != 3) return false;
  }
  if (read < 0 || size_t(read) != text.size() || minutes > 59 || whole > 59) return false;
  seconds = 3600.0 * hours + 60.0 * minutes + whole + part / 1000.0;
  return true;
}

// The line of a cue that has its times: start --> end, and settings.
bool parse_times(const std::string &line, double &start, double &end) {
  const std::string arrow = " --> ";
  const size_t at = line.find(arrow);
  if (at == std::string::npos) return false;
  const size_t from = at + arrow.size(), to = std::min(line.find_first_of(" \t", from), line.size());
  return parse_time(line.substr(0, at), start) && parse_time(line.substr(from, to - from), end) &&
         start < end;
}

std::vector<std::string> lines_of(const std::string &text) {
  std::vector<std::string> out;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    if (!out.back().empty() && out.back().back() == '\r') out.back().pop_back();
    begin = end + 1;
  }
  return out;
}

// Blocks are separated by empty lines; a cue is a block with times, in its first or second line.
DataTrack read_captions(const std::string &file) {
  DataTrack out;
  out.media_type = "text/vtt";
  const std::vector<std::string> lines = lines_of(scene::read_file(file, most_captions));
  if (lines.empty() || lines[0].rfind("WEBVTT", 0) != 0)
    throw Error(file + ": line 1: expected WEBVTT, as WebVTT files begin");
  for (size_t begin = 0; begin < lines.size();) {
    size_t end = begin;
    std::string block;
    for (; end < lines.size() && !lines[end].empty(); end++) block += lines[end] + "\n";
    DataCue cue = {0, 0, block};
    const bool arrow = block.find("-->") != std::string::npos;
    const bool good = begin < end && (parse_times(lines[begin], cue.start, cue.end) ||
                                      (begin + 1 < end && parse_times(lines[begin + 1], cue.start, cue.end)));
    if (arrow && !good)
      throw Error(file + ": line " + std::to_string(begin + 1) +
                  ": expected times such as 00:01.000 --> 00:02.500, with the end after the start");
    if (good)
      out.cues.push_back(cue);
    else if (!block.empty() && block.rfind("NOTE", 0) != 0) // styles and regions, before all cues
      out.head += (out.head.empty() ? "" : "\n") + block;
    begin = end + 1;
  }
  return out;
}

DataTrack list_sequence(const Plan &plan, const std::string &folder) {
  DataTrack out;
  for (const auto &entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file()) out.files.push_back(std::filesystem::absolute(entry.path()).string());
  std::sort(out.files.begin(), out.files.end());
  if (out.files.size() != plan.frame_count())
    throw Error(option_name("data", folder) + ": " + std::to_string(out.files.size()) + " files for " +
                    std::to_string(plan.frame_count()) +
                    " frames: expected one for each, in the order of their names",
                Error::usage);
  const std::string extension = extension_of(out.files.front());
  for (const std::string &file : out.files)
    if (extension_of(file) != extension)
      throw Error(option_name("data", folder) +
                      ": files of different types, expected one: " + out.files.front() + ", " + file,
                  Error::usage);
  const demux::DataType type = demux::data_type_of(extension);
  out.media_type = type.media_type;
  out.codec = type.codec;
  return out;
}

// A WebVTT file of the cues that overlap a span of seconds.
std::vector<uint8_t> captions_of(const DataTrack &track, double start, double end) {
  std::string text = track.head;
  for (const DataCue &cue : track.cues)
    if (cue.start < end && cue.end > start) text += "\n" + cue.text;
  return {text.begin(), text.end()};
}

} // namespace

std::vector<DataTrack> load_data(const Plan &plan) {
  std::vector<DataTrack> out;
  if (plan.options.data.size() > max_data_tracks)
    throw Error(option_name("data", "") + ": " + std::to_string(plan.options.data.size()) +
                    " tracks, expected at most " + std::to_string(max_data_tracks),
                Error::usage);
  for (const std::string &path : plan.options.data) {
    const std::filesystem::path file = path;
    const bool is_folder = std::filesystem::is_directory(file);
    if (!is_folder && extension_of(file) != "vtt")
      throw Error(option_name("data", path) +
                      ": expected a WebVTT file (.vtt), or a folder with a file for each frame",
                  Error::usage);
    out.push_back(is_folder ? list_sequence(plan, path) : read_captions(path));
    out.back().name = (file.has_filename() ? file : file.parent_path()).stem().string();
  }
  return out;
}

fvv_data_config config_of(const DataTrack &track) {
  fvv_data_config config = {};
  config.media_type = track.media_type.data();
  config.media_type_size = track.media_type.size();
  config.codec = track.codec.data();
  config.codec_size = track.codec.size();
  return config;
}

std::vector<DataChunk> data_chunks(const Plan &plan, size_t group) {
  std::vector<DataChunk> out;
  const GroupSpan &span = plan.groups[group];
  const fvv_rational &tick = plan.capture.frame_duration;
  const double seconds = double(tick.numerator) / tick.denominator;
  for (size_t i = 0; i < plan.data.size(); i++) {
    const DataTrack &track = plan.data[i];
    if (track.files.empty())
      out.push_back(
          {i, span.start, captions_of(track, double(span.start) * seconds, double(span.end) * seconds)});
    for (size_t frame = span.first; !track.files.empty() && frame < span.first + span.count; frame++) {
      const std::string bytes = scene::read_file(track.files[frame], most_bytes);
      out.push_back({i, plan.tick_of(frame), {bytes.begin(), bytes.end()}});
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const auto &a, const auto &b) { return a.time < b.time; });
  return out;
}

} // namespace fvv::mux
