#include "fvvmux/frames.h"

#include "cli/cli.h"
#include "fvv_media/frame.h"

namespace fvv::mux {

namespace {

// flatten: how far from the silhouette the picture stays as it is. Matting leaves soft edges, and masks are
// rarely better than a few pixels.
constexpr uint32_t flat_margin = 8;

} // namespace

template <class Sample> media::BasicImage<Sample> load_atlas(const Plan &plan, int64_t frame) {
  const capture::Capture &capture = plan.capture;
  if (capture.atlas->pictures) return plan.videos->read<Sample>(capture, *capture.atlas->pictures, frame, 3);
  const std::string path = capture.atlas_path(frame);
  const std::string bytes = capture::load_embedded_atlas(capture, frame);
  return media::decode_image<Sample>(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), 3, path);
}

template <class Sample>
Picture<Sample> load_picture(const Plan &plan, const VideoTrack &track, size_t i, bool with_mask) {
  const capture::Capture &capture = plan.capture;
  const Tiling &tiling = track.tiling;
  const bool flat_background = plan.options.flat_background;
  const int64_t number = capture.frames.number(int64_t(i));
  std::vector<media::BasicImage<Sample>> images;
  std::vector<media::Image> masks;
  bool masked = false;
  if (track.is_atlas()) {
    images.push_back(load_atlas<Sample>(plan, number));
    masks.emplace_back();
    const fvv_rect &whole = tiling.tiles[0].source;
    if (images[0].width != whole.width || images[0].height != whole.height)
      throw cli::Failure(capture.atlas_path(number) + ": frame " + std::to_string(number) +
                         ": expected an atlas of " + std::to_string(whole.width) + " x " +
                         std::to_string(whole.height) + " as in the first frame, found " +
                         std::to_string(images[0].width) + " x " + std::to_string(images[0].height));
  }
  for (const size_t index : tiling.cameras) {
    const capture::Camera &camera = capture.cameras[index];
    images.push_back(plan.videos->read<Sample>(capture, *camera.pictures, number, 3));
    masks.emplace_back(); // the whole tile
    if (!camera.masks || !(with_mask || flat_background)) continue;
    masked = true;
    masks.back() = plan.videos->read(capture, *camera.masks, number, 1);
    if (flat_background) media::flatten(images.back(), masks.back(), flat_margin);
  }
  try {
    Picture<Sample> picture = {media::compose(tiling.tiles, images, tiling.width, tiling.height), {}};
    if (masked && with_mask)
      picture.mask = media::compose_masks(tiling.tiles, masks, tiling.width, tiling.height);
    return picture;
  } catch (const media::Error &error) {
    throw cli::Failure(capture.path + ": frame " + std::to_string(number) + ": " + error.what());
  }
}

template Picture<uint8_t> load_picture(const Plan &, const VideoTrack &, size_t, bool);
template Picture<uint16_t> load_picture(const Plan &, const VideoTrack &, size_t, bool);

namespace {

template <class Sample>
media::EncodedGroup encode_as(const Plan &plan, const VideoTrack &track, size_t first, size_t count) {
  std::vector<media::BasicImage<Sample>> images;
  for (size_t i = first; i < first + count; i++)
    images.push_back(load_picture<Sample>(plan, track, i, false).image);
  try {
    return media::encode_group(track.choice.settings, images);
  } catch (const media::Error &error) {
    const capture::Frames &frames = plan.capture.frames;
    throw cli::Failure(plan.capture.path + ": frames " + std::to_string(frames.number(int64_t(first))) +
                       " to " + std::to_string(frames.number(int64_t(first + count - 1))) + ": " +
                       error.what());
  }
}

} // namespace

media::EncodedGroup encode_pictures(const Plan &plan, const VideoTrack &track, size_t first, size_t count) {
  return plan.options.bit_depth > 8 ? encode_as<uint16_t>(plan, track, first, count)
                                    : encode_as<uint8_t>(plan, track, first, count);
}

} // namespace fvv::mux
