#include "fvv_scene/pictures.h"
#include "fvv_cxx/input_file.h"
#include "fvv_media/mask.h"
#include "fvv_media/packed_image.h"
#include "fvv_media/video_file.h"
#include "fvv_scene/memory_frames.h"
#include "scene/src/video/video_match.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>

namespace fvv::scene {

namespace {

// A decoder of 1080p holds some 50 MB; one for every file there must be.
constexpr size_t most_readers = 64;

struct Video {
  std::mutex mutex; // of all below
  std::condition_variable freed;
  std::vector<std::unique_ptr<media::VideoFile>> idle;
  size_t opened = 0; // without model
  std::unique_ptr<media::VideoFile>
      model;             // the first one opened; others are opened by it, nothing is read from it
  VideoFacts facts = {}; // of model
};

VideoFacts facts_of(const media::VideoInfo &info) {
  return {info.width, info.height, info.rotation, {info.tick, info.times}, info.warnings, info.timecode};
}

// A reader lent to one thread, given back at the end.
class Loan {
public:
  // Of idle readers the one whose position is nearest before the picture, else a new one.
  Loan(Video &from, size_t picture, size_t most) : video(from) {
    std::unique_lock<std::mutex> lock(video.mutex);
    video.freed.wait(lock, [&] { return !video.idle.empty() || video.opened < most; });
    const auto distance = [&](const std::unique_ptr<media::VideoFile> &idle) {
      // The picture before the position, the last one returned, costs nothing.
      return idle->position() <= picture + 1 ? picture + 1 - idle->position() : SIZE_MAX;
    };
    const auto best =
        std::min_element(video.idle.begin(), video.idle.end(),
                         [&](const auto &a, const auto &b) { return distance(a) < distance(b); });
    constexpr size_t near = 8; // pictures that are decoded faster than a file is opened
    if (video.opened < most && (best == video.idle.end() || distance(*best) > near)) {
      reader = std::make_unique<media::VideoFile>(video.model->another());
      video.opened++;
      return;
    }
    reader = std::move(*best);
    video.idle.erase(best);
  }
  ~Loan() {
    const std::lock_guard<std::mutex> lock(video.mutex);
    video.idle.push_back(std::move(reader));
    video.freed.notify_one();
  }
  Loan(const Loan &) = delete;

  media::VideoFile &operator*() { return *reader; }

private:
  Video &video;
  std::unique_ptr<media::VideoFile> reader;
};

// Stills that several frames share, as they are stored, by path and channels.
template <class Sample> struct Constants {
  std::mutex mutex;
  std::map<std::pair<std::string, int>, media::BasicImage<Sample>> pictures;

  // The first caller reads, the others wait for it.
  template <class Read>
  media::BasicImage<Sample> get(const std::string &path, int channels, const Read &read) {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = pictures.find({path, channels});
    if (found != pictures.end()) return found->second;
    return pictures.emplace(std::pair(path, channels), read()).first->second;
  }
};

// The rule for the masks of each camera, by the pattern of their files. The first caller looks at the files,
// in order and no further than needed; others wait for it.
class MaskRules {
public:
  media::MaskRule of(const Capture &capture, const PictureSource &source) {
    if (source.mask_rule) return *source.mask_rule;
    const std::lock_guard<std::mutex> lock(mutex);
    const Key key(capture.resolve(source.text()), source.file(capture.frames.number(0)));
    const auto found = rules.find(key);
    if (found != rules.end()) return found->second;
    return rules.emplace(key, look(capture, source)).first->second;
  }

private:
  static media::MaskRule look(const Capture &capture, const PictureSource &source) {
    std::optional<media::MaskFacts> facts;
    const int64_t count = source.is_constant() ? 1 : capture.frames.count;
    // The ends and the middle first: objects come and go.
    std::vector<int64_t> order = {0, count - 1, count / 2};
    for (int64_t i = 0; i < count; i++) order.push_back(i);
    std::set<int64_t> seen;
    for (const int64_t i : order) {
      if (!seen.insert(i).second) continue;
      const std::string path = capture.resolve(source.file(capture.frames.number(i)));
      if (!why_unreadable(path).empty()) continue; // whatever needs the file reports it
      media::check_image_memory(path, capture.memory_limit);
      const auto more = media::MaskFacts::of(path);
      if (!more) return media::MaskRule::luma; // lossy: what is little above 0 is noise
      if (facts)
        facts->add(*more);
      else
        facts = more;
      if (facts->is_decided()) break;
    }
    return facts ? facts->rule() : media::MaskRule::luma;
  }

  using Key = std::pair<std::string, std::string>; // pattern, and first file: offsets may differ
  std::mutex mutex;
  std::map<Key, media::MaskRule> rules;
};

// A cache of masks. When it is full nothing is added or dropped: passes go through the frames in the same
// order, and the first ones stay.
class Masks {
public:
  // Path, stream of a video, picture of a video, degrees.
  using Key = std::tuple<std::string, std::optional<uint32_t>, size_t, int>;

  // None if it is not cached.
  std::optional<media::Image> find(const Key &key) {
    std::unique_lock<std::mutex> lock(mutex);
    const auto found = masks.find(key);
    if (found == masks.end()) return std::nullopt;
    const media::PackedImage<uint8_t> &mask = found->second; // does not move
    lock.unlock();
    return mask.image();
  }

  void keep(const Key &key, const media::Image &mask) {
    media::PackedImage<uint8_t> packed(mask);
    const size_t size = packed.bytes() + std::get<0>(key).size() + 200; // 200: of the map's node
    const std::lock_guard<std::mutex> lock(mutex);
    if (bytes + size > most_bytes) return;
    if (masks.emplace(key, std::move(packed)).second) bytes += size;
  }

private:
  static constexpr size_t most_bytes = size_t(64) << 20;
  std::mutex mutex;
  std::map<Key, media::PackedImage<uint8_t>> masks;
  size_t bytes = 0;
};

// The picture that a calibration is about.
template <class Sample>
media::BasicImage<Sample> put(const media::BasicImage<Sample> &image, const Placement &place, bool is_mask) {
  media::BasicImage<Sample> out =
      media::make_image<Sample>(place.width, place.height, image.channels, Sample(0));
  const auto channels = size_t(image.channels);
  for (uint32_t y = 0; y < place.height; y++)
    for (uint32_t x = 0; x < place.width; x++) {
      const int64_t column = int64_t(x) - place.x, row = int64_t(y) - place.y;
      const int64_t u = std::clamp<int64_t>(column, 0, image.width - 1),
                    v = std::clamp<int64_t>(row, 0, image.height - 1);
      if (is_mask && (u != column || v != row)) continue;
      std::copy_n(&image.pixels[(size_t(v) * image.width + size_t(u)) * channels], channels,
                  &out.pixels[(size_t(y) * place.width + x) * channels]);
    }
  return out;
}

} // namespace

struct Videos::Shared {
  Masks masks;
  MaskRules mask_rules;
  std::atomic<uint64_t> pictures_read = 0, masks_read = 0;
  Constants<uint8_t> stills;
  Constants<uint16_t> deep_stills;
  Constants<float> linear_stills;
  unsigned threads;
  media::MemoryLimit limit;
  std::mutex mutex; // of videos
  std::map<std::pair<std::string, std::optional<uint32_t>>, std::unique_ptr<Video>> videos;

  Video &video(const std::string &path, std::optional<uint32_t> stream) {
    const std::lock_guard<std::mutex> lock(mutex);
    std::unique_ptr<Video> &video = videos[{path, stream}];
    if (!video) {
      auto opened = std::make_unique<Video>();
      opened->model = std::make_unique<media::VideoFile>(path, stream, limit);
      opened->facts = facts_of(opened->model->info());
      video = std::move(opened);
    }
    return *video;
  }
  template <class Sample> Constants<Sample> &constants() {
    if constexpr (std::is_same_v<Sample, uint8_t>)
      return stills;
    else if constexpr (std::is_same_v<Sample, uint16_t>)
      return deep_stills;
    else
      return linear_stills;
  }
  size_t most_of_each() {
    const std::lock_guard<std::mutex> lock(mutex);
    return std::clamp<size_t>(most_readers / videos.size(), 1, threads);
  }
};

Videos::Videos(unsigned threads, const media::MemoryLimit &limit) : shared(std::make_unique<Shared>()) {
  shared->threads = threads;
  shared->limit = limit;
}
Videos::~Videos() = default;

VideoFacts Videos::facts(const std::string &path, std::optional<uint32_t> stream) {
  return shared->video(path, stream).facts;
}

template <class Sample>
media::BasicImage<Sample> Videos::read(const Capture &capture, const PictureSource &source, int64_t frame,
                                       int channels) {
  if (capture.memory) {
    if constexpr (std::is_same_v<Sample, uint8_t>)
      if (channels == 1) return capture.memory->mask(frame, source.memory_camera);
    return capture.memory->picture<Sample>(frame, source.memory_camera);
  }
  const std::string path = capture.resolve(source.file(frame));
  const bool constant = !source.video && source.is_constant() && capture.frames.count > 1;
  Video *video = source.video ? &shared->video(path, source.video->stream) : nullptr;
  const size_t picture = video ? FrameClock(capture, *source.video).nearest(video->facts.times, frame) : 0;
  const int turned = source.rotate.value_or(video ? video->facts.rotation.value_or(0) : 0);
  const auto read_still = [&]() -> media::BasicImage<Sample> {
    media::check_image_memory(path, capture.memory_limit);
    if constexpr (std::is_same_v<Sample, uint8_t>)
      if (channels == 1) return media::read_mask(path, shared->mask_rules.of(capture, source));
    return media::read_image<Sample>(path, channels);
  };
  const auto read_anew = [&] {
    if (constant) return media::rotate(shared->constants<Sample>().get(path, channels, read_still), turned);
    (channels == 1 ? shared->masks_read : shared->pictures_read)++;
    if (!video) return media::rotate(read_still(), turned);
    Loan reader(*video, picture, shared->most_of_each());
    return media::rotate((*reader).picture<Sample>(picture, channels), turned);
  };
  const auto placed = [&](media::BasicImage<Sample> &&image) {
    return source.place ? put(image, *source.place, channels == 1) : std::move(image);
  };
  if constexpr (std::is_same_v<Sample, uint8_t>)
    if (channels == 1 && !constant) {
      const Masks::Key key(path, source.video ? source.video->stream : std::nullopt, picture, turned);
      if (std::optional<media::Image> mask = shared->masks.find(key)) return placed(std::move(*mask));
      media::Image mask = read_anew();
      shared->masks.keep(key, mask);
      return placed(std::move(mask));
    }
  return placed(read_anew());
}

media::MaskRule Videos::mask_rule(const Capture &capture, const PictureSource &source) {
  if (source.video || capture.memory) return media::MaskRule::luma;
  return shared->mask_rules.of(capture, source);
}

PictureReads Videos::reads() const {
  return {shared->pictures_read, shared->masks_read};
}

template media::Image Videos::read(const Capture &, const PictureSource &, int64_t, int);
template media::DeepImage Videos::read(const Capture &, const PictureSource &, int64_t, int);
template media::LinearImage Videos::read(const Capture &, const PictureSource &, int64_t, int);

} // namespace fvv::scene
