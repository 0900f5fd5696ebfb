// Light beyond white: pictures of linear light, and video of OpenEXR files that holds them.
#include "fvv_media/colour.h"
#include "fvv_media/exr.h"
#include "fvv_media/frame.h"
#include "fvv_media/video.h"
#include "pictures.h"

#include <half.h>

#include <cstring>
#include <fstream>
#include <limits>

using namespace fvv::media;

namespace {

constexpr uint32_t width = 60, height = 45;
constexpr float infinity = std::numeric_limits<float>::infinity();

VideoSettings settings_of(uint32_t w = width, uint32_t h = height) {
  return {FVV_CODEC_OEXR, w, h, 0, {1, 25}, 16};
}

// A smooth room with a lamp of 40 times white in it.
LinearImage room(float lamp = 40) {
  LinearImage image = make_image<float>(width, height, 3, 0);
  for (size_t i = 0; i < image.pixels.size(); i++) {
    const size_t x = i / 3 % width, y = i / 3 / width;
    const bool in_lamp = x >= 20 && x < 30 && y >= 10 && y < 16;
    image.pixels[i] = in_lamp ? lamp + float(x) : 0.05f + float(x + (i % 3) * y) / 200;
  }
  return image;
}

LinearImage decoded(const VideoSettings &settings, const EncodedGroup &group, size_t i = 0) {
  Decoder decoder(config_of(settings, group));
  return decoder.decode<float>(group.samples[i].bytes.data(), group.samples[i].bytes.size());
}

} // namespace

TEST_CASE("every finite half float comes back bit for bit from lossless OpenEXR video") {
  LinearImage all = make_image<float>(256, 248, 3, 0); // 65536 less two times 1024 that are not finite
  size_t count = 0;
  for (uint32_t bits = 0; bits < 65536; bits++) {
    Imath::half value;
    value.setBits(uint16_t(bits));
    if (!value.isFinite()) continue;
    for (size_t c = 0; c < 3; c++) all.pixels[3 * count + c] = float(value) * (c == 1 ? -1 : 1);
    count++;
  }
  REQUIRE(count == 256 * 248);
  const VideoSettings settings = settings_of(256, 248);
  const EncodedGroup group = encode_group<float>(settings, {all, all});
  REQUIRE(group.samples.size() == 2);
  CHECK((group.record.empty() && group.codec_string.empty()));
  for (const Sample &sample : group.samples) CHECK(sample.key);
  const LinearImage back = decoded(settings, group, 1);
  CHECK(memcmp(back.pixels.data(), all.pixels.data(), all.pixels.size() * sizeof(float)) == 0);
  CHECK(std::isinf(psnr_luma(all, back)));
  CHECK(encode_group<float>(settings, {all}).samples[0].bytes == group.samples[0].bytes);
  // Floats between two halves go to the nearer, to the even one from the middle.
  LinearImage fine = make_image<float>(2, 1, 3, 0);
  fine.pixels = {1.0f + 0x1p-11f, 1.0f + 3 * 0x1p-11f, 1.0f + 0x1p-12f, 65519.0f, -0x1p-25f, 0x1.8p-24f};
  const std::vector<float> expected = {1.0f, 1.0f + 0x1p-9f, 1.0f, 65504.0f, -0.0f, 0x1p-23f};
  const VideoSettings small = settings_of(2, 1);
  CHECK(decoded(small, encode_group<float>(small, {fine})).pixels == expected);
}

TEST_CASE("values that half floats do not hold are refused by channel and pixel") {
  const auto with = [](float value) {
    LinearImage image = room();
    image.pixels[3 * (7 * width + 11) + 1] = value;
    return error_of([&] { encode_group<float>(settings_of(), {image}); });
  };
  CHECK_THAT(with(std::numeric_limits<float>::quiet_NaN()),
             Contains("channel G of pixel (11, 7) is not a number"));
  CHECK_THAT(with(infinity), Contains("channel G of pixel (11, 7) is infinite"));
  CHECK_THAT(with(-infinity), Contains("is infinite"));
  CHECK_THAT(with(65520), Contains("channel G of pixel (11, 7) is 65520"));
  CHECK_THAT(with(-1e30f), Contains("expected -65504 to 65504"));
  CHECK(with(-65504).empty());
}

TEST_CASE("video in OpenEXR has no quality and no bit rate") {
  const std::string message = "video in OpenEXR has no quality and no bit rate: it is lossless";
  VideoSettings settings = settings_of();
  settings.quality = 45;
  CHECK(error_of([&] { encode_group<float>(settings, {room()}); }) == message);
  settings.quality = 0;
  settings.bit_rate = 1000000;
  CHECK(error_of([&] { encode_group<float>(settings, {room()}); }) == message);
  // A PSNR is reached without a search.
  CHECK(choose_quality<float>(settings_of(), {room()}, 42).group.quality == 0);
}

TEST_CASE("pictures of the wrong kind are refused") {
  const Image display = scene(width, height, 0);
  CHECK_THAT(error_of([&] { encode_group(settings_of(), std::vector<Image>{display}); }),
             Contains("display values came for video in OpenEXR"));
  VideoSettings jpeg = {FVV_CODEC_JPEG, width, height, 90, {1, 25}, 8};
  CHECK_THAT(error_of([&] { encode_group<float>(jpeg, {room()}); }),
             Contains("linear light came for video in JPEG"));
  VideoSettings shallow = settings_of();
  shallow.bit_depth = 10;
  CHECK_THAT(error_of([&] { encode_group<float>(shallow, {room()}); }),
             Contains("10 bits a sample, expected 16 for OpenEXR"));
}

TEST_CASE("OpenEXR video is clipped for display values, and other video becomes linear light") {
  const VideoSettings settings = settings_of();
  LinearImage picture = room();
  picture.pixels[0] = -0.5f;
  const EncodedGroup group = encode_group<float>(settings, {picture});
  Decoder decoder(config_of(settings, group));
  const std::vector<uint8_t> &bytes = group.samples[0].bytes;
  const DeepImage deep = decoder.decode<uint16_t>(bytes.data(), bytes.size());
  CHECK(deep.pixels[0] == 0);
  CHECK(deep.pixels[3 * (12 * width + 25)] == 65535);
  const Image display = decoder.decode(bytes.data(), bytes.size());
  const double light = double(Imath::half(picture.pixels[3]));
  CHECK(std::abs(display.pixels[3] - 255 * srgb_of_linear(light)) <= 0.5);

  const Image shown = scene(width, height, 1);
  const VideoSettings jpeg = {FVV_CODEC_JPEG, width, height, 100, {1, 25}, 8};
  const EncodedGroup coded = encode_group(jpeg, std::vector<Image>{shown});
  Decoder other(config_of(jpeg, coded));
  const std::vector<uint8_t> &sample = coded.samples[0].bytes;
  const LinearImage linear = other.decode<float>(sample.data(), sample.size());
  const Image codes = other.decode(sample.data(), sample.size());
  for (size_t i = 0; i < codes.pixels.size(); i++)
    REQUIRE(std::abs(255 * srgb_of_linear(double(linear.pixels[i])) - codes.pixels[i]) < 1e-4);
}

TEST_CASE("codes become light and the same codes again, of 8 bits through half floats too") {
  for (const uint32_t last : {255u, 65535u}) {
    const std::vector<float> light = linear_of_codes(last), thresholds = srgb_thresholds(last);
    REQUIRE(light.size() == last + 1);
    size_t wrong = 0;
    for (uint32_t code = 0; code <= last; code++) {
      const float value = last == 255 ? float(Imath::half(light[code])) : light[code];
      wrong +=
          size_t(std::upper_bound(thresholds.begin(), thresholds.end(), value) - thresholds.begin()) != code;
      const double display = double(code) / last;
      REQUIRE(std::abs(double(light[code]) - linear_of_srgb(display)) <= 1e-7 * display);
    }
    CHECK(wrong == 0);
  }
  for (const double x : {0.001, 0.2, 1.0, 7.5, 65504.0}) {
    CHECK(std::abs(linear_of_srgb(srgb_of_linear(x)) - x) < 1e-6 * x);
    CHECK(srgb_of_linear(-x) == -srgb_of_linear(x));
  }
}

TEST_CASE("tiles of linear light are scaled as light, and the frame around them is grey") {
  LinearImage stripes = make_image<float>(40, 20, 3, 0);
  for (size_t i = 0; i < stripes.pixels.size(); i++) stripes.pixels[i] = i / 3 % 2 ? 8.0f : -1.0f;
  const LinearImage half_size = scale(stripes, 20, 10);
  for (const float value : half_size.pixels) REQUIRE(value == 3.5f);
  const fvv_tile tile = {0, {0, 0, 40, 20}, {16, 16, 20, 10}};
  const LinearImage frame = compose<float>({tile}, {stripes}, 64, 48);
  CHECK(extract(frame, tile).pixels == half_size.pixels);
  CHECK(frame.pixels[0] == linear_of_codes(255)[flat_grey]);
  CHECK(frame.pixels[3 * (20 * 64 + 40)] == 3.5f); // the guard to the right
  LinearImage flat = stripes;
  Image mask = make_image(40, 20, 1, 0);
  mask.pixels[0] = 255;
  flatten(flat, mask, 2);
  CHECK(flat.pixels[0] == -1);
  CHECK(flat.pixels.back() == linear_of_codes(255)[flat_grey]);
}

TEST_CASE("cut and damaged OpenEXR samples give errors or pictures, and ask for little memory") {
  const LinearImage picture = room();
  const VideoSettings settings = settings_of();
  const EncodedGroup group = encode_group<float>(settings, {picture});
  const std::vector<uint8_t> &good = group.samples[0].bytes;
  Decoder decoder(config_of(settings, group));
  for (size_t size = 0; size < good.size(); size += size < 500 ? 1 : 97)
    REQUIRE(error_of([&] { decoder.decode<float>(good.data(), size); }) != "");
  uint32_t state = 3;
  size_t errors = 0;
  for (int i = 0; i < 400; i++) {
    std::vector<uint8_t> bad = good;
    const size_t most = i % 2 ? bad.size() : 700;
    bad[next_random(state) % most] ^= uint8_t(1 << next_random(state) % 8);
    errors += error_of([&] {
                const LinearImage out = decoder.decode<float>(bad.data(), bad.size());
                REQUIRE((out.width == width && out.height == height));
                for (const float value : out.pixels) REQUIRE(std::isfinite(value));
              }) != "";
  }
  CHECK(errors > 100);
  // A picture of 16384 x 16384 in blocks of one byte each.
  constexpr uint32_t side = 16384;
  VideoSettings large = settings;
  std::vector<uint8_t> sample = encode_group<float>(large, {picture}).samples[0].bytes;
  const std::string text(sample.begin(), sample.end());
  for (const std::string name : {"dataWindow", "displayWindow"}) {
    const size_t at = text.find(name) + name.size() + 1 + 6 + 4 + 8;
    const uint32_t last = side - 1;
    memcpy(&sample[at], &last, 4);
    memcpy(&sample[at + 4], &last, 4);
  }
  const size_t header = text.find(std::string("screenWindowWidth")) + 17 + 1 + 6 + 4 + 4 + 1;
  sample.resize(header);
  const uint64_t blocks = side / 32;
  for (uint64_t i = 0; i < blocks; i++) {
    const uint64_t offset = header + 8 * blocks + 9 * i;
    for (int shift = 0; shift < 64; shift += 8) sample.push_back(uint8_t(offset >> shift));
  }
  for (uint64_t i = 0; i < blocks; i++)
    for (const uint8_t byte : {uint8_t(32 * i), uint8_t(32 * i >> 8), uint8_t(0), uint8_t(0), uint8_t(1),
                               uint8_t(0), uint8_t(0), uint8_t(0), uint8_t(0)})
      sample.push_back(byte);
  large.width = large.height = side;
  const fvv_video_config config = config_of(large, {});
  fvv_diagnostic diagnostic;
  REQUIRE(fvv_video_sample_check(&config, 1, sample.data(), sample.size(), &diagnostic) == FVV_OK);
  CHECK_THAT(error_of([&] { Decoder(config).decode<float>(sample.data(), sample.size()); }),
             Contains("bytes cannot hold"));
}

TEST_CASE("a sample with a value that is not finite is damaged") {
  LinearImage picture = make_image<float>(3, 1, 3, 0.5f);
  const VideoSettings settings = settings_of(3, 1);
  const EncodedGroup group = encode_group<float>(settings, {picture});
  // So small a picture is not compressed: its samples are the last 18 bytes, B first.
  std::vector<uint8_t> sample = group.samples[0].bytes;
  sample[sample.size() - 17] = 0x7c;
  Decoder decoder(config_of(settings, group));
  REQUIRE(decoder.decode<float>(group.samples[0].bytes.data(), sample.size()).pixels == picture.pixels);
  sample[sample.size() - 18] = 0;
  CHECK_THAT(error_of([&] { decoder.decode<float>(sample.data(), sample.size()); }),
             Contains("channel B of pixel (0, 0) is infinite"));
  sample[sample.size() - 18] = 1;
  CHECK_THAT(error_of([&] { decoder.decode(sample.data(), sample.size()); }), Contains("is not a number"));
}

TEST_CASE("configurations of OpenEXR video that cannot be decoded are refused") {
  const auto error_with = [](auto change) {
    fvv_video_config config = config_of(settings_of(), {});
    change(config);
    return error_of([&] { Decoder decoder(config); });
  };
  CHECK(error_with([](fvv_video_config &) {}).empty());
  CHECK_THAT(error_with([](fvv_video_config &c) { c.colour_primaries = 9; }), Contains("BT.709's primaries"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.transfer_characteristics = 16; }), Contains("linear"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.bit_depth = 8; }), Contains("8 bits"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.width = 20000; }), Contains("20000"));
}

TEST_CASE("samples of the vector are those of the decoder that was written from the specification") {
  std::ifstream file(FVV_CASES "/vector_openexr_bars/input.fvv", std::ios::binary),
      list(FVV_LISTINGS "/openexr_bars.crc");
  const std::vector<uint8_t> bytes(std::istreambuf_iterator<char>(file), {});
  size_t count = 0;
  std::string wanted;
  for (size_t at = 24; at + 32 <= bytes.size();) { // chunks after the file header
    uint64_t size;
    memcpy(&size, &bytes[at + 16], 8);
    if (!memcmp(&bytes[at], "VPKT", 4)) {
      REQUIRE(list >> wanted);
      const VideoSettings settings = settings_of(22, 21);
      const LinearImage image = Decoder(config_of(settings, {})).decode<float>(&bytes[at + 32], size_t(size));
      std::vector<uint8_t> halves;
      for (const float value : image.pixels) {
        const uint16_t bits = Imath::half(value).bits();
        halves.push_back(uint8_t(bits));
        halves.push_back(uint8_t(bits >> 8));
      }
      CHECK(fvv_crc32c(0, halves.data(), halves.size()) == std::stoul(wanted, nullptr, 16));
      count++;
    }
    at += 32 + size_t((size + 7) / 8 * 8);
  }
  CHECK(count == 3);
}
