#include "mux/src/pictures.h"
#include "fvv_cxx/error.h"
#include "fvv_media/exr.h"
#include "fvv_media/frame.h"
#include "mux/src/sample_frames.h"

#include <type_traits>

namespace fvv::mux {

Background background_of(const Options &options) {
  if (options.background != Background::automatic) return options.background;
  // Measured (docs/fvvmux-tiles.md): AV1 alone takes fewer bytes for slopes than for the rim of what is flat.
  return options.codec == FVV_CODEC_AV01 ? Background::smooth : Background::flat;
}

namespace {

// Here the file can be named; in the video frame it no longer can.
template <class Sample> void check_range(const media::BasicImage<Sample> &image, const std::string &path) {
  if constexpr (std::is_same_v<Sample, float>) media::check_halves(image, path);
}

} // namespace

template <class Sample> media::BasicImage<Sample> load_atlas(const Plan &plan, int64_t frame) {
  const scene::Capture &capture = plan.capture;
  if (capture.atlas->pictures) return plan.videos->read<Sample>(capture, *capture.atlas->pictures, frame, 3);
  const std::string path = capture.atlas_path(frame);
  const std::string bytes = scene::load_embedded_atlas(capture, frame);
  return media::decode_image<Sample>(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), 3, path);
}

template <class Sample>
media::BasicImage<Sample> load_view(const Plan &plan, size_t camera, const scene::PictureSource &source,
                                    int64_t frame, int channels) {
  media::BasicImage<Sample> picture = plan.videos->read<Sample>(plan.capture, source, frame, channels);
  check_range(picture, plan.capture.resolve(source.file(frame)));
  return plan.undistortion ? plan.undistortion->apply(camera, frame, std::move(picture)) : picture;
}

template media::Image load_view(const Plan &, size_t, const scene::PictureSource &, int64_t, int);

template <class Sample>
Picture<Sample> load_picture(const Plan &plan, const VideoTrack &track, size_t i, bool with_mask) {
  const scene::Capture &capture = plan.capture;
  const Tiling &tiling = track.tiling;
  const Background background = background_of(plan.options);
  const int64_t number = capture.frames.number(int64_t(i));
  std::vector<fvv_tile> tiles = track.tiles_of(i / plan.group_size);
  std::vector<media::BasicImage<Sample>> images;
  std::vector<media::Image> masks, kept; // of tiles; empty ones count whole
  bool masked = false;
  if (track.is_atlas()) {
    images.push_back(load_atlas<Sample>(plan, number));
    check_range(images.back(), capture.atlas_path(number));
    masks.emplace_back();
    const fvv_rect &whole = tiling.tiles[0].source;
    if (images[0].width != whole.width || images[0].height != whole.height)
      throw Error(capture.atlas_path(number) + ": frame " + std::to_string(number) +
                  ": expected an atlas of " + std::to_string(whole.width) + " x " +
                  std::to_string(whole.height) + " as in the first frame, found " +
                  std::to_string(images[0].width) + " x " + std::to_string(images[0].height));
  }
  const auto failure = [&](const std::string &what) {
    return Error(capture.path + ": frame " + std::to_string(number) + ": " + what);
  };
  for (size_t k = 0; k < tiling.cameras.size(); k++) {
    const size_t index = tiling.cameras[k];
    const scene::Camera &camera = capture.cameras[index];
    const fvv_rect from = tiles[k].source;
    const auto part = [&](const auto &image) {
      try {
        return media::crop(image, from.x, from.y, from.width, from.height);
      } catch (const Error &error) {
        throw failure("camera " + std::to_string(tiles[k].camera_id) + ": " + error.what());
      }
    };
    images.push_back(part(load_view<Sample>(plan, index, *camera.pictures, number, 3)));
    masks.emplace_back();
    kept.emplace_back();
    tiles[k].source.x = tiles[k].source.y = 0;
    if (!camera.masks || !(with_mask || background != Background::keep)) continue;
    masked = true;
    masks.back() = part(load_view<uint8_t>(plan, index, *camera.masks, number, 1));
    if (background == Background::flat) media::flatten(images.back(), masks.back(), background_margin);
    if (background == Background::smooth) kept.back() = media::widened(masks.back(), background_margin);
  }
  try {
    Picture<Sample> picture = {media::compose(tiles, images, tiling.width, tiling.height), {}};
    if (masked && background == Background::smooth)
      media::fill_smoothly(picture.image, media::compose_masks(tiles, kept, tiling.width, tiling.height));
    if (masked && with_mask) picture.mask = media::compose_masks(tiles, masks, tiling.width, tiling.height);
    return picture;
  } catch (const Error &error) {
    throw failure(error.what());
  }
}

template Picture<uint8_t> load_picture(const Plan &, const VideoTrack &, size_t, bool);
template Picture<uint16_t> load_picture(const Plan &, const VideoTrack &, size_t, bool);
template Picture<float> load_picture(const Plan &, const VideoTrack &, size_t, bool);

namespace {

template <class Sample>
media::EncodedGroup encode_as(const Plan &plan, const VideoTrack &track, size_t first, size_t count) {
  if (std::optional<media::EncodedGroup> known = track.choice.frames->take_encoded(first, count))
    return *known;
  std::vector<media::BasicImage<Sample>> images;
  for (size_t i = first; i < first + count; i++) {
    std::optional<media::BasicImage<Sample>> kept = track.choice.frames->take<Sample>(i);
    images.push_back(kept ? std::move(*kept) : load_picture<Sample>(plan, track, i, false).image);
  }
  try {
    return media::encode_group(track.choice.settings, images);
  } catch (const Error &error) {
    const scene::Frames &frames = plan.capture.frames;
    throw Error(plan.capture.path + ": frames " + std::to_string(frames.number(int64_t(first))) + " to " +
                std::to_string(frames.number(int64_t(first + count - 1))) + ": " + error.what());
  }
}

} // namespace

media::EncodedGroup encode_pictures(const Plan &plan, const VideoTrack &track, size_t first, size_t count) {
  return media::with_sample_type(plan.options.codec, plan.options.bit_depth, [&](auto sample) {
    return encode_as<decltype(sample)>(plan, track, first, count);
  });
}

} // namespace fvv::mux
