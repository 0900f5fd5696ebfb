#include "compare/src/sequence.h"

#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"
#include "fvv_cxx/owned.h"
#include "fvv_cxx/rung.h"
#include "fvv_demux/frame_plan.h"
#include "fvv_demux/meshes.h"
#include "fvv_scene/capture.h"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <numeric>
#include <set>

namespace fvv::compare {

namespace {

// A folder or a JSON file describes a capture, everything else has to be a stream.
bool describes_capture(const std::string &path) {
  return std::filesystem::path(path).extension() == ".json";
}

// Seconds a frame, in lowest terms.
fvv_rational duration_of(const fvv_scene &scene, const std::string &name) {
  const uint64_t ticks = uint64_t(scene.frame_duration); // > 0, checked by libfvv
  const auto &base = scene.time_base;
  uint64_t common = std::gcd(ticks, uint64_t(base.denominator));
  const uint64_t numerator = ticks / common;
  uint64_t denominator = base.denominator / common;
  if (numerator > UINT32_MAX / base.numerator)
    throw Error(name + ": a frame of " + std::to_string(ticks) + " ticks is too long");
  common = std::gcd(numerator * base.numerator, denominator);
  return {uint32_t(numerator * base.numerator / common), uint32_t(denominator / common)};
}

// Positions, normals and copies of a vertex; the corners of a face, and what finds neighbours.
constexpr uint64_t vertex_bytes = 192, face_bytes = 96;

fvv_limits limits_within(const media::MemoryLimit &limit) {
  fvv_limits out;
  fvv_limits_default(&out);
  out.max_vertices = uint32_t(std::min<uint64_t>(out.max_vertices, limit.bytes / 2 / vertex_bytes + 1));
  out.max_faces = uint32_t(std::min<uint64_t>(out.max_faces, limit.bytes / 2 / face_bytes + 1));
  return out;
}

} // namespace

class Sequence::State {
public:
  State(const std::string &path, const media::MemoryLimit &limit);
  State(std::unique_ptr<InputFile> opened, size_t rung, const fvv_limits *limits);
  State(const std::string &the_name, std::vector<geometry::Mesh> given);

  geometry::Mesh mesh(size_t i, bool normals) const;

  enum class Kind { capture, stream, memory } kind;
  std::string name;
  bool unknown_scale = false;
  fvv_rational duration = {1, 25};
  std::vector<std::string> notes;
  std::vector<Frame> list;
  scene::Capture capture;
  bool owns_file = false;

private:
  void open_stream(size_t rung, const fvv_limits *limits);
  void open_capture();
  void number_frames(uint64_t ticks, size_t count);
  geometry::Mesh stream_mesh(const Frame &wanted) const;
  std::set<int64_t> mesh_times() const;

  std::vector<geometry::Mesh> meshes; // in memory
  std::unique_ptr<InputFile> file;
  std::unique_ptr<fvv_stream, void (*)(fvv_stream *)> stream{nullptr, fvv_stream_close};
  mutable std::mutex one_at_a_time; // a stream's handle is not thread-safe
  uint16_t track = 0;
  media::MemoryLimit memory_limit;
  fvv_limits lowered = {}; // by it
};

Sequence::State::State(const std::string &path, const media::MemoryLimit &limit)
    : kind(describes_capture(scene::description_file(path)) ? Kind::capture : Kind::stream),
      name(scene::description_file(path)), memory_limit(limit) {
  if (kind == Kind::capture) {
    open_capture();
  } else {
    file = std::make_unique<InputFile>(name);
    owns_file = true;
    lowered = limits_within(memory_limit);
    open_stream(0, &lowered);
  }
}

Sequence::State::State(std::unique_ptr<InputFile> opened, size_t rung, const fvv_limits *limits)
    : kind(Kind::stream), name(opened->path()), file(std::move(opened)) {
  open_stream(rung, limits);
}

Sequence::State::State(const std::string &the_name, std::vector<geometry::Mesh> given)
    : kind(Kind::memory), name(the_name), meshes(std::move(given)) {
  for (size_t i = 0; i < meshes.size(); i++) {
    meshes[i].texture.clear(); // seams of texture coordinates are no part of the surface
    list.push_back({int64_t(i), int64_t(i), i});
  }
  if (list.empty()) throw Error(name + ": no frame has a mesh");
}

void Sequence::State::open_capture() {
  capture = scene::load_capture(name);
  capture.memory_limit = memory_limit;
  if (!capture.meshes) throw Error(name + ": the capture has no meshes");
  capture.atlas.reset(); // seams of texture coordinates are no part of the surface
  unknown_scale = capture.scale_unknown;
  duration = capture.frame_duration;
  scene::find_empty_meshes(capture);
  for (int64_t i = 0; i < capture.frames.count; i++)
    if (const int64_t number = capture.frames.number(i); capture.has_mesh(number))
      list.push_back({number, capture.frames.place(i), 0});
  if (list.empty()) throw Error(name + ": no frame has a mesh");
}

void Sequence::State::open_stream(size_t rung, const fvv_limits *limits) {
  const fvv_input input = file->input();
  fvv_stream *opened = nullptr;
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_stream_open(&input, limits, nullptr, &opened, &diagnostic), name, diagnostic);
  stream.reset(opened);
  if (fvv_stream_damage_count(opened)) notes.push_back(demux::text_of(*fvv_stream_damage(opened, 0)));
  const size_t count = fvv_stream_frame_count(opened);
  if (!count) throw Error(name + ": the stream has no frames");
  const fvv_configuration *configuration = nullptr;
  fvv::check(fvv_stream_configuration(opened, 0, &configuration, &diagnostic), name, diagnostic);
  for (size_t i = 0; i < configuration->track_count && !track; i++)
    if (configuration->tracks[i].kind == FVV_TRACK_MESH &&
        in_rung(*configuration, configuration->tracks[i].id, rung))
      track = configuration->tracks[i].id;
  if (!track) throw Error(name + ": the stream has no meshes");
  unknown_scale = configuration->scene.flags & FVV_SCENE_SCALE_UNKNOWN;
  duration = duration_of(configuration->scene, name);
  number_frames(uint64_t(configuration->scene.frame_duration), count);
}

// By their times, so that a missing frame shifts none of those after it. Where the first groups are missing,
// writers mostly begin at tick 0.
void Sequence::State::number_frames(uint64_t ticks, size_t count) {
  const bool beheaded = fvv_stream_group(stream.get(), 0)->sequence > 0;
  if (beheaded) notes.push_back("the first groups are not there: frames are numbered from tick 0");
  const auto start = beheaded ? 0 : uint64_t(fvv_stream_group(stream.get(), 0)->start);
  bool regular = true;
  for (size_t i = 0; i < count; i++) {
    fvv_frame frame;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_stream_frame(stream.get(), i, &frame, &diagnostic), name, diagnostic);
    // Times may lie anywhere in 64 bits; they rise, so the difference fits without a sign.
    const uint64_t since = uint64_t(frame.time) - start, place = since / ticks;
    regular = regular && since % ticks == 0 && place <= uint64_t(INT64_MAX) / 4;
    list.push_back({int64_t(place), int64_t(place), i});
  }
  if (!regular) {
    notes.push_back("frames are at no whole numbers of frame durations: they are numbered in their order");
    for (size_t i = 0; i < count; i++) list[i] = {int64_t(i), int64_t(i), i};
  }
  const std::set<int64_t> times = mesh_times();
  const auto is_empty = [&](const Frame &frame) {
    fvv_frame info;
    return fvv_stream_frame(stream.get(), frame.index, &info, nullptr) == FVV_OK && !times.count(info.time);
  };
  list.erase(std::remove_if(list.begin(), list.end(), is_empty), list.end());
  if (list.empty()) throw Error(name + ": no frame has a mesh");
}

// By the tables of the groups; what cannot be read of them is reported when the frame is compared.
std::set<int64_t> Sequence::State::mesh_times() const {
  std::set<int64_t> times;
  for (size_t group = 0; group < fvv_stream_group_count(stream.get()); group++) {
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0;
    if (fvv_stream_group_chunks(stream.get(), group, &chunks, &count, nullptr) != FVV_OK) continue;
    for (size_t i = 0; i < count; i++)
      if (chunks[i].type == FVV_CHUNK_MESH && chunks[i].track == track) times.insert(chunks[i].time);
  }
  return times;
}

geometry::Mesh Sequence::State::mesh(size_t i, bool normals) const {
  geometry::Mesh mesh = kind == Kind::memory ? meshes[i]
                        : kind == Kind::stream
                            ? stream_mesh(list[i])
                            : scene::load_mesh(capture, list[i].number, nullptr, nullptr, normals);
  if (mesh.faces.empty())
    throw Error(name + ": frame " + std::to_string(list[i].number) + ": the mesh has no faces");
  return mesh;
}

geometry::Mesh Sequence::State::stream_mesh(const Frame &wanted) const {
  const size_t i = wanted.index;
  const std::string where = name + ": frame " + std::to_string(wanted.number);
  fvv_diagnostic diagnostic = {};
  OwnedMesh holder;
  fvv_scene scene;
  fvv_status status;
  {
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    fvv_frame frame;
    fvv::check(fvv_stream_frame(stream.get(), i, &frame, &diagnostic), where, diagnostic);
    const fvv_configuration *configuration = nullptr;
    fvv::check(fvv_stream_configuration(stream.get(), frame.group, &configuration, &diagnostic), where,
               diagnostic);
    scene = configuration->scene;
    status = fvv_stream_mesh(stream.get(), i, track, &holder, &diagnostic);
  }
  if (status == FVV_ERROR_LIMIT && memory_limit.bytes != UINT64_MAX)
    throw media::MemoryError(where + ": " + diagnostic.message + "; " + memory_limit.name + " allows " +
                             std::to_string(memory_limit.bytes) + " bytes");
  fvv::check(status, where, diagnostic);
  if (status == FVV_END) throw Error(where + ": has no mesh");
  geometry::Mesh out = demux::in_metres(holder, demux::lattice_of(scene.lattice_origin, scene.lattice_step));
  out.texture.clear(); // no part of the surface either
  return out;
}

Sequence::Sequence(const std::string &path, const media::MemoryLimit &limit)
    : state(std::make_unique<State>(path, limit)) {}
Sequence::Sequence(const std::string &path) : Sequence(path, media::MemoryLimit()) {}
Sequence::Sequence(const fvv_input &stream, const std::string &name, size_t rung, const fvv_limits *limits)
    : state(std::make_unique<State>(std::make_unique<InputFile>(stream, name), rung, limits)) {}
Sequence::Sequence(const std::string &name, std::vector<geometry::Mesh> meshes)
    : state(std::make_unique<State>(name, std::move(meshes))) {}
Sequence::~Sequence() = default;

const std::string &Sequence::path() const {
  return state->name;
}
bool Sequence::is_capture() const {
  return state->kind == State::Kind::capture;
}
bool Sequence::is_in_memory() const {
  return state->kind == State::Kind::memory;
}
bool Sequence::scale_unknown() const {
  return state->unknown_scale;
}
fvv_rational Sequence::frame_duration() const {
  return state->duration;
}
const std::vector<std::string> &Sequence::warnings() const {
  return state->notes;
}
const std::vector<Sequence::Frame> &Sequence::frames() const {
  return state->list;
}
geometry::Mesh Sequence::mesh(size_t i, bool normals) const {
  return state->mesh(i, normals);
}
void Sequence::visit_files(const std::function<void(const std::string &)> &visit) const {
  if (state->owns_file) visit(state->name);
  if (is_capture()) scene::visit_files(state->capture, visit);
}

namespace {

std::string text_of(fvv_rational duration) {
  return std::to_string(duration.numerator) + "/" + std::to_string(duration.denominator) + " s";
}

// The numbers of A by the options frames and start.
const Sequence::Frame &frame_of(const Sequence &a, int64_t number, const char *option) {
  const auto &list = a.frames();
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const auto &f) { return f.number == number; });
  if (found != list.end()) return *found;
  refuse_option(option, "expected a frame of " + a.path() + ", which has " +
                            std::to_string(list.front().number) + " to " +
                            std::to_string(list.back().number) + ", found " + std::to_string(number));
}

// "a.fvv: 3 of 50 frames have no partner: 47 to 49"
void tell_alone(const Sequence &sequence, const std::vector<bool> &counts, const std::vector<bool> &met,
                std::vector<std::string> &warnings) {
  const auto &list = sequence.frames();
  scene::Gaps gaps(list.size() > 1 ? list[1].number - list[0].number : 1);
  size_t alone = 0, all = 0;
  for (size_t i = 0; i < list.size(); i++) {
    if (!counts[i]) continue;
    all++;
    if (met[i]) continue;
    alone++;
    gaps.add(list[i].number);
  }
  if (alone)
    warnings.push_back(sequence.path() + ": " + std::to_string(alone) + " of " + std::to_string(all) +
                       (alone == 1 ? " frames has no partner: " : " frames have no partner: ") + gaps.text());
}

} // namespace

Matching match(const Sequence &a, const Sequence &b, const std::optional<fvv::Range> &frames,
               std::optional<int64_t> start) {
  const bool declared = !a.is_in_memory() && !b.is_in_memory();
  if (declared && a.scale_unknown() != b.scale_unknown())
    throw Error("unlike units: " + a.path() + " is in " +
                (a.scale_unknown() ? "units of its source" : "metres") + ", " + b.path() + " in " +
                (b.scale_unknown() ? "units of its source" : "metres"));
  const fvv_rational one = a.frame_duration(), other = b.frame_duration();
  if (declared && (one.numerator != other.numerator || one.denominator != other.denominator))
    throw Error("unlike frame rates: a frame of " + a.path() + " lasts " + text_of(one) + ", one of " +
                b.path() + " " + text_of(other));
  const bool by_number = !start && a.is_capture() && b.is_capture();
  const int64_t shift = start ? frame_of(a, *start, "start").place : 0;
  const auto key_of_a = [&](const Sequence::Frame &f) { return by_number ? f.number : f.place; };
  const auto key_of_b = [&](const Sequence::Frame &f) { return by_number ? f.number : f.place + shift; };
  int64_t first = INT64_MIN, last = INT64_MAX; // selected keys
  if (frames) {
    first = key_of_a(frame_of(a, frames->first, "frames"));
    last = key_of_a(frame_of(a, frames->last, "frames"));
  }
  const auto &in_a = a.frames(), &in_b = b.frames();
  std::vector<bool> counts_a(in_a.size()), counts_b(in_b.size()), met_a(in_a.size()), met_b(in_b.size());
  const auto inside = [&](int64_t key) { return key >= first && key <= last; };
  for (size_t i = 0; i < in_a.size(); i++) counts_a[i] = inside(key_of_a(in_a[i]));
  for (size_t k = 0; k < in_b.size(); k++) counts_b[k] = inside(key_of_b(in_b[k]));
  Matching out;
  for (size_t i = 0, k = 0; i < in_a.size() && k < in_b.size();) {
    const int64_t left = key_of_a(in_a[i]), right = key_of_b(in_b[k]);
    if (left == right && counts_a[i]) {
      met_a[i] = met_b[k] = true;
      out.pairs.push_back({i, k});
    }
    i += left <= right;
    k += right <= left;
  }
  if (out.pairs.empty())
    throw Error(a.path() + " and " + b.path() + " have no frame in common; " + option_name("start") +
                " says which frame of the first is the second's first");
  tell_alone(a, counts_a, met_a, out.warnings);
  tell_alone(b, counts_b, met_b, out.warnings);
  return out;
}

} // namespace fvv::compare
