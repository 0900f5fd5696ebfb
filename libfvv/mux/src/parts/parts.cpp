#include "fvv_mux/parts.h"
#include "fvv/container.h"
#include "fvv_cxx/error.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/strict_json.h"
#include "mux/src/encode/encode_job.h"
#include "mux/src/parts/plan_data.h"
#include "mux/src/stream_writer.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace fvv::mux {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t largest_capture = uint64_t(16) << 20; // as scene::load_capture

std::string group_text(size_t group) {
  return "group " + std::to_string(group);
}

// Passes on what an observer takes, and collects the warnings.
Observer collecting(const Observer &observer, std::vector<std::string> &warnings) {
  Observer out = observer;
  out.on_warning = [&warnings, warn = observer.on_warning](const std::string &text) {
    warnings.push_back(text);
    if (warn) warn(text);
  };
  return out;
}

// Of bytes that pass: by it a report knows its stream.
struct Checksum {
  uint64_t bytes = 0;
  uint32_t crc = 0;

  void add(const void *more, size_t size) {
    bytes += size;
    crc = fvv_crc32c(crc, more, size);
  }
};

// A sink that passes all on and sums it up. Borrows both.
Sink summed(const Sink &sink, Checksum &sum) {
  return [&sink, &sum](const void *bytes, size_t size) {
    sum.add(bytes, size);
    sink(bytes, size);
  };
}

// What a report is of.
struct Identity {
  uint32_t plan = 0; // its checksum
  size_t group = 0;
  Checksum stream; // of the part
};

// Sums of a group that warnings about the whole stream need.
std::string report_of(const StreamSums &sums, const Identity &part,
                      const std::vector<std::string> &warnings) {
  Json rates = Json::array(), losses = Json::array();
  for (size_t track = 0; track < sums.rates.size(); track++)
    rates.push_back({{"bytes", sums.videos[track].payload},
                     {"groups", sums.rates[track].groups},
                     {"over", sums.rates[track].over}});
  for (size_t track = 1; track < sums.meshes.size(); track++)
    losses.push_back({{"pieces", sums.meshes[track].decimation.vanished_pieces},
                      {"area", sums.meshes[track].decimation.vanished_area},
                      {"thin_area", sums.meshes[track].decimation.thin_area}});
  const Json report = {{"fvv_part", 2},
                       {"plan", part.plan},
                       {"group", part.group},
                       {"bytes", part.stream.bytes},
                       {"crc32c", part.stream.crc},
                       {"warnings", warnings},
                       {"videos", std::move(rates)},
                       {"lower_meshes", std::move(losses)}};
  return report.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Throws Error unless a report is of that plan, group and stream: a part of a plan with other choices often
// has the same configuration.
void check_report(const nlohmann::json &report, const std::string &name, const Identity &part) {
  const std::string advice = ": encode " + group_text(part.group) + " again, by this plan";
  const auto differs = [&](const char *field, uint64_t expected) {
    return report.at(field).get<uint64_t>() != expected;
  };
  if (differs("plan", part.plan))
    throw Error(name + ": was encoded by another plan, with other choices" + advice);
  if (differs("group", part.group))
    throw Error(name + ": the report of the part is that of group " +
                std::to_string(report.at("group").get<uint64_t>()) + advice);
  if (differs("bytes", part.stream.bytes) || differs("crc32c", part.stream.crc))
    throw Error(name + ": the report of the part is that of another stream" + advice);
}

// Adds the sums of a part, and its warnings.
void add_report(StreamSums &sums, const std::string &text, const std::string &name, const Identity &part,
                std::vector<std::string> &warnings) {
  try {
    const nlohmann::json report =
        scene::parse_strict_json(text, name + ": the report of the part is damaged");
    check_report(report, name, part);
    for (const nlohmann::json &line : report.at("warnings")) warnings.push_back(line);
    for (size_t track = 0; track < sums.rates.size(); track++) {
      const nlohmann::json &video = report.at("videos").at(track);
      sums.videos[track].payload += video.at("bytes").get<uint64_t>();
      sums.rates[track].groups += video.at("groups").get<size_t>();
      sums.rates[track].over += video.at("over").get<size_t>();
    }
    for (size_t track = 1; track < sums.meshes.size(); track++) {
      const nlohmann::json &losses = report.at("lower_meshes").at(track - 1);
      DecimationSums &of_track = sums.meshes[track].decimation;
      of_track.vanished_pieces += losses.at("pieces").get<size_t>();
      of_track.vanished_area += losses.at("area").get<double>();
      of_track.thin_area += losses.at("thin_area").get<double>();
    }
  } catch (const nlohmann::json::exception &error) {
    throw Error(name + ": the report of the part is damaged: " + error.what());
  }
}

// Passes bytes on, and keeps those that are written while kept is set.
struct Tee {
  const Sink &sink;
  std::string *kept = nullptr; // borrowed

  void write(const void *bytes, size_t size) const {
    if (kept) kept->append(static_cast<const char *>(bytes), size);
    sink(bytes, size);
  }
};

constexpr size_t header_size = 32; // of a chunk

// Copies the group of a part into a stream, every byte checked.
class PartReader {
public:
  PartReader(size_t number, const InputFile &stream)
      : group(number), file(stream), reader(nullptr, fvv_reader_destroy) {
    fvv_reader *created = nullptr;
    if (fvv_reader_create(nullptr, nullptr, 0, &created) < 0) throw std::bad_alloc();
    reader.reset(created);
    if (fvv_reader_join(created) < 0) throw std::bad_alloc();
  }

  // head: file header and configuration, with which the part has to begin. tee: what writer writes to.
  // Returns the checksum of the whole file.
  Checksum copy(const std::string &head, StreamWriter &writer, Tee &tee) {
    check_head(head);
    fvv_event event = {};
    while (next(event)) {
      if (event.kind == FVV_EVENT_DAMAGE) fvv::fail(file.path(), event.diagnostic);
      if (event.kind != FVV_EVENT_CHUNK || event.offset < head.size()) continue;
      const fvv_chunk_header &chunk = event.chunk;
      if (complete) throw Error(file.path() + ": expected one group, found more after it");
      if (chunk.type == FVV_CHUNK_GROUP) {
        std::string written;
        tee.kept = &written;
        writer.begin_group(group);
        tee.kept = nullptr;
        check_group(event, written);
      } else if (chunk.type == FVV_CHUNK_GROUP_END) {
        writer.end_group();
        complete = true;
      } else {
        writer.chunk(chunk, event.payload);
      }
    }
    if (!complete) throw Error(file.path() + ": expected " + group_text(group) + ", found no group");
    return checksum;
  }

private:
  void check_head(const std::string &head) const {
    const std::string wrong =
        file.path() + ": its configuration is not that of the plan: it is a part of another one";
    if (file.size() < head.size()) throw Error(wrong);
    std::string found(head.size(), '\0');
    const fvv_input input = file.input();
    if (input.read_at(input.user, 0, found.data(), found.size()) < 0)
      throw Error(file.path() + ": cannot read");
    if (found != head) throw Error(wrong);
  }

  // written: GRUP as the plan has it.
  void check_group(const fvv_event &event, const std::string &written) const {
    if (written.size() < header_size + event.chunk.size ||
        std::memcmp(written.data() + header_size, event.payload, size_t(event.chunk.size)) != 0)
      throw Error(file.path() + ": is not " + group_text(group) + " of the plan: the part of another group");
  }

  // False at the end.
  bool next(fvv_event &event) {
    const fvv_input input = file.input();
    for (;;) {
      fvv_diagnostic diagnostic = {};
      const fvv_status status = fvv_reader_next(reader.get(), &event, &diagnostic);
      if (status == FVV_END) return false;
      if (status != FVV_NEED_DATA) {
        fvv::check(status, file.path(), diagnostic);
        return true;
      }
      bytes.resize(size_t(std::min<uint64_t>(size_t(1) << 20, file.size() - offset)));
      if (bytes.empty()) {
        fvv_reader_finish(reader.get());
        continue;
      }
      if (input.read_at(input.user, offset, bytes.data(), bytes.size()) < 0)
        throw Error(file.path() + ": cannot read");
      if (fvv_reader_push(reader.get(), bytes.data(), bytes.size()) < 0) throw std::bad_alloc();
      offset += bytes.size();
      checksum.add(bytes.data(), bytes.size());
    }
  }

  const size_t group;
  const InputFile &file;
  std::unique_ptr<fvv_reader, void (*)(fvv_reader *)> reader;
  std::vector<uint8_t> bytes;
  uint64_t offset = 0;
  Checksum checksum;
  bool complete = false;
};

} // namespace

struct PartPlan::State {
  PlanData data;
  std::string first_report;
};

PartPlan::PartPlan(const Options &options, const Observer &observer, const Sink &first)
    : state(std::make_unique<State>()) {
  if (options.inputs.is_given() || options.capture.empty())
    throw Error(option_name("plan") + ": expected a capture.json, which " + option_name("write-capture") +
                    " makes of other inputs",
                Error::usage);
  PlanData data;
  Options given = options;
  // Others encode from another current folder.
  given.capture = std::filesystem::absolute(scene::description_file(options.capture)).string();
  data.capture = scene::read_file(given.capture, largest_capture);
  data.plan = make_plan(given, collecting(observer, data.warnings));
  for (const scene::Camera &camera : data.plan.capture.cameras)
    data.plan.mask_rules.push_back(
        camera.masks ? data.plan.videos->mask_rule(data.plan.capture, *camera.masks) : media::MaskRule::luma);
  std::vector<std::string> warnings;
  data.plan.observer = collecting(observer, warnings);
  StreamSums sums(data.plan);
  Checksum stream;
  {
    const Sink through_sum = summed(first, stream);
    EncodeJob job(data.plan, through_sum);
    job.run_group(0);
    data.decisions = job.decisions();
    sums = job.sums();
  }
  // What was loaded for planning is not needed any more.
  state->data = load_plan(save_plan(std::move(data)), given.capture, {});
  state->first_report = report_of(sums, {state->data.checksum, 0, stream}, warnings);
}

PartPlan::PartPlan(std::string_view bytes, const std::string &name, const std::string &capture)
    : state(std::make_unique<State>()) {
  state->data = load_plan(bytes, name, capture.empty() ? capture : scene::description_file(capture));
}

PartPlan::~PartPlan() = default;
PartPlan::PartPlan(PartPlan &&) noexcept = default;

std::string PartPlan::bytes() const {
  return save_plan(state->data);
}

const std::string &PartPlan::first_report() const {
  return state->first_report;
}

size_t PartPlan::group_count() const {
  return state->data.plan.group_count();
}

size_t PartPlan::frame_count() const {
  return state->data.plan.frame_count();
}

size_t PartPlan::frames_of(size_t group) const {
  return state->data.plan.frames_of(group);
}

std::vector<std::string> PartPlan::files_of(size_t group) const {
  const Plan &plan = state->data.plan;
  scene::Capture capture = plan.capture;
  const int64_t from = plan.tick_of(plan.first_of(group));
  const int64_t to = plan.tick_of(plan.first_of(group) + plan.frames_of(group) - 1);
  scene::Frames &frames = capture.frames;
  frames.first += from * frames.step;
  frames.count = int64_t(plan.frames_of(group));
  frames.left_out.clear();
  for (const int64_t place : plan.capture.frames.left_out)
    if (place > from && place < to) frames.left_out.push_back(place - from);
  capture.sounds.clear(); // they are in the plan, as the environment is
  capture.environment.reset();
  std::vector<std::string> files;
  scene::visit_files(capture, [&](const std::string &path) { files.push_back(path); });
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

std::string PartPlan::encode(size_t group, uint32_t threads, const Sink &sink,
                             const Observer &observer) const {
  const PlanData &data = state->data;
  if (group >= group_count())
    throw Error(group_text(group) + ": expected a number below " + std::to_string(group_count()) +
                    ", the groups of the plan",
                Error::usage);
  const std::string &capture = data.plan.capture.path;
  if (scene::read_file(capture, largest_capture) != data.capture)
    throw Error(capture + ": is not the file that was planned: it has changed, or is another capture");
  std::vector<std::string> warnings;
  Plan plan = data.plan;
  plan.options.threads = threads;
  plan.observer = collecting(observer, warnings);
  plan.videos = std::make_shared<scene::Videos>(threads, plan.capture.memory_limit);
  Checksum stream;
  const Sink through_sum = summed(sink, stream);
  EncodeJob job(plan, through_sum, data.decisions, group);
  job.run_group(group);
  return report_of(job.sums(), {data.checksum, group, stream}, warnings);
}

void PartPlan::check_complete(const std::string &name, const std::vector<bool> &there) const {
  scene::Gaps missing(1);
  for (size_t group = 0; group < group_count(); group++)
    if (group >= there.size() || !there[group]) missing.add(int64_t(group));
  if (missing.ranges().empty()) return;
  const bool one = missing.ranges().size() == 1 && missing.ranges()[0].first == missing.ranges()[0].last;
  throw Error(name + ": of " + std::to_string(group_count()) + " groups " + missing.text() +
              (one ? " is" : " are") + " missing");
}

Merged PartPlan::merge(const std::function<Part(size_t group)> &open_part, const Sink &sink,
                       const Observer &observer) const {
  const PlanData &data = state->data;
  Merged merged;
  merged.warnings = data.warnings;
  Plan plan = data.plan;
  plan.observer = collecting({}, merged.warnings);
  StreamSums sums(plan);
  std::string head;
  Tee tee = {sink, &head};
  const Sink through_tee = [&tee](const void *bytes, size_t size) { tee.write(bytes, size); };
  StreamWriter writer(plan, data.decisions, through_tee);
  tee.kept = nullptr;
  for (size_t group = 0; group < group_count(); group++) {
    observer.check_cancelled();
    const Part part = open_part(group);
    if (group && data.plan.options.repeat_configuration) writer.repeat_configuration();
    const Checksum stream = PartReader(group, *part.stream).copy(head, writer, tee);
    add_report(sums, part.report, part.stream->path(), {data.checksum, group, stream}, merged.warnings);
    observer.progress(frames_of(group));
  }
  merged.bytes = sums.bytes = writer.finish();
  warn_at_end(plan, make_report(plan, data.decisions, sums));
  return merged;
}

} // namespace fvv::mux
