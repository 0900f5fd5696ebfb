// Tiles into a frame and out of it, and what is drawn in place of the background (pull and push).
#include "fvv_media/frame.h"

#include "codecs.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace fvv::media {

namespace {

uint32_t aligned(uint32_t value) {
  return (value + FVV_TILE_ALIGNMENT - 1) / FVV_TILE_ALIGNMENT * FVV_TILE_ALIGNMENT;
}

void check_tiles(const std::vector<fvv_tile> &tiles, size_t images, uint32_t width, uint32_t height) {
  if (tiles.size() != images)
    throw Error(std::to_string(tiles.size()) + " tiles came with " + std::to_string(images) + " pictures");
  check_dimensions(width, height, "a video frame");
  for (const fvv_tile &tile : tiles) {
    const fvv_rect &to = tile.destination;
    if (to.width == 0 || to.height == 0 || uint32_t(to.x) + to.width > width ||
        uint32_t(to.y) + to.height > height)
      throw Error("the tile of camera " + std::to_string(tile.camera_id) + " is not inside the frame of " +
                  std::to_string(width) + " x " + std::to_string(height));
  }
}

// Copies picture to (x, y).
template <class Sample>
void place(BasicImage<Sample> &frame, const BasicImage<Sample> &picture, uint32_t x, uint32_t y) {
  const size_t channels = size_t(frame.channels), length = picture.width * channels;
  for (uint32_t row = 0; row < picture.height; row++)
    memcpy(&frame.pixels[((size_t(y) + row) * frame.width + x) * channels], &picture.pixels[row * length],
           length * sizeof(Sample));
}

// Repeats the edges of tiles where there is no tile, from the nearest tile.
template <class Sample> class Guard {
public:
  Guard(BasicImage<Sample> &composed, const std::vector<fvv_tile> &all)
      : frame(composed), tiles(all), taken(size_t(frame.width) * frame.height) {
    for (const fvv_tile &tile : tiles)
      for (uint32_t y = 0; y < tile.destination.height; y++)
        std::fill_n(&taken[size_t(tile.destination.y + y) * frame.width + tile.destination.x],
                    tile.destination.width, uint8_t(1));
  }
  void draw() {
    for (int64_t d = 1; d <= int64_t(guard_band); d++)
      for (const fvv_tile &tile : tiles) ring(tile.destination, d);
    for (const fvv_tile &tile : tiles) {
      const fvv_rect &to = tile.destination;
      for (int64_t y = to.y; y < aligned(to.y + to.height); y++)
        for (int64_t x = y < to.y + to.height ? to.x + to.width : to.x; x < aligned(to.x + to.width); x++)
          repeat(to, x, y);
    }
  }

private:
  void ring(const fvv_rect &to, int64_t d) {
    const int64_t left = to.x - d, right = to.x + to.width - 1 + d, top = to.y - d,
                  bottom = to.y + to.height - 1 + d;
    for (int64_t x = left; x <= right; x++)
      for (const int64_t y : {top, bottom}) repeat(to, x, y);
    for (int64_t y = top + 1; y < bottom; y++)
      for (const int64_t x : {left, right}) repeat(to, x, y);
  }
  void repeat(const fvv_rect &to, int64_t x, int64_t y) {
    if (x < 0 || y < 0 || x >= frame.width || y >= frame.height || taken[size_t(y) * frame.width + size_t(x)])
      return;
    taken[size_t(y) * frame.width + size_t(x)] = 1;
    const int64_t from_x = std::clamp<int64_t>(x, to.x, to.x + to.width - 1),
                  from_y = std::clamp<int64_t>(y, to.y, to.y + to.height - 1);
    const size_t channels = size_t(frame.channels);
    std::copy_n(&frame.pixels[(size_t(from_y) * frame.width + size_t(from_x)) * channels], channels,
                &frame.pixels[(size_t(y) * frame.width + size_t(x)) * channels]);
  }

  BasicImage<Sample> &frame;
  const std::vector<fvv_tile> &tiles;
  std::vector<uint8_t> taken; // pixels
};

template <class Sample>
BasicImage<Sample> picture_of_tile(const fvv_tile &tile, const BasicImage<Sample> &image, Filter filter) {
  const fvv_rect &from = tile.source;
  try {
    return scale(crop(image, from.x, from.y, from.width, from.height), tile.destination.width,
                 tile.destination.height, filter);
  } catch (const Error &error) {
    throw Error("camera " + std::to_string(tile.camera_id), error.what());
  }
}

// For each position of a line: whether a set one is at most margin away. Sets bits in place.
void widen(uint8_t *line, size_t count, size_t step, uint32_t margin) {
  size_t distance = size_t(margin) + 1;
  std::vector<uint8_t> near(count);
  for (size_t i = 0; i < count; i++) {
    distance = line[i * step] ? 0 : distance + 1;
    near[i] = distance <= margin;
  }
  distance = size_t(margin) + 1;
  for (size_t i = count; i-- > 0;) {
    distance = line[i * step] ? 0 : distance + 1;
    line[i * step] = near[i] || distance <= margin;
  }
}

} // namespace

template <class Sample>
BasicImage<Sample> compose(const std::vector<fvv_tile> &tiles, const std::vector<BasicImage<Sample>> &images,
                           uint32_t width, uint32_t height) {
  check_tiles(tiles, images.size(), width, height);
  if (images.empty()) throw Error("a video frame needs at least one tile");
  BasicImage<Sample> frame = make_image<Sample>(width, height, images[0].channels, flat_grey_of<Sample>);
  // The negative lobes of Lanczos' filter would draw dark rings around lights that are far above white.
  const Filter filter = std::is_same_v<Sample, float> ? Filter::area : Filter::lanczos;
  for (size_t i = 0; i < tiles.size(); i++) {
    if (images[i].channels != frame.channels)
      throw Error("camera " + std::to_string(tiles[i].camera_id),
                  "its picture has " + std::to_string(images[i].channels) + " channels, the first one has " +
                      std::to_string(frame.channels));
    place(frame, picture_of_tile(tiles[i], images[i], filter), tiles[i].destination.x,
          tiles[i].destination.y);
  }
  Guard<Sample>(frame, tiles).draw();
  return frame;
}

Image compose_masks(const std::vector<fvv_tile> &tiles, const std::vector<Image> &masks, uint32_t width,
                    uint32_t height) {
  check_tiles(tiles, masks.size(), width, height);
  Image frame = make_image(width, height, 1, 0);
  for (size_t i = 0; i < tiles.size(); i++) {
    const fvv_rect &to = tiles[i].destination;
    const bool whole = masks[i].pixels.empty();
    if (!whole && masks[i].channels != 1)
      throw Error("camera " + std::to_string(tiles[i].camera_id), "its mask is not grey");
    place(frame,
          whole ? make_image(to.width, to.height, 1, 255) : picture_of_tile(tiles[i], masks[i], Filter::area),
          to.x, to.y);
  }
  return frame;
}

template <class Sample> BasicImage<Sample> extract(const BasicImage<Sample> &frame, const fvv_tile &tile) {
  const fvv_rect &to = tile.destination;
  return crop(frame, to.x, to.y, to.width, to.height);
}

Image widened(const Image &mask, uint32_t margin) {
  check_image(mask);
  if (mask.channels != 1) throw Error("a mask must be grey");
  // A square dilation is one along rows and then one along columns.
  const size_t width = mask.width, height = mask.height;
  Image out = mask;
  for (uint8_t &value : out.pixels) value = value > 127 ? 255 : 0;
  for (size_t y = 0; y < height; y++) widen(&out.pixels[y * width], width, 1, margin);
  for (size_t x = 0; x < width; x++) widen(&out.pixels[x], height, width, margin);
  for (uint8_t &value : out.pixels) value = value ? 255 : 0;
  return out;
}

template <class Sample> void flatten(BasicImage<Sample> &image, const Image &mask, uint32_t margin) {
  check_image(image);
  const Image keep = widened(mask, margin);
  if (mask.width != image.width || mask.height != image.height)
    throw Error("a mask must be grey and of the size of the picture");
  const size_t channels = size_t(image.channels);
  for (size_t i = 0; i < keep.pixels.size(); i++)
    if (!keep.pixels[i]) std::fill_n(&image.pixels[i * channels], channels, flat_grey_of<Sample>);
}

template Image compose(const std::vector<fvv_tile> &, const std::vector<Image> &, uint32_t, uint32_t);
template DeepImage compose(const std::vector<fvv_tile> &, const std::vector<DeepImage> &, uint32_t, uint32_t);
template LinearImage compose(const std::vector<fvv_tile> &, const std::vector<LinearImage> &, uint32_t,
                             uint32_t);
template Image extract(const Image &, const fvv_tile &);
template DeepImage extract(const DeepImage &, const fvv_tile &);
template LinearImage extract(const LinearImage &, const fvv_tile &);
template void flatten(Image &, const Image &, uint32_t);
template void flatten(DeepImage &, const Image &, uint32_t);
template void flatten(LinearImage &, const Image &, uint32_t);

namespace {

// Integers have a few fractional bits, so that rounding does not accumulate over levels.
template <class Sample> struct Arithmetic {
  using Value = int32_t;
  static Value of(Sample sample) { return Value(sample) * 64; }
  static Value divided(Value value, int32_t by) { return (value + by / 2) / by; }
  static Sample sample(Value value) { return Sample(divided(value, 64)); }
};
template <> struct Arithmetic<float> {
  using Value = float;
  static Value of(float sample) { return sample; }
  static Value divided(Value value, int32_t by) { return value / float(by); }
  static float sample(Value value) { return value; }
};

template <class Sample> struct Level {
  size_t width, height;
  std::vector<typename Arithmetic<Sample>::Value> values; // channels interleaved
  std::vector<uint8_t> known;
};

template <class Sample> Level<Sample> halved(const Level<Sample> &fine, size_t channels) {
  Level<Sample> out = {(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  out.values.resize(out.width * out.height * channels);
  out.known.resize(out.width * out.height);
  for (size_t y = 0; y < out.height; y++)
    for (size_t x = 0; x < out.width; x++) {
      int32_t count = 0;
      auto *to = &out.values[(y * out.width + x) * channels];
      for (size_t row = 2 * y; row < std::min(2 * y + 2, fine.height); row++)
        for (size_t column = 2 * x; column < std::min(2 * x + 2, fine.width); column++) {
          const size_t i = row * fine.width + column;
          if (!fine.known[i]) continue;
          count++;
          for (size_t c = 0; c < channels; c++) to[c] += fine.values[i * channels + c];
        }
      if (!count) continue;
      out.known[y * out.width + x] = 1;
      for (size_t c = 0; c < channels; c++) to[c] = Arithmetic<Sample>::divided(to[c], count);
    }
  return out;
}

// Pixel centres of the fine level lie a quarter from those of the coarse one: weights 3 and 1 on each axis.
template <class Sample> void interpolate(Level<Sample> &fine, const Level<Sample> &coarse, size_t channels) {
  for (size_t y = 0; y < fine.height; y++) {
    const size_t near_y = y / 2,
                 far_y = y % 2 ? std::min(near_y + 1, coarse.height - 1) : near_y - (near_y > 0);
    for (size_t x = 0; x < fine.width; x++) {
      if (fine.known[y * fine.width + x]) continue;
      const size_t near_x = x / 2,
                   far_x = x % 2 ? std::min(near_x + 1, coarse.width - 1) : near_x - (near_x > 0);
      const auto at = [&](size_t row, size_t column, size_t c) {
        return coarse.values[(row * coarse.width + column) * channels + c];
      };
      for (size_t c = 0; c < channels; c++)
        fine.values[(y * fine.width + x) * channels + c] =
            Arithmetic<Sample>::divided(9 * at(near_y, near_x, c) + 3 * at(near_y, far_x, c) +
                                            3 * at(far_y, near_x, c) + at(far_y, far_x, c),
                                        16);
    }
  }
}

void check_mask(const Image &mask, uint32_t width, uint32_t height) {
  check_image(mask);
  if (mask.channels != 1 || mask.width != width || mask.height != height)
    throw Error("a mask must be grey and of the size of the picture");
}

// fill_smoothly of the pixels whose wanted is not 0.
template <class Sample>
void fill_wanted(BasicImage<Sample> &image, const Image &keep, const std::vector<uint8_t> &wanted) {
  const size_t channels = size_t(image.channels);
  std::vector<Level<Sample>> levels = {{image.width, image.height, {}, {}}};
  levels[0].values.resize(image.pixels.size());
  levels[0].known.resize(keep.pixels.size());
  bool any = false;
  for (size_t i = 0; i < keep.pixels.size(); i++) {
    if (keep.pixels[i] <= 127) continue;
    levels[0].known[i] = 1;
    any = true;
    for (size_t c = 0; c < channels; c++)
      levels[0].values[i * channels + c] = Arithmetic<Sample>::of(image.pixels[i * channels + c]);
  }
  if (!any) {
    std::fill(image.pixels.begin(), image.pixels.end(), flat_grey_of<Sample>);
    return;
  }
  while (levels.back().width > 1 || levels.back().height > 1)
    levels.push_back(halved(levels.back(), channels));
  for (size_t i = 0; i < wanted.size(); i++)
    if (!wanted[i]) levels[0].known[i] = 1;
  for (size_t i = levels.size() - 1; i-- > 0;) interpolate(levels[i], levels[i + 1], channels);
  for (size_t i = 0; i < keep.pixels.size(); i++)
    if (!levels[0].known[i])
      for (size_t c = 0; c < channels; c++)
        image.pixels[i * channels + c] = Arithmetic<Sample>::sample(levels[0].values[i * channels + c]);
}

} // namespace

template <class Sample> void fill_smoothly(BasicImage<Sample> &image, const Image &keep) {
  check_image(image);
  check_mask(keep, image.width, image.height);
  fill_wanted(image, keep, {});
}

template <class Sample> void extend(BasicImage<Sample> &image, const Image &mask, uint32_t margin) {
  check_image(image);
  check_mask(mask, image.width, image.height);
  fill_wanted(image, mask, widened(mask, margin).pixels);
}

template void fill_smoothly(Image &, const Image &);
template void fill_smoothly(DeepImage &, const Image &);
template void fill_smoothly(LinearImage &, const Image &);
template void extend(Image &, const Image &, uint32_t);
template void extend(DeepImage &, const Image &, uint32_t);
template void extend(LinearImage &, const Image &, uint32_t);

} // namespace fvv::media
