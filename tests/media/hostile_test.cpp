// Damaged and lying samples, records and files: an Error or a picture of the right size, never a crash.
#include "display_codecs.h"
#include "fvv_catch.h"
#include "fvv_media/video.h"
#include "pictures.h"

using namespace fvv::media;

namespace {

constexpr uint32_t width = 96, height = 64;

struct Clip {
  VideoSettings settings;
  EncodedGroup group;
  explicit Clip(uint32_t codec)
      : settings{codec, width, height, codec == FVV_CODEC_JPEG ? 80 : 24, {1, 25}},
        group(encode_group(settings, clip(width, height, 3))) {}
};

// Decodes the samples as far as they go; counts pictures and errors.
struct Outcome {
  int pictures = 0, errors = 0;
};
Outcome decode(const fvv_video_config &config, const std::vector<Sample> &samples) {
  Outcome outcome;
  try {
    Decoder decoder(config);
    for (const Sample &sample : samples) try {
        const Image image = decoder.decode(sample.bytes.data(), sample.bytes.size());
        REQUIRE(image.pixels.size() == size_t(config.width) * config.height * 3);
        outcome.pictures++;
      } catch (const fvv::Error &error) {
        REQUIRE(std::string(error.what()).size() > 10);
        outcome.errors++;
      }
  } catch (const fvv::Error &) {
    outcome.errors++;
  }
  return outcome;
}

} // namespace

TEST_CASE("every cut of a sample is an error, or in VP9 a picture") {
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    const Clip one(codec.code);
    const std::vector<uint8_t> &whole = one.group.samples[0].bytes;
    for (size_t size = 0; size < whole.size(); size += 1 + size / 40) {
      CAPTURE(size, whole.size());
      const Sample cut = {{whole.begin(), whole.begin() + std::ptrdiff_t(size)}, true};
      const Outcome outcome = decode(config_of(one.settings, one.group), {cut});
      // VP9 has no lengths around its last tile: after the headers decoders read zeros past the end.
      if (codec.code != FVV_CODEC_VP09 || size < 20) CHECK(outcome.errors == 1);
    }
  }
}

TEST_CASE("an H.264 slice that ends early is an error even if its length agrees") {
  const Clip one(FVV_CODEC_AVC1);
  for (const double part : {0.02, 0.3, 0.6, 0.9}) {
    std::vector<uint8_t> bytes = one.group.samples[0].bytes;
    bytes.resize(std::max<size_t>(5, size_t(part * double(bytes.size()))));
    const size_t length = bytes.size() - 4;
    for (int i = 0; i < 4; i++) bytes[size_t(i)] = uint8_t(length >> (24 - 8 * i));
    CHECK(decode(config_of(one.settings, one.group), {{bytes, true}}).errors == 1);
  }
}

TEST_CASE("flipped bits in samples give errors or pictures") {
  uint32_t state = 5;
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    const Clip one(codec.code);
    Outcome total;
    for (int round = 0; round < 300; round++) {
      std::vector<Sample> samples = one.group.samples;
      std::vector<uint8_t> &bytes = samples[next_random(state) % samples.size()].bytes;
      for (uint32_t flips = 1 + next_random(state) % 3; flips > 0; flips--)
        bytes[next_random(state) % bytes.size()] ^= uint8_t(1u << next_random(state) % 8);
      const Outcome outcome = decode(config_of(one.settings, one.group), samples);
      total.pictures += outcome.pictures;
      total.errors += outcome.errors;
    }
    CHECK(total.pictures + total.errors == 900);
    CHECK(total.errors > 15); // some damage is beyond what a codec can see: that is what chunks have CRCs for
    CHECK(total.pictures > 300);
  }
}

TEST_CASE("records that are cut, flipped or lying give errors or pictures of the configured size") {
  for (const uint32_t codec : {FVV_CODEC_AVC1, FVV_CODEC_HVC1, FVV_CODEC_VP09, FVV_CODEC_AV01}) {
    const Clip one(codec);
    fvv_video_config config = config_of(one.settings, one.group);
    for (size_t bit = 0; bit < one.group.record.size() * 8; bit++) {
      std::vector<uint8_t> record = one.group.record;
      record[bit / 8] ^= uint8_t(1u << bit % 8);
      config.record = record.data();
      const Outcome outcome = decode(config, one.group.samples);
      REQUIRE(outcome.pictures + outcome.errors >= 1);
    }
    config.record = one.group.record.data();
    for (size_t size = 0; size < one.group.record.size(); size++) {
      CAPTURE(codec, size);
      config.record_size = size;
      const Outcome outcome = decode(config, one.group.samples);
      // H.264 may leave the last four bytes out.
      CHECK((outcome.errors == 1 || (codec == FVV_CODEC_AVC1 && size + 4 == one.group.record.size())));
    }
  }
}

TEST_CASE("H.264 records that lie are named") {
  const Clip one(FVV_CODEC_AVC1);
  fvv_video_config config = config_of(one.settings, one.group);
  std::vector<uint8_t> record = one.group.record;
  record[4] = 0xfd;
  config.record = record.data();
  CHECK_THAT(error_of([&] { Decoder decoder(config); }), Contains("lengthSizeMinusOne is 1, expected 3"));
  record[0] = 0;
  CHECK_THAT(error_of([&] { Decoder decoder(config); }), Contains("version is 0, expected 1"));
}

TEST_CASE("a picture of another size than in the configuration is an error") {
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    const Clip one(codec.code);
    for (const uint32_t change : {uint32_t(-2), 2u}) {
      fvv_video_config config = config_of(one.settings, one.group);
      config.width += change;
      const std::vector<uint8_t> &bytes = one.group.samples[0].bytes;
      CHECK_THAT(error_of([&] { Decoder(config).decode(bytes.data(), bytes.size()); }),
                 Contains("96 x 64, its configuration says"));
    }
    fvv_video_config small = config_of(one.settings, one.group);
    small.width = small.height = 2;
    CHECK(decode(small, {one.group.samples[0]}).errors == 1);
  }
}

TEST_CASE("configurations that cannot be decoded are refused") {
  const Clip one(FVV_CODEC_AVC1);
  const auto error_with = [&](auto change) {
    fvv_video_config config = config_of(one.settings, one.group);
    change(config);
    return error_of([&] { Decoder decoder(config); });
  };
  CHECK(error_with([](fvv_video_config &) {}).empty());
  CHECK_THAT(error_with([](fvv_video_config &c) { c.codec = FVV_CODEC_HVC1; }), Contains("HEVC record"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.codec = 0x30317076; }), Contains("codec vp10"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.bit_depth = 10; }), Contains("10 bits"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.colour_primaries = 9; }), Contains("primaries"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.transfer_characteristics = 16; }), Contains("transfer"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.width = 20000; }), Contains("20000"));
  CHECK_THAT(error_with([](fvv_video_config &c) { c.codec = FVV_CODEC_JPEG; }), Contains("record"));
  CHECK_THAT(error_with([](fvv_video_config &c) {
               c.codec = FVV_CODEC_JPEG;
               c.record_size = 0;
             }),
             Contains("BT.601"));
}

TEST_CASE("flipped bits in PNG and JPEG files give errors or pictures") {
  uint32_t state = 9;
  const Image image = scene(50, 40, 0);
  for (const std::vector<uint8_t> &file : {encode_png(image), encode_jpeg(image, 80, Subsampling::yuv444)}) {
    int errors = 0;
    for (int round = 0; round < 400; round++) {
      std::vector<uint8_t> bad = file;
      for (uint32_t flips = 1 + next_random(state) % 4; flips > 0; flips--)
        bad[next_random(state) % bad.size()] ^= uint8_t(1u << next_random(state) % 8);
      const std::string error = error_of([&] {
        const Image decoded = decode_image(bad.data(), bad.size(), 3, "flipped");
        REQUIRE(decoded.pixels.size() == size_t(decoded.width) * decoded.height * 3);
      });
      errors += !error.empty();
    }
    CHECK(errors > 40);
  }
}

TEST_CASE("what decoding takes is known from the configuration alone, and a limit refuses it") {
  fvv_video_config config = {};
  config.codec = FVV_CODEC_VP09;
  config.width = config.height = 4096;
  config.bit_depth = 8;
  const uint64_t taken = uint64_t(209) << 20; // measured: a sample of 2,328 bytes
  CHECK(decoding_memory(config) > taken);
  CHECK(decoding_memory(config) < 2 * taken);
  // 8K in 10 bits fits the default of the tools.
  config.codec = FVV_CODEC_HVC1;
  config.width = 8192;
  config.height = 4320;
  config.bit_depth = 10;
  CHECK(decoding_memory(config) < uint64_t(3) << 30);
  CHECK_NOTHROW(check_memory("decoding", 1 << 20, {1 << 20, "the limit"}));
  CHECK_THROWS_WITH(check_memory("track 2: decoding", (5 << 20) + 1, {2 << 20, "--max-memory"}),
                    "track 2: decoding takes up to 6 MiB, --max-memory allows 2 MiB");
}

TEST_CASE("sizes of memory are read as they are written") {
  const uint64_t one = 1;
  for (const auto &[text, bytes] :
       {std::pair("0", uint64_t(0)), std::pair("1023", uint64_t(1023)), std::pair("1K", one << 10),
        std::pair("512M", one << 29), std::pair("4G", one << 32), std::pair("4294967296G", one << 62),
        std::pair("4611686018427387904", one << 62)}) {
    CHECK(parse_memory(text) == bytes);
    CHECK(parse_memory(memory_text(bytes)) == bytes);
  }
  CHECK(parse_memory("3g") == 3 * (one << 30));
  CHECK(memory_text(one << 29) == "512M");
  CHECK(memory_text(1025) == "1025");
  for (const char *text :
       {"", "K", "-1", "+1", " 1", "1 ", "1.5G", "1KB", "1T", "0x10", "4294967297G", "99999999999999999999"})
    CHECK(parse_memory(text) == std::nullopt);
}
