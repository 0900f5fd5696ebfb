// Paths and meshes of a capture, the cache of meshes, and the choice of frames and cameras.
#include "fvv_scene/capture.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/memory_frames.h"
#include "scene/src/atlas/atlas.h"
#include "scene/src/gltf/pose.h"

#include <algorithm>
#include <filesystem>

#include <functional>
#include <future>
#include <list>

namespace fvv::scene {

void Camera::set_name(const std::string &text) {
  name = std::make_shared<const std::string>(text);
  calibration.name = name->data();
  calibration.name_size = name->size();
}

fvv_camera Camera::calibration_at(int64_t frame) const {
  if (!moves()) return calibration;
  fvv_camera camera = per_frame.at(frame);
  camera.name = calibration.name;
  camera.name_size = calibration.name_size;
  return camera;
}

int64_t Frames::place(int64_t i) const {
  // Of the k-th place that is left out, left_out[k] - k frames are before it, which does not fall.
  size_t low = 0, high = left_out.size();
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (left_out[middle] - int64_t(middle) <= i)
      low = middle + 1;
    else
      high = middle;
  }
  return i + int64_t(low);
}

std::vector<int64_t> Frames::numbers() const {
  std::vector<int64_t> out;
  for (int64_t i = 0; i < count; i++) out.push_back(number(i));
  return out;
}

void Frames::leave_out(const std::set<int64_t> &numbers) {
  std::vector<int64_t> gone = left_out;
  for (int64_t i = 0; i < count; i++)
    if (numbers.count(number(i))) gone.push_back(place(i));
  count = places() - int64_t(gone.size());
  std::sort(gone.begin(), gone.end());
  left_out = std::move(gone);
}

std::string description_file(const std::string &given) {
  std::error_code ignored;
  return std::filesystem::is_directory(given, ignored)
             ? (std::filesystem::path(given) / "capture.json").string()
             : given;
}

std::string Capture::resolve(const std::string &file) const {
  // Joining with an absolute path gives that path.
  return (std::filesystem::path(path).parent_path() / file).string();
}

std::string Capture::mesh_path(int64_t frame) const {
  return resolve(meshes.value().file(frame));
}
std::string Capture::picture_path(const Camera &camera, int64_t frame) const {
  return resolve(camera.pictures.value().file(frame));
}
std::string Capture::mask_path(const Camera &camera, int64_t frame) const {
  return resolve(camera.masks.value().file(frame));
}

std::vector<int64_t> Capture::mesh_frames() const {
  std::vector<int64_t> out;
  for (int64_t i = 0; i < frames.count; i++)
    if (const int64_t number = frames.number(i); has_mesh(number)) out.push_back(number);
  return out;
}

std::string Capture::atlas_path(int64_t frame) const {
  const Atlas &source = atlas.value();
  return source.pictures ? resolve(source.pictures->file(frame)) : mesh_path(frame);
}

double Capture::animation_time(int64_t frame) const {
  const MeshAnimation &source = *animation;
  const int64_t index = (frame - source.first) / frames.step;
  // At most 10^7 frames of less than 2^32 time units: exact as integers.
  return double(source.start.numerator) / double(source.start.denominator) +
         double(index * int64_t(frame_duration.numerator)) / double(frame_duration.denominator);
}

// Meshes by frame number and with or without normals; the least recently used one is dropped first.
class MeshCache {
public:
  struct Loaded {
    Mesh mesh;
    MeshReport report;
  };

  std::shared_ptr<const Loaded> get(int64_t frame, bool normals, const std::function<Loaded()> &read) {
    const Key key = {frame, normals};
    std::unique_lock<std::mutex> lock(mutex);
    const auto found = entries.find(key);
    if (found != entries.end()) {
      used.splice(used.end(), used, found->second.place);
      const std::shared_future<std::shared_ptr<const Loaded>> result = found->second.result;
      lock.unlock();
      return result.get();
    }
    std::promise<std::shared_ptr<const Loaded>> promise;
    used.push_back(key);
    entries[key] = {promise.get_future().share(), std::prev(used.end()), 0};
    reads++;
    lock.unlock();
    std::shared_ptr<const Loaded> loaded;
    try {
      loaded = std::make_shared<const Loaded>(read());
    } catch (...) {
      promise.set_exception(std::current_exception());
      throw;
    }
    promise.set_value(loaded);
    lock.lock();
    const auto mine = entries.find(key);
    if (mine == entries.end()) return loaded;
    mine->second.bytes = bytes_of(loaded->mesh);
    held += mine->second.bytes;
    // One that is still being read has no bytes yet; dropping it only costs a second reading.
    while (held > limit && used.size() > 1) {
      const auto oldest = entries.find(used.front());
      held -= oldest->second.bytes;
      entries.erase(oldest);
      used.pop_front();
    }
    return loaded;
  }
  void clear() {
    const std::lock_guard<std::mutex> lock(mutex);
    entries.clear();
    used.clear();
    held = 0;
  }
  uint64_t count() const {
    const std::lock_guard<std::mutex> lock(mutex);
    return reads;
  }

private:
  using Key = std::pair<int64_t, bool>;
  struct Entry {
    std::shared_future<std::shared_ptr<const Loaded>> result;
    std::list<Key>::iterator place;
    size_t bytes;
  };
  static constexpr size_t limit = size_t(128) << 20;

  static size_t bytes_of(const Mesh &mesh) {
    return 8 * (mesh.positions.size() + mesh.texture.size() + mesh.normals.size()) + 4 * mesh.faces.size();
  }

  mutable std::mutex mutex;
  std::map<Key, Entry> entries;
  std::list<Key> used; // the least recently used first
  size_t held = 0;
  uint64_t reads = 0;
};

std::shared_ptr<MeshCache> make_mesh_cache() {
  return std::make_shared<MeshCache>();
}

void clear(MeshCache &cache) {
  cache.clear();
}

uint64_t mesh_reads(const MeshCache &cache) {
  return cache.count();
}

Mesh load_mesh(const Capture &capture, int64_t frame, const fvv_limits *limits, MeshReport *report,
               bool normals) {
  const std::string path = capture.mesh_path(frame);
  const auto read = [&] {
    MeshCache::Loaded loaded;
    if (!capture.memory) check_mesh_memory(path, capture.memory_limit);
    const bool texture = capture.atlas.has_value(), packs = texture && !capture.atlas->pictures;
    FacePictures faces;
    faces.limit = capture.memory_limit;
    faces.bake_repeats = texture && capture.atlas->bake_repeats;
    MeshExtras pictures; // asks an animation for them
    loaded.mesh =
        capture.memory ? capture.memory->mesh(frame, normals)
        : capture.animation
            ? capture.animation->mesh(path, capture.animation_time(frame), limits, &loaded.report, texture,
                                      normals, packs ? &pictures : nullptr, faces.bake_repeats)
        : packs   ? read_mesh_pictures(path, limits, &loaded.report, normals, faces)
        : texture ? read_mesh_texture(path, limits, &loaded.report, normals, faces.bake_repeats)
                  : read_mesh(path, limits, &loaded.report, false, normals);
    for (double &coordinate : loaded.mesh.positions) coordinate *= capture.metres_per_unit;
    return loaded;
  };
  const bool cached = capture.mesh_cache && !capture.memory && !limits;
  const std::shared_ptr<const MeshCache::Loaded> loaded =
      cached ? capture.mesh_cache->get(frame, normals, read)
             : std::make_shared<const MeshCache::Loaded>(read());
  if (report) {
    report->polygons += loaded->report.polygons;
    report->self_crossing += loaded->report.self_crossing;
    report->lines_and_points += loaded->report.lines_and_points;
    report->untextured += loaded->report.untextured;
  }
  Mesh mesh = loaded->mesh;
  if (capture.flip_faces) flip_faces(mesh);
  return mesh;
}

Mesh load_coloured_mesh(const Capture &capture, int64_t frame, std::vector<uint8_t> &colours) {
  const std::string path = capture.mesh_path(frame);
  MeshExtras extras;
  if (!capture.memory) check_mesh_memory(path, capture.memory_limit);
  Mesh mesh = capture.memory      ? capture.memory->mesh(frame, false)
              : capture.animation ? capture.animation->mesh(path, capture.animation_time(frame), nullptr,
                                                            nullptr, false, false, &extras)
                                  : read_mesh(path, nullptr, nullptr, false, false, &extras);
  for (double &coordinate : mesh.positions) coordinate *= capture.metres_per_unit;
  colours = std::move(extras.colours);
  return mesh;
}

void find_empty_meshes(Capture &capture) {
  if (!capture.meshes || capture.animation || capture.memory) return;
  for (const int64_t number : capture.frames.numbers())
    if (capture.has_mesh(number) && is_empty_mesh(capture.mesh_path(number))) capture.empty.insert(number);
}

MeshPicture load_embedded_atlas(const Capture &capture, int64_t frame) {
  // An empty stage shows no picture: that of the frame before costs least, of the first one there is that
  // after.
  const std::vector<int64_t> frames = capture.mesh_frames();
  auto source = std::upper_bound(frames.begin(), frames.end(), frame);
  if (source != frames.begin()) --source;
  const std::string path = capture.mesh_path(source == frames.end() ? frame : *source);
  check_mesh_memory(path, capture.memory_limit);
  return read_mesh_picture(path, capture.memory_limit);
}

AtlasSize embedded_atlas_size(const Capture &capture, int64_t frame) {
  const std::string path = capture.mesh_path(frame);
  check_mesh_memory(path, capture.memory_limit);
  return mesh_picture_size(path);
}

MeshAnimation::MeshAnimation(std::optional<Name> animation, fvv_rational from, int64_t first_frame)
    : name(std::move(animation)), start(from), first(first_frame) {}
MeshAnimation::~MeshAnimation() = default;

const gltf::Scene &MeshAnimation::read(const std::string &path, gltf::Texture texture, bool normals) const {
  const std::lock_guard<std::mutex> lock(mutex);
  std::unique_ptr<const gltf::Scene> &scene = scenes[{texture, normals}];
  if (!scene) {
    gltf::AnimationChoice choice = gltf::OnlyAnimation{};
    if (name) std::visit([&](const auto &value) { choice = value; }, *name);
    // The defaults hold for the file, those of a caller for the mesh: callers share what was read.
    scene = std::make_unique<const gltf::Scene>(gltf::read_scene(
        read_file(path, max_mesh_file), path, choice, limits_or_default(nullptr), texture, normals));
  }
  return *scene;
}

Mesh MeshAnimation::mesh(const std::string &path, double time, const fvv_limits *limits, MeshReport *report,
                         bool texture, bool normals, MeshExtras *extras, bool bake_repeats) const {
  const gltf::Scene &source = read(path, gltf::texture_for(texture, extras), normals);
  Mesh out = gltf::pose(source, time, texture ? nullptr : extras);
  if (texture) {
    FacePictures faces = extras ? gltf::face_pictures(source) : FacePictures();
    faces.bake_repeats = bake_repeats;
    settle_texture(out, faces, limits_or_default(limits), path,
                   bake_repeats ? gltf::pose(source, std::nullopt).positions : std::vector<double>());
  }
  const fvv_limits bounds = limits_or_default(limits);
  if (out.vertex_count() > bounds.max_vertices || out.face_count() > bounds.max_faces)
    throw Error(path + ": " + std::to_string(out.vertex_count()) + " vertices and " +
                std::to_string(out.face_count()) + " faces, at most " + std::to_string(bounds.max_vertices) +
                " and " + std::to_string(bounds.max_faces) + " are allowed");
  if (report) report->lines_and_points += source.report.lines_and_points;
  return out;
}

double MeshAnimation::end(const std::string &path, bool texture) const {
  double last = 0;
  for (const gltf::Channel &channel : read(path, gltf::texture_for(texture, nullptr), false).channels)
    last = std::max(last, channel.times.back());
  return last;
}

namespace {

// Which cameras one item of --cameras names: all of that name, else those of an identifier or a range.
std::vector<size_t> named_cameras(const Capture &capture, const std::string &item) {
  std::vector<size_t> found;
  for (size_t i = 0; i < capture.cameras.size(); i++)
    if (*capture.cameras[i].name == item) found.push_back(i);
  if (!found.empty()) return found;
  if (const std::optional<Range> range = fvv::scan_range(item))
    for (size_t i = 0; i < capture.cameras.size(); i++) {
      const int64_t id = capture.cameras[i].calibration.id;
      if (id >= range->first && id <= range->last) found.push_back(i);
    }
  if (found.empty()) {
    std::string known;
    for (const Camera &camera : capture.cameras) {
      const std::string id = std::to_string(camera.calibration.id);
      known += (known.empty() ? "" : ", ") + (camera.name->empty() ? id : id + " " + *camera.name);
    }
    throw Error(option_name("cameras") +
                    ": expected identifiers, ranges or names of the capture's cameras (" + known +
                    "), found " + quote(item),
                Error::usage);
  }
  return found;
}

} // namespace

void restrict_frames(Capture &capture, const Range &range) {
  Frames &frames = capture.frames;
  const int64_t last = frames.number_at(frames.places() - 1);
  for (const int64_t end : {range.first, range.last})
    if (end < frames.first || end > last || (end - frames.first) % frames.step)
      throw Error(option_name("frames") + ": expected frame numbers of the capture, " +
                      std::to_string(frames.first) + " to " + std::to_string(last) + " in steps of " +
                      std::to_string(frames.step) + ", found " + std::to_string(end),
                  Error::usage);
  std::set<int64_t> left_out;
  for (const int64_t place : frames.left_out) left_out.insert(frames.number_at(place));
  frames.count = (range.last - range.first) / frames.step + 1;
  frames.first = range.first;
  frames.left_out.clear();
  frames.leave_out(left_out);
  if (!frames.count)
    throw Error(option_name("frames") + ": all of these frames are left out by " + capture.path,
                Error::usage);
}

void restrict_cameras(Capture &capture, const std::vector<std::string> &items) {
  if (items.empty()) return;
  std::vector<bool> wanted(capture.cameras.size());
  for (const std::string &item : items)
    for (const size_t i : named_cameras(capture, item)) wanted[i] = true;
  std::vector<Camera> kept;
  for (size_t i = 0; i < wanted.size(); i++)
    if (wanted[i]) kept.push_back(std::move(capture.cameras[i]));
  capture.cameras = std::move(kept);
}

std::string describe(uint16_t id, const std::string &name) {
  return "camera " + std::to_string(id) + (name.empty() ? "" : " (" + name + ")");
}

std::string describe(const Camera &camera) {
  return describe(camera.calibration.id, *camera.name);
}

} // namespace fvv::scene
