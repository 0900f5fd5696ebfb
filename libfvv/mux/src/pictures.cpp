#include "mux/src/pictures.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/parallel.h"
#include "fvv_media/colour.h"
#include "fvv_media/exr.h"
#include "fvv_media/frame.h"
#include "fvv_media/packed_image.h"
#include "fvv_scene/memory_frames.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/options/effort_steps.h"
#include "mux/src/options/presets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

namespace fvv::mux {

TileFill tile_fill_of(const Options &options) {
  if (options.tile_fill != TileFill::automatic) return options.tile_fill;
  // Measured (docs/encoding/tiles.md): only AV1 takes fewer bytes for slopes than for the rim of a flat area.
  return options.codec == FVV_CODEC_AV01 ? TileFill::smooth : TileFill::flat;
}

namespace {

// The file is known here, but not in the video frame.
template <class Sample> void check_range(const media::BasicImage<Sample> &image, const std::string &path) {
  if constexpr (std::is_same_v<Sample, float>) media::check_halves(image, path);
}

} // namespace

template <class Sample> media::BasicImage<Sample> load_atlas(const Plan &plan, int64_t frame) {
  const scene::Capture &capture = plan.capture;
  return about_frame(capture, frame, [&] {
    if (capture.atlas->pictures)
      return plan.videos->read<Sample>(capture, *capture.atlas->pictures, frame, 3);
    const scene::MeshPicture picture = scene::load_embedded_atlas(capture, frame);
    const auto *bytes = reinterpret_cast<const uint8_t *>(picture.bytes.data());
    media::check_image_memory(bytes, picture.bytes.size(), picture.name, capture.memory_limit);
    return media::decode_image<Sample>(bytes, picture.bytes.size(), 3, picture.name);
  });
}

template media::Image load_atlas(const Plan &, int64_t);
template media::DeepImage load_atlas(const Plan &, int64_t);
template media::LinearImage load_atlas(const Plan &, int64_t);

// For each camera and channel the display value that takes the place of each other one.
class GainTables {
public:
  explicit GainTables(size_t cameras) : of(cameras) {}

  void set(size_t camera, const double *gains) {
    for (size_t k = 0; k < 3; k++) {
      fill(of[camera].shallow[k], 255, gains[k]);
      fill(of[camera].deep[k], 65535, gains[k]);
    }
  }

  template <class Sample> void apply(size_t camera, media::BasicImage<Sample> &picture) const {
    if (of[camera].shallow[0].empty()) return;
    const auto &tables = [&]() -> const auto & {
      if constexpr (sizeof(Sample) == 1)
        return of[camera].shallow;
      else
        return of[camera].deep;
    }
    ();
    for (size_t i = 0; i < picture.pixels.size(); i++)
      picture.pixels[i] = Sample(tables[i % 3][size_t(picture.pixels[i])]);
  }

private:
  struct Tables {
    std::vector<uint8_t> shallow[3];
    std::vector<uint16_t> deep[3];
  };

  // Light beyond white is clipped.
  template <class Value> static void fill(std::vector<Value> &table, uint32_t largest, double gain) {
    const std::vector<float> linear = media::linear_of_codes(largest),
                             thresholds = media::srgb_thresholds(largest);
    table.clear();
    size_t code = 0; // thresholds at or below the light
    for (const float light : linear) {
      while (code < largest && double(thresholds[code]) <= double(light) * gain) code++;
      table.push_back(Value(code));
    }
  }

  std::vector<Tables> of;
};

std::shared_ptr<const GainTables> gain_tables(const MatchChoice &choice, size_t cameras) {
  auto tables = std::make_shared<GainTables>(cameras);
  for (size_t i = 0; i < choice.cameras.size(); i++)
    tables->set(choice.cameras[i], choice.found.cameras[i].gain);
  return tables;
}

template <class Sample>
media::BasicImage<Sample> load_view(const Plan &plan, size_t camera, const scene::PictureSource &source,
                                    int64_t frame, int channels) {
  media::BasicImage<Sample> picture = about_frame(
      plan.capture, frame, [&] { return plan.videos->read<Sample>(plan.capture, source, frame, channels); });
  check_range(picture, plan.capture.resolve(source.file(frame)));
  if (plan.undistortion) picture = plan.undistortion->apply(camera, frame, std::move(picture));
  if constexpr (!std::is_same_v<Sample, float>)
    if (plan.match.tables && channels == 3) plan.match.tables->apply(camera, picture);
  return picture;
}

template media::Image load_view(const Plan &, size_t, const scene::PictureSource &, int64_t, int);

namespace {

uint8_t to_display(uint8_t value) {
  return value;
}
uint8_t to_display(uint16_t value) {
  return uint8_t((value + 128) / 257);
}
uint8_t to_display(float linear) {
  return uint8_t(std::lround(255 * std::clamp(media::srgb_of_linear(double(linear)), 0.0, 1.0)));
}

} // namespace

void apply_gains(const Plan &plan, size_t camera, media::Image &picture) {
  if (plan.match.tables) plan.match.tables->apply(camera, picture);
}

media::Image load_display(const Plan &plan, size_t camera, int64_t frame) {
  const scene::PictureSource &source = *plan.capture.cameras[camera].pictures;
  if (!plan.capture.memory) return load_view<uint8_t>(plan, camera, source, frame, 3);
  return media::with_sample_type(plan.options.codec, plan.options.bit_depth, [&](auto sample) {
    const auto view = load_view<decltype(sample)>(plan, camera, source, frame, 3);
    media::Image out = {view.width, view.height, view.channels, {}};
    out.pixels.reserve(view.pixels.size());
    for (const auto value : view.pixels) out.pixels.push_back(to_display(value));
    return out;
  });
}

template <class Sample>
Picture<Sample> load_picture(const Plan &plan, const VideoTrack &track, size_t i, bool with_mask) {
  const scene::Capture &capture = plan.capture;
  const Tiling &tiling = track.tiling;
  const TileFill fill = tile_fill_of(plan.options);
  const int64_t number = capture.frames.number(int64_t(i));
  std::vector<fvv_tile> tiles = track.tiles_of(plan.group_of(i));
  std::vector<media::BasicImage<Sample>> images;
  std::vector<media::Image> masks; // of tiles; empty ones count whole
  bool masked = false;
  if (track.is_atlas()) {
    images.push_back(load_atlas<Sample>(plan, number));
    check_range(images.back(), capture.atlas_path(number));
    masks.emplace_back();
    const fvv_rect &whole = tiling.tiles[0].source;
    const bool is_unlike = images[0].width != whole.width || images[0].height != whole.height;
    if (is_unlike && !capture.atlas->pictures)
      // Texture coordinates are fractions of it.
      images[0] = media::scale(images[0], whole.width, whole.height);
    else if (is_unlike)
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
        throw failure("camera " + std::to_string(tiles[k].camera_id) + ": " + error.line());
      }
    };
    images.push_back(part(load_view<Sample>(plan, index, *camera.pictures, number, 3)));
    masks.emplace_back();
    tiles[k].source.x = tiles[k].source.y = 0;
    if (!camera.masks || !(with_mask || fill != TileFill::keep)) continue;
    masked = true;
    masks.back() = part(load_view<uint8_t>(plan, index, *camera.masks, number, 1));
    if (fill != TileFill::keep) media::extend(images.back(), masks.back(), tile_fill_margin);
    if (fill == TileFill::flat) media::flatten(images.back(), masks.back(), tile_fill_margin);
  }
  try {
    Picture<Sample> picture = {media::compose(tiles, images, tiling.width, tiling.height), {}};
    if (masked && fill == TileFill::smooth)
      media::fill_smoothly(picture.image, media::compose_masks(tiles, masks, tiling.width, tiling.height));
    if (masked && with_mask) picture.mask = media::compose_masks(tiles, masks, tiling.width, tiling.height);
    return picture;
  } catch (const Error &error) {
    throw failure(error.line());
  }
}

template Picture<uint8_t> load_picture(const Plan &, const VideoTrack &, size_t, bool);
template Picture<uint16_t> load_picture(const Plan &, const VideoTrack &, size_t, bool);
template Picture<float> load_picture(const Plan &, const VideoTrack &, size_t, bool);

// Results of the choice of a quality, kept for encoding: composed video frames or, if the sample is a group
// of the stream, that group.
class SampleFrames {
public:
  template <class Sample> void keep(size_t frame, media::PackedImage<Sample> image) {
    const std::lock_guard<std::mutex> lock(mutex);
    images.insert_or_assign(frame, std::move(image));
  }

  // Removes what it returns; none if the frame is not there.
  template <class Sample> std::optional<media::PackedImage<Sample>> take(size_t frame) {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto node = images.extract(frame);
    if (node.empty()) return std::nullopt;
    return std::get<media::PackedImage<Sample>>(std::move(node.mapped()));
  }

  // Frames first ... first + group.samples.size() - 1, with the settings of the choice.
  void keep_encoded(size_t first, media::EncodedGroup group) {
    const std::lock_guard<std::mutex> lock(mutex);
    encoded_first = first;
    encoded = std::move(group);
  }

  // The result of encoding frames first ... first + count - 1 together; removes what it returns.
  std::optional<media::EncodedGroup> take_encoded(size_t first, size_t count) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!encoded || encoded_first != first || encoded->samples.size() != count) return std::nullopt;
    return std::exchange(encoded, std::nullopt);
  }

private:
  std::mutex mutex;
  size_t encoded_first = 0;
  std::optional<media::EncodedGroup> encoded;
  std::map<size_t,
           std::variant<media::PackedImage<uint8_t>, media::PackedImage<uint16_t>, media::PackedImage<float>>>
      images;
};

std::shared_ptr<void> EncoderRoom::reserve(uint64_t bytes) {
  std::unique_lock<std::mutex> lock(mutex);
  while (used && used + bytes > threads * bytes_per_thread)
    if (!load_any(lock)) changed.wait(lock);
  used += bytes;
  lock.unlock(); // without memory for what is returned its deleter is called here
  return {this, [bytes](EncoderRoom *room) {
            const std::lock_guard<std::mutex> held(room->mutex);
            room->used -= bytes;
            room->changed.notify_all();
          }};
}

void EncoderRoom::help() {
  std::unique_lock<std::mutex> lock(mutex);
  while (!groups.empty())
    if (!load_any(lock)) changed.wait(lock);
}

void EncoderRoom::load_next(Group &group, std::unique_lock<std::mutex> &lock) {
  Group::Frame &frame = group.frames[group.begun];
  const size_t number = group.begun++;
  kept += group.most_bytes;
  group.loading++;
  lock.unlock();
  const uint64_t bytes = group.load(number);
  lock.lock();
  group.loading--;
  frame = {true, bytes};
  kept += bytes;
  kept -= group.most_bytes;
  changed.notify_all();
}

// Groups that wait leave half to those that run.
bool EncoderRoom::load_any(std::unique_lock<std::mutex> &lock) {
  const uint64_t most = threads * ahead_per_thread;
  for (const bool running : {true, false})
    for (Group *group : groups) {
      if (group->running != running || group->begun == group->frames.size()) continue;
      if (kept + group->most_bytes > (running ? most : most / 2)) continue;
      load_next(*group, lock);
      return true;
    }
  return false;
}

EncoderRoom::Group::Group(EncoderRoom &owner, size_t count, uint64_t most,
                          std::function<uint64_t(size_t frame)> loader)
    : room(owner), most_bytes(most), load(std::move(loader)), frames(count) {
  const std::lock_guard<std::mutex> lock(room.mutex);
  room.groups.push_back(this);
}

EncoderRoom::Group::~Group() {
  std::unique_lock<std::mutex> lock(room.mutex);
  room.groups.erase(std::find(room.groups.begin(), room.groups.end(), this));
  room.changed.wait(lock, [this] { return !loading; });
  for (const Frame &frame : frames) room.kept -= frame.bytes;
  room.changed.notify_all();
}

void EncoderRoom::Group::await(size_t frame) {
  std::unique_lock<std::mutex> lock(room.mutex);
  running = true;
  while (!frames[frame].loaded)
    if (begun <= frame)
      room.load_next(*this, lock);
    else if (!room.load_any(lock))
      room.changed.wait(lock);
  room.kept -= std::exchange(frames[frame].bytes, 0);
  room.changed.notify_all();
}

namespace {

// Groups by which others may be judged: not much shorter, and with a mesh.
std::vector<bool> typical_groups(const Plan &plan) {
  size_t longest = 0;
  for (size_t group = 0; group < plan.group_count(); group++)
    longest = std::max(longest, plan.frames_of(group));
  std::vector<bool> out;
  for (size_t group = 0; group < plan.group_count(); group++)
    out.push_back(2 * plan.frames_of(group) >= longest &&
                  (!plan.has_meshes() || plan.has_mesh(plan.first_of(group) + plan.frames_of(group) - 1)));
  return out;
}

} // namespace

size_t middle_group(const Plan &plan) {
  const size_t middle = plan.group_count() / 2;
  const std::vector<bool> typical = typical_groups(plan);
  for (size_t off = 0; off <= middle; off++) {
    if (middle + off < plan.group_count() && typical[middle + off]) return middle + off;
    if (typical[middle - off]) return middle - off;
  }
  return middle;
}

namespace {

// The memory limit for the samples of all tracks of the first rung. Further frames are loaded each time they
// are needed.
constexpr size_t sample_bytes = size_t(128) << 20;

// The middle group; where it is short, others over the whole take, too: in two frames there may be less to
// code than in any others.
std::vector<size_t> sampled_groups(const Plan &plan, size_t sample_size) {
  const size_t middle = middle_group(plan), wanted = sample_size / plan.frames_of(middle);
  const std::vector<bool> typical = typical_groups(plan);
  std::vector<size_t> candidates;
  for (size_t group = 0; group < typical.size(); group++)
    if (typical[group]) candidates.push_back(group);
  if (wanted < 2 || candidates.size() < 2) return {middle};
  std::vector<size_t> out;
  const size_t count = std::min(wanted, candidates.size());
  for (size_t k = 0; k < count; k++) out.push_back(candidates[(2 * k + 1) * candidates.size() / (2 * count)]);
  return out;
}

// The part of a track. Lower rungs share as much again: they are chosen after the first.
size_t bytes_kept(const Plan &plan, const VideoTrack &track) {
  const auto together = std::count_if(plan.tracks.begin(), plan.tracks.end(),
                                      [&](const VideoTrack &other) { return !other.rung == !track.rung; });
  return sample_bytes / size_t(together);
}

// The frames by which the quality of a track is chosen or judged.
template <class SampleType> class Sample {
public:
  Sample(const Plan &from, const VideoTrack &of) : plan(from), track(of) {
    // A bit rate applies to all frames of a group. A quality is judged by a whole group, too, because
    // pictures get better in its course, and by one from the middle, when the action is on.
    const size_t most = row_of(plan.options.preset).sample_frames;
    const std::vector<size_t> sampled =
        plan.options.bit_rate ? std::vector<size_t>{0} : sampled_groups(plan, most);
    for (const size_t group : sampled) {
      const size_t in_group =
          plan.options.bit_rate ? plan.frames_of(group) : std::min(plan.frames_of(group), most);
      for (size_t i = 0; i < in_group; i++) frames.push_back(plan.first_of(group) + i);
      groups.push_back(in_group);
    }
    whole_group = sampled.size() == 1 && frames.size() == plan.frames_of(sampled[0]);
    for (size_t done = 0; done < frames.size();) done += load(done);
  }

  // room: borrowed.
  media::GroupSource<SampleType> source(EncoderRoom &room) const {
    media::GroupSource<SampleType> out(
        frames.size(),
        [this](size_t i) {
          Picture<SampleType> picture =
              i < kept.size()
                  ? Picture<SampleType>{kept[i].image.image(), masked ? kept[i].mask.image() : media::Image()}
                  : load_picture<SampleType>(plan, track, frames[i], masked);
          media::GroupFrame<SampleType> frame;
          frame.image = std::make_shared<media::BasicImage<SampleType>>(std::move(picture.image));
          // The masks are empty: the whole picture is judged.
          if (masked) frame.mask = std::make_shared<media::Image>(std::move(picture.mask));
          return frame;
        },
        [&room](uint64_t bytes) { return room.reserve(bytes); });
    out.groups = groups;
    return out;
  }

  void keep_images(SampleFrames &to) const {
    for (size_t i = 0; i < kept.size(); i++) to.keep(frames[i], kept[i].image);
  }

  std::vector<size_t> frames; // of the plan
  bool whole_group;           // they are one of the stream
  bool masked = false;        // only pixels in masks count

private:
  struct Kept {
    media::PackedImage<SampleType> image;
    media::PackedImage<uint8_t> mask;
  };

  // Loads some frames at once, as the first video has to wait for them. Returns how many.
  size_t load(size_t begin) {
    const unsigned threads = std::max(1u, plan.options.threads);
    const uint64_t frame_bytes = 4 * sizeof(SampleType) * uint64_t(track.tiling.width) * track.tiling.height,
                   room = threads * EncoderRoom::ahead_per_thread;
    const size_t together =
        size_t(std::clamp<uint64_t>(room / std::max<uint64_t>(frame_bytes, 1), 1, threads));
    std::vector<Picture<SampleType>> loaded(std::min(together, frames.size() - begin));
    fvv::parallel(unsigned(loaded.size()), loaded.size(), [&](size_t k) {
      loaded[k] = load_picture<SampleType>(plan, track, frames[begin + k], true);
    });
    for (size_t k = 0; k < loaded.size(); k++) {
      const std::vector<uint8_t> &mask = loaded[k].mask.pixels;
      masked = masked || std::any_of(mask.begin(), mask.end(), [](uint8_t m) { return m > 127; });
      if (kept.size() < begin + k) continue;
      Kept frame = {media::PackedImage<SampleType>(loaded[k].image),
                    media::PackedImage<uint8_t>(loaded[k].mask)};
      taken += frame.image.bytes() + frame.mask.bytes();
      if (taken <= bytes_kept(plan, track)) kept.push_back(std::move(frame));
    }
    return loaded.size();
  }

  const Plan &plan;
  const VideoTrack &track;
  std::vector<size_t> groups; // frames of each
  std::vector<Kept> kept;     // the first ones
  size_t taken = 0;           // bytes of those
};

// The least for rungs by size, in dB, unless the first rung has less: below it a picture is hardly more than
// a blur.
constexpr double least_rung_psnr = 27;

} // namespace

double target_psnr_of(const Plan &plan, size_t rung, double first) {
  const double own = plan.options.ladder.empty() ? 0 : plan.options.ladder[rung].psnr;
  return own ? own
             : std::max(first + psnr_of_halving * std::log2(plan.rung_scale(rung)),
                        std::min(first, least_rung_psnr));
}

namespace {

// Of all tracks of a rung.
double rate_of_rung(const Plan &plan, size_t rung) {
  const std::vector<Rung> &ladder = plan.options.ladder;
  if (!ladder.empty() && ladder[rung].bit_rate) return double(ladder[rung].bit_rate);
  return double(plan.options.bit_rate) * std::pow(plan.rung_scale(rung), rate_of_scale);
}

// The part of the bit rate of its rung, in proportion to pixels.
uint64_t share_of_rate(const Plan &plan, const VideoTrack &track) {
  const auto pixels = [](const VideoTrack &one) { return uint64_t(one.tiling.width) * one.tiling.height; };
  uint64_t all = 0;
  for (const VideoTrack &one : plan.tracks)
    if (!one.encoded && one.rung == track.rung) all += pixels(one);
  return uint64_t(rate_of_rung(plan, track.rung) * double(pixels(track)) / double(all));
}

// The start of a search: the middle of the codec's scale.
int middle_quality(uint32_t codec) {
  const media::VideoCodec &known = *media::find_video_codec(codec);
  return (known.finest + known.coarsest) / 2;
}

template <class SampleType>
VideoChoice choose_as(const Plan &plan, const VideoTrack &track, const VideoDecision *best,
                      EncoderRoom &room) {
  const Options &options = plan.options;
  VideoDecision choice;
  choice.settings = {options.codec,
                     track.tiling.width,
                     track.tiling.height,
                     int(options.quality.value),
                     plan.capture.frame_duration,
                     options.bit_depth,
                     share_of_rate(plan, track)};
  choice.settings.parts = options.quality.is_psnr ? 0 : options.quality.value - choice.settings.quality;
  choice.settings.effort = row_of(options.preset).pictures;
  const Sample<SampleType> sample(plan, track);
  choice.masks = sample.masked;
  choice.sample_frames = uint32_t(sample.frames.size());
  media::EncodedGroup encoded;
  try {
    if (options.bit_rate) {
      choice.settings.quality = middle_quality(options.codec);
      choice.settings.parts = 0;
    }
    const double first = options.quality.is_psnr || !best ? options.quality.value : best->sample_psnr;
    const double target = target_psnr_of(plan, track.rung, first);
    if (best && !options.bit_rate) {
      choice.settings.quality = best->settings.quality;
      choice.settings.parts = best->settings.parts;
    }
    // What is lossless stays so at every size.
    const bool search = !options.bit_rate && (best ? std::isfinite(first) : options.quality.is_psnr);
    media::MeasuredGroup measured =
        search ? media::choose_quality(choice.settings, sample.source(room), target,
                                       plan.view.on() || options.preset < Preset::medium)
               : media::encode_measured(choice.settings, sample.source(room));
    if (search) choice.target_psnr = target;
    // A rate is searched again from the nearest whole one.
    choice.settings.quality =
        int(options.bit_rate ? std::lround(measured.group.quality) : std::floor(measured.group.quality));
    choice.settings.parts = options.bit_rate ? 0 : measured.group.quality - choice.settings.quality;
    choice.sample_psnr = measured.psnr;
    choice.record = measured.group.record;
    choice.codec_string = measured.group.codec_string;
    uint64_t bytes = 0;
    for (const media::Sample &one : measured.group.samples) bytes += one.bytes.size();
    const fvv_rational &duration = plan.capture.frame_duration;
    choice.sample_rate =
        8 * double(bytes) / double(sample.frames.size()) * duration.denominator / duration.numerator;
    encoded = std::move(measured.group);
  } catch (const Error &error) {
    throw Error(plan.capture.path + ": " + (track.is_atlas() ? "atlas: " : "") + "sample of " +
                std::to_string(sample.frames.size()) + " frames: " + error.line());
  }
  auto frames = std::make_shared<SampleFrames>();
  // A rate is searched again from the quality found here, with perhaps another result; stills are encoded one
  // by one.
  if (!options.bit_rate && !media::find_video_codec(options.codec)->is_stills() && sample.whole_group)
    frames->keep_encoded(sample.frames[0], std::move(encoded));
  else
    sample.keep_images(*frames);
  return {std::move(choice), std::move(frames)};
}

template <class Sample>
media::EncodedGroup encode_as(const Plan &plan, const VideoTrack &track, const VideoChoice &choice,
                              size_t first, size_t count, EncoderRoom &room) {
  const std::shared_ptr<SampleFrames> known = choice.frames;
  if (known)
    if (std::optional<media::EncodedGroup> encoded = known->take_encoded(first, count)) return *encoded;
  struct Loaded {
    std::optional<media::PackedImage<Sample>> image;
    std::exception_ptr failure; // in its place; it names the frame
  };
  std::vector<Loaded> loaded(count);
  const uint64_t most_bytes = uint64_t(3) * sizeof(Sample) * track.tiling.width * track.tiling.height;
  EncoderRoom::Group group(room, count, most_bytes, [&](size_t i) -> uint64_t {
    try {
      if (known) loaded[i].image = known->template take<Sample>(first + i);
      if (!loaded[i].image)
        loaded[i].image.emplace(load_picture<Sample>(plan, track, first + i, false).image);
      return loaded[i].image->bytes();
    } catch (...) {
      loaded[i].failure = std::current_exception();
      return 0;
    }
  });
  bool failed = false; // to load
  const auto take = [&](size_t i) {
    group.await(i);
    failed = loaded[i].failure != nullptr;
    if (failed) std::rethrow_exception(loaded[i].failure);
    const auto image = std::make_shared<media::BasicImage<Sample>>(loaded[i].image->image());
    loaded[i].image.reset();
    return media::GroupFrame<Sample>{image, nullptr};
  };
  const media::GroupSource<Sample> frames = {count, take,
                                             [&room](uint64_t bytes) { return room.reserve(bytes); }};
  try {
    media::VideoSettings settings = choice.decision.settings;
    lower(settings, effort_step(plan.effort));
    return media::encode_group(settings, frames);
  } catch (const Error &error) {
    if (failed) throw;
    const scene::Frames &numbers = plan.capture.frames;
    throw Error(plan.capture.path + ": frames " + std::to_string(numbers.number(int64_t(first))) + " to " +
                std::to_string(numbers.number(int64_t(first + count - 1))) + ": " + error.line());
  }
}

// By the record; that of stills is empty.
std::string codec_string_of(const EncodedTrack &track) {
  if (media::find_video_codec(track.config.codec)->is_stills()) return "";
  char text[FVV_CODEC_STRING_CAPACITY];
  fvv_diagnostic diagnostic = {};
  fvv::check(
      fvv_video_codec_string(track.config.codec, track.record.data(), track.record.size(), text, &diagnostic),
      "encoded track", diagnostic);
  return text;
}

VideoDecision decision_of(const EncodedTrack &track) {
  VideoDecision out;
  out.settings.codec = track.config.codec;
  out.settings.width = track.config.width;
  out.settings.height = track.config.height;
  out.settings.bit_depth = track.config.bit_depth;
  out.record = track.record;
  out.codec_string = codec_string_of(track);
  return out;
}

} // namespace

VideoChoice choose_video(const Plan &plan, const VideoTrack &track, const VideoDecision *best,
                         EncoderRoom &room) {
  if (track.encoded) return {decision_of(*track.encoded), nullptr};
  return media::with_sample_type(plan.options.codec, plan.options.bit_depth, [&](auto sample) {
    return choose_as<decltype(sample)>(plan, track, best, room);
  });
}

media::EncodedGroup encode_pictures(const Plan &plan, const VideoTrack &track, const VideoChoice &choice,
                                    size_t first, size_t count, EncoderRoom &room) {
  if (track.encoded) {
    media::EncodedGroup group;
    for (size_t i = first; i < first + count; i++)
      group.samples.push_back(
          plan.capture.memory->sample(plan.capture.frames.number(int64_t(i)), track.sample));
    group.record = choice.decision.record;
    return group;
  }
  return media::with_sample_type(plan.options.codec, plan.options.bit_depth, [&](auto sample) {
    return encode_as<decltype(sample)>(plan, track, choice, first, count, room);
  });
}

} // namespace fvv::mux
