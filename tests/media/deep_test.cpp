// Pictures of 16 bits and their conversion to 10-bit YCbCr, against arithmetic in double precision.
#include "fvv_catch.h"
#include "fvv_media/colour.h"
#include "fvv_media/frame.h"
#include "pictures.h"

#include <array>
#include <limits>

using namespace fvv::media;

namespace {

template <class Sample>
BasicImage<Sample> noise(uint32_t width, uint32_t height, int channels, uint32_t seed) {
  BasicImage<Sample> image = make_image<Sample>(width, height, channels, 0);
  for (Sample &sample : image.pixels) sample = Sample(next_random(seed));
  return image;
}

DeepImage widened(const Image &image) {
  DeepImage out = make_image<uint16_t>(image.width, image.height, image.channels, 0);
  for (size_t i = 0; i < image.pixels.size(); i++) out.pixels[i] = uint16_t(257 * image.pixels[i]);
  return out;
}

// What a definition in real numbers gives, and what was found: the nearest integer, and at a tie within the
// error of fixed point either neighbour.
bool is_rounded(double exact, int found, double least, double most) {
  return std::abs(std::min(std::max(exact, least), most) - found) <= 0.5 + 1e-4;
}

// ITU-T H.273 clause 8.3 for a number of bits.
struct Definition {
  double kr, kb, black, luma, chroma, middle, most;

  Definition(const Colour &colour, int bits) {
    kr = colour.matrix == 1 ? 0.2126 : 0.299;
    kb = colour.matrix == 1 ? 0.0722 : 0.114;
    most = std::pow(2, bits) - 1;
    middle = std::pow(2, bits - 1);
    black = colour.full_range ? 0 : 16 * std::pow(2, bits - 8);
    luma = colour.full_range ? most : 219 * std::pow(2, bits - 8);
    chroma = colour.full_range ? most : 224 * std::pow(2, bits - 8);
  }
  // RGB from 0 to 1; Y from 0 to 1, Cb and Cr from -1/2 to 1/2.
  std::array<double, 3> ycc(double r, double g, double b) const {
    const double y = kr * r + (1 - kr - kb) * g + kb * b;
    return {y, (b - y) / (2 - 2 * kb), (r - y) / (2 - 2 * kr)};
  }
  std::array<double, 3> rgb(double y, double cb, double cr) const {
    const double r = y + (2 - 2 * kr) * cr, b = y + (2 - 2 * kb) * cb;
    return {r, (y - kr * r - kb * b) / (1 - kr - kb), b};
  }
};

template <class Sample> size_t wrong_codes(const BasicImage<Sample> &image, const Colour &colour) {
  const BasicFrame<Sample> frame = to_yuv(image, colour);
  const Definition is(colour, BasicFrame<Sample>::bit_depth);
  const double white = std::numeric_limits<Sample>::max();
  const auto ycc = [&](uint32_t x, uint32_t y) {
    const Sample *p = &image.pixels[3 * (size_t(std::min(y, image.height - 1)) * image.width +
                                         std::min(x, image.width - 1))];
    return is.ycc(p[0] / white, p[1] / white, p[2] / white);
  };
  size_t wrong = 0;
  for (uint32_t y = 0; y < image.height; y++)
    for (uint32_t x = 0; x < image.width; x++)
      wrong +=
          !is_rounded(is.black + is.luma * ycc(x, y)[0], frame.y[size_t(y) * image.width + x], 0, is.most);
  const uint32_t chroma_width = (image.width + 1) / 2;
  for (uint32_t y = 0; y < image.height; y += 2)
    for (uint32_t x = 0; x < image.width; x += 2) {
      const size_t at = size_t(y) / 2 * chroma_width + x / 2;
      double cb = 0, cr = 0;
      for (const auto &one : {ycc(x, y), ycc(x + 1, y), ycc(x, y + 1), ycc(x + 1, y + 1)}) {
        cb += one[1] / 4;
        cr += one[2] / 4;
      }
      wrong += !is_rounded(is.middle + is.chroma * cb, frame.u[at], 0, is.most);
      wrong += !is_rounded(is.middle + is.chroma * cr, frame.v[at], 0, is.most);
    }
  return wrong;
}

// Chroma at a pixel: triangles of two samples' width around the samples, the border repeated.
template <class Sample>
double interpolated(const std::vector<Sample> &plane, long width, long height, uint32_t x, uint32_t y) {
  double sum = 0;
  for (long j = 0; j < height + 2; j++)
    for (long i = 0; i < width + 2; i++) {
      const double dx = std::abs((x + 0.5) / 2 - (double(i) - 0.5)),
                   dy = std::abs((y + 0.5) / 2 - (double(j) - 0.5));
      if (dx < 1 && dy < 1)
        sum += (1 - dx) * (1 - dy) *
               plane[size_t(std::clamp(j - 1, 0L, height - 1) * width + std::clamp(i - 1, 0L, width - 1))];
    }
  return sum;
}

template <class Wanted, class Sample>
size_t wrong_samples(const BasicFrame<Sample> &frame, const Colour &colour) {
  const BasicImage<Wanted> image = to_rgb<Wanted>(frame, colour);
  const Definition is(colour, BasicFrame<Sample>::bit_depth);
  const double white = std::numeric_limits<Wanted>::max();
  const long width = (frame.width + 1) / 2, height = (frame.height + 1) / 2;
  size_t wrong = 0;
  for (uint32_t y = 0; y < frame.height; y++)
    for (uint32_t x = 0; x < frame.width; x++) {
      const size_t at = size_t(y) * frame.width + x;
      const auto rgb = is.rgb((frame.y[at] - is.black) / is.luma,
                              (interpolated(frame.u, width, height, x, y) - is.middle) / is.chroma,
                              (interpolated(frame.v, width, height, x, y) - is.middle) / is.chroma);
      for (size_t c = 0; c < 3; c++) wrong += !is_rounded(white * rgb[c], image.pixels[3 * at + c], 0, white);
    }
  return wrong;
}

template <class Sample> BasicFrame<Sample> random_frame(uint32_t width, uint32_t height, uint32_t seed) {
  BasicFrame<Sample> frame;
  frame.width = width;
  frame.height = height;
  frame.y.resize(size_t(width) * height);
  frame.u.resize(size_t(width + 1) / 2 * ((height + 1) / 2));
  frame.v.resize(frame.u.size());
  for (auto *plane : {&frame.y, &frame.u, &frame.v})
    for (Sample &sample : *plane)
      sample = Sample(next_random(seed) & ((1 << BasicFrame<Sample>::bit_depth) - 1));
  return frame;
}

constexpr Colour colours[] = {colour_of_video, {1, 6, 6, false}, {1, 1, 1, true}, colour_of_jpeg};

} // namespace

TEST_CASE("10-bit codes are the definition's, rounded once") {
  for (const Colour &colour : colours)
    for (const auto &[width, height] : {std::pair{64u, 48u}, {33u, 27u}, {1u, 1u}, {2u, 3u}}) {
      CAPTURE(int(colour.matrix), colour.full_range, width, height);
      CHECK(wrong_codes(noise<uint16_t>(width, height, 3, width), colour) == 0);
    }
}

TEST_CASE("RGB of any depth is the definition's, rounded once") {
  for (const Colour &colour : colours)
    for (const auto &[width, height] : {std::pair{64u, 48u}, {33u, 27u}, {1u, 1u}}) {
      CAPTURE(int(colour.matrix), colour.full_range, width, height);
      const DeepFrame deep = random_frame<uint16_t>(width, height, width);
      const Frame flat = random_frame<uint8_t>(width, height, width);
      CHECK(wrong_samples<uint16_t>(deep, colour) == 0);
      CHECK(wrong_samples<uint8_t>(deep, colour) == 0);
      CHECK(wrong_samples<uint16_t>(flat, colour) == 0);
    }
}

TEST_CASE("codes of 10 bits come back from RGB of 16 exactly") {
  // Of one colour each, as interpolation of chroma has no inverse.
  uint32_t seed = 5;
  size_t colours_seen = 0;
  for (const Colour &colour : colours)
    for (int round = 0; round < 4000; round++) {
      DeepFrame frame = random_frame<uint16_t>(2, 2, next_random(seed));
      frame.y.assign(4, frame.y[0]);
      const DeepImage image = to_rgb<uint16_t>(frame, colour);
      if (std::any_of(image.pixels.begin(), image.pixels.end(), [](int s) { return s == 0 || s == 65535; }))
        continue; // not a colour of RGB
      colours_seen++;
      const DeepFrame back = to_yuv(image, colour);
      REQUIRE((back.y == frame.y && back.u == frame.u && back.v == frame.v));
    }
  CHECK(colours_seen > 2000);
}

TEST_CASE("greys of 16 bits have no chroma and rise without a gap") {
  for (const Colour &colour : {colour_of_video, colour_of_jpeg}) {
    DeepImage ramp = make_image<uint16_t>(256, 256, 3, 0);
    for (size_t i = 0; i < 65536; i++) std::fill_n(&ramp.pixels[3 * i], 3, uint16_t(i));
    const DeepFrame frame = to_yuv(ramp, colour);
    CHECK(std::all_of(frame.u.begin(), frame.u.end(), [](int code) { return code == 512; }));
    CHECK(frame.u == frame.v);
    CHECK(frame.y.front() == (colour.full_range ? 0 : 64));
    CHECK(frame.y.back() == (colour.full_range ? 1023 : 940));
    size_t bad = 0;
    for (size_t i = 1; i < 65536; i++) bad += frame.y[i] - frame.y[i - 1] > 1 || frame.y[i] < frame.y[i - 1];
    CHECK(bad == 0);
    const DeepImage back = to_rgb<uint16_t>(frame, colour);
    CHECK((back.pixels.front() == 0 && back.pixels.back() == 65535));
  }
}

TEST_CASE("8-bit codes are what they were before there were others") {
  // FNV-1a of the planes, computed with the version that knew 8 bits alone.
  const auto hash = [](std::initializer_list<std::vector<uint8_t>> planes) {
    uint64_t value = 14695981039346656037u;
    for (const std::vector<uint8_t> &plane : planes)
      for (const uint8_t byte : plane) value = (value ^ byte) * 1099511628211u;
    return value;
  };
  const Image image = noise<uint8_t>(61, 47, 3, 1);
  const Frame video = to_yuv(image, colour_of_video), jpeg = to_yuv(image, colour_of_jpeg);
  CHECK(hash({video.y, video.u, video.v}) == 0xa63b14e955ae0f32);
  CHECK(hash({jpeg.y, jpeg.u, jpeg.v}) == 0x6e543a932041b631);
  CHECK(hash({to_rgb(video, colour_of_video).pixels}) == 0xb93e595ed3829203);
  CHECK(hash({to_rgb(jpeg, colour_of_jpeg).pixels}) == 0xdc30a65e06836cbf);
  CHECK(hash({scale(image, 23, 40).pixels}) == 0xf40e791d842b4b17);
}

TEST_CASE("scaling 16 bits is the mean of the area, rounded") {
  for (const int channels : {1, 3})
    for (const auto &[width, height] : {std::pair{20u, 12u}, {37u, 5u}, {61u, 47u}, {80u, 50u}}) {
      const DeepImage image = noise<uint16_t>(61, 47, channels, width);
      const DeepImage out = scale(image, width, height);
      size_t wrong = 0;
      for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
          for (int c = 0; c < channels; c++) {
            const double left = x * 61.0 / width, right = (x + 1) * 61.0 / width;
            const double top = y * 47.0 / height, bottom = (y + 1) * 47.0 / height;
            double sum = 0;
            for (uint32_t j = 0; j < 47; j++)
              for (uint32_t i = 0; i < 61; i++)
                sum += std::max(0.0, std::min(right, i + 1.0) - std::max(left, double(i))) *
                       std::max(0.0, std::min(bottom, j + 1.0) - std::max(top, double(j))) *
                       image.pixels[(j * 61 + i) * size_t(channels) + size_t(c)];
            wrong += !is_rounded(sum / ((right - left) * (bottom - top)),
                                 out.pixels[(y * width + x) * size_t(channels) + size_t(c)], 0, 65535);
          }
      CHECK(wrong == 0);
    }
  const DeepImage white = make_image<uint16_t>(300, 200, 3, 65535);
  CHECK(scale(white, 7, 11).pixels == make_image<uint16_t>(7, 11, 3, 65535).pixels);
}

TEST_CASE("widened pictures are tiled, flattened and compared as those of 8 bits are") {
  const Image a = noise<uint8_t>(50, 40, 3, 1), b = noise<uint8_t>(50, 40, 3, 2);
  Image mask = make_image(50, 40, 1, 0);
  for (size_t i = 0; i < 300; i++) mask.pixels[700 + i] = 255;
  const std::vector<fvv_tile> tiles = {{1, {3, 4, 30, 20}, {0, 0, 30, 20}},
                                       {2, {0, 0, 50, 40}, {32, 16, 50, 40}}};
  const DeepImage frame = compose<uint16_t>(tiles, {widened(a), widened(b)}, 96, 64);
  CHECK(frame.pixels == widened(compose(tiles, {a, b}, 96, 64)).pixels);
  CHECK(frame.pixels[3 * 90] == 257 * flat_grey); // beside both
  CHECK(extract(frame, tiles[0]).pixels == crop(widened(a), 3, 4, 30, 20).pixels);
  Image flat = a;
  DeepImage deep_flat = widened(a);
  flatten(flat, mask, 3);
  flatten(deep_flat, mask, 3);
  CHECK(deep_flat.pixels == widened(flat).pixels);
  for (const Image *only : {static_cast<const Image *>(nullptr), static_cast<const Image *>(&mask)}) {
    const LumaError error = luma_error(a, b, only), deep = luma_error(widened(a), widened(b), only);
    CHECK((deep.squares == error.squares && deep.pixels == error.pixels));
  }
  const Image grey = crop(mask, 5, 5, 20, 20), other = noise<uint8_t>(20, 20, 1, 3);
  CHECK(luma_error(widened(grey), widened(other)).squares == luma_error(grey, other).squares);
}

TEST_CASE("the PSNR of 16 bits is that of the luma over white") {
  const DeepImage a = noise<uint16_t>(50, 40, 3, 4);
  DeepImage b = a;
  uint32_t seed = 6;
  for (uint16_t &sample : b.pixels)
    sample = uint16_t(std::clamp(sample + int(next_random(seed) % 401) - 200, 0, 65535));
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); i += 3) {
    const auto luma = [&](const DeepImage &image) {
      return (0.2126 * image.pixels[i] + 0.7152 * image.pixels[i + 1] + 0.0722 * image.pixels[i + 2]) / 65535;
    };
    sum += std::pow(luma(a) - luma(b), 2);
  }
  CHECK(std::abs(psnr_luma(a, b) + 10 * std::log10(sum / (50 * 40))) < 0.01);
}

TEST_CASE("PNG of 16 bits comes back from what was written, and JPEG and 8 bits are widened") {
  for (const int channels : {1, 3}) {
    const DeepImage image = noise<uint16_t>(31, 17, channels, 7);
    const std::vector<uint8_t> file = encode_png(image);
    CHECK(file[24] == 16); // bit depth in IHDR
    CHECK(file[25] == (channels == 1 ? 0 : 2));
    CHECK(read_image<uint16_t>(write_file("deep.png", file), channels).pixels == image.pixels);
    const Image flat = noise<uint8_t>(31, 17, channels, 8);
    for (const std::vector<uint8_t> &bytes : {encode_png(flat), encode_jpeg(flat, 90, Subsampling::yuv444)}) {
      const Image read = decode_image(bytes.data(), bytes.size(), channels, "flat");
      CHECK(decode_image<uint16_t>(bytes.data(), bytes.size(), channels, "flat").pixels ==
            widened(read).pixels);
    }
  }
  const std::vector<uint8_t> white = encode_png(make_image<uint16_t>(2, 2, 3, 65535));
  CHECK(decode_image<uint16_t>(white.data(), white.size(), 1, "white").pixels[0] == 65535);
  const std::vector<uint8_t> grey = encode_png(make_image<uint16_t>(2, 2, 1, 4660));
  CHECK(decode_image<uint16_t>(grey.data(), grey.size(), 3, "grey").pixels[2] == 4660);
}
