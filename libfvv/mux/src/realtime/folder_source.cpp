#include "mux/src/realtime/folder_source.h"
#include "fvv_cxx/parallel.h"
#include "fvv_scene/mesh_file.h"

#include <algorithm>

namespace fvv::mux {

namespace {

// Between two tries to read a file that is not whole.
constexpr std::chrono::milliseconds retry{20};

template <class Image> Image sized(Image image, const fvv_camera &camera, const std::string &path) {
  if (image.width != camera.width || image.height != camera.height)
    throw Unusable(path + ": expected " + std::to_string(camera.width) + " x " +
                   std::to_string(camera.height) + " pixels, found " + std::to_string(image.width) + " x " +
                   std::to_string(image.height));
  return image;
}

} // namespace

FolderSource::FolderSource(const scene::Capture &from, const Options &given, const RealtimeOptions &realtime,
                           std::function<bool()> is_stopped, std::function<bool(Clock::time_point)> too_late)
    : capture(from), options(given), is_too_late(std::move(too_late)),
      videos(given.threads, from.memory_limit), cameras(from.cameras), mask_facts(cameras.size()),
      arrivals(from, realtime, std::move(is_stopped)) {}

void FolderSource::close() {
  closed = true;
  arrivals.close();
}

FrameSource::Item FolderSource::next() {
  const scene::Frames &frames = capture.frames;
  if (place == frames.places()) return {Item::ended, 0, {}, {}, "all frames of the capture came"};
  const int64_t at = place++, number = frames.number_at(at);
  if (std::binary_search(frames.left_out.begin(), frames.left_out.end(), at)) return {Item::left_out, number};
  const Arrivals::Fate fate = arrivals.await(at);
  if (fate.kind == Arrivals::Fate::ended || fate.kind == Arrivals::Fate::given_up)
    return {fate.kind == Arrivals::Fate::ended ? Item::ended : Item::given_up,
            number,
            fate.time,
            {},
            fate.reason};
  return read(at, fate);
}

FrameSource::Item FolderSource::read(int64_t at, const Arrivals::Fate &fate) {
  const int64_t number = capture.frames.number_at(at);
  if (fate.kind == Arrivals::Fate::lost) return {Item::lost, number, fate.time, {}, fate.reason};
  if (is_too_late(fate.time)) return {Item::dropped, number, fate.time};
  const Clock::time_point start = Clock::now();
  while (true) {
    const bool is_last_try = arrivals.has_ended() || Clock::now() - start > Arrivals::patience || closed;
    try {
      return {Item::frame, number, fate.time, read_frame(number)};
    } catch (const Unusable &error) {
      return {Item::lost, number, fate.time, {}, error.line()};
    } catch (const Error &error) {
      if (is_last_try) return {Item::lost, number, fate.time, {}, error.line()};
    }
    std::this_thread::sleep_for(retry);
  }
}

// By the masks so far: the first ones may be empty.
media::MaskRule FolderSource::mask_rule(size_t camera, const std::string &path) {
  std::optional<media::MaskRule> &known = cameras[camera].masks->mask_rule;
  if (known) return *known;
  const std::optional<media::MaskFacts> more = media::MaskFacts::of(path);
  if (!more) return *(known = media::MaskRule::luma);
  std::optional<media::MaskFacts> &facts = mask_facts[camera];
  if (facts)
    facts->add(*more);
  else
    facts = more;
  if (facts->is_decided()) known = facts->rule();
  return facts->rule();
}

Frame FolderSource::read_frame(int64_t number) {
  Frame frame;
  frame.pictures.resize(cameras.size());
  frame.masks.resize(cameras.size());
  const bool has_mesh = capture.has_mesh(number);
  fvv::parallel(options.threads, cameras.size() + has_mesh, [&](size_t i) {
    if (i == cameras.size()) {
      const std::string path = capture.mesh_path(number);
      if (scene::is_empty_mesh(path)) return;
      frame.mesh = scene::load_mesh(capture, number, nullptr, nullptr, options.normals != Normals::never);
      geometry::check(frame.mesh, path);
      return;
    }
    const scene::Camera &camera = cameras[i];
    if (!camera.pictures) return;
    media::with_sample_type(options.codec, options.bit_depth, [&](auto sample) {
      frame.pictures[i] = sized(videos.read<decltype(sample)>(capture, *camera.pictures, number, 3),
                                camera.calibration, capture.picture_path(camera, number));
      return 0;
    });
    if (!camera.masks) return;
    const std::string path = capture.mask_path(camera, number);
    scene::PictureSource masks = *camera.masks;
    masks.mask_rule = mask_rule(i, path);
    frame.masks[i] = sized(videos.read<uint8_t>(capture, masks, number, 1), camera.calibration, path);
  });
  add_calibrations(capture, number, frame);
  return frame;
}

} // namespace fvv::mux
