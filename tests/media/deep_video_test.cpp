// Video of 10 bits: what it is good for, its records and strings, and what is refused.
#include "display_codecs.h"
#include "fvv_catch.h"
#include "fvv_media/video.h"
#include "pictures.h"

#include <algorithm>
#include <set>

using namespace fvv::media;

namespace {

constexpr uint32_t width = 256, height = 64;
constexpr uint32_t deep_codecs[] = {FVV_CODEC_HVC1, FVV_CODEC_VP09, FVV_CODEC_AV01};

// A dark wall: grey that rises by 12 codes of 8 bits from left to right, and moves.
std::vector<DeepImage> ramps(int count) {
  std::vector<DeepImage> frames;
  for (int time = 0; time < count; time++) {
    DeepImage frame = make_image<uint16_t>(width, height, 3, 0);
    for (size_t i = 0; i < frame.pixels.size(); i++)
      frame.pixels[i] = uint16_t(257 * 40 + 257 * 12 * (i / 3 % width + size_t(time)) / width);
    frames.push_back(frame);
  }
  return frames;
}

std::vector<Image> narrowed(const std::vector<DeepImage> &frames) {
  std::vector<Image> out;
  for (const DeepImage &frame : frames) {
    out.push_back(make_image(frame.width, frame.height, frame.channels, 0));
    for (size_t i = 0; i < frame.pixels.size(); i++)
      out.back().pixels[i] = uint8_t((frame.pixels[i] + 128) / 257);
  }
  return out;
}

VideoSettings settings_of(uint32_t codec, int quality, int bit_depth = 10) {
  return {codec, width, height, quality, {1, 25}, bit_depth};
}

std::vector<DeepImage> decode_all(const VideoSettings &settings, const EncodedGroup &group) {
  Decoder decoder(config_of(settings, group));
  std::vector<DeepImage> out;
  for (const Sample &sample : group.samples)
    out.push_back(decoder.decode<uint16_t>(sample.bytes.data(), sample.bytes.size()));
  return out;
}

struct Banding {
  double rms = 0;    // error of green, in codes of 8 bits
  size_t levels = 0; // different greens in the middle row
  int widest = 0;    // columns of the widest run of one green there
};
Banding banding_of(const DeepImage &decoded, const DeepImage &source) {
  Banding found;
  double sum = 0;
  for (size_t i = 1; i < source.pixels.size(); i += 3)
    sum += std::pow((decoded.pixels[i] - source.pixels[i]) / 257.0, 2);
  found.rms = std::sqrt(sum / (width * height));
  std::set<int> levels;
  int run = 0;
  const uint16_t *row = &decoded.pixels[size_t(height / 2) * width * 3 + 1];
  for (uint32_t x = 0; x < width; x++) {
    levels.insert(row[3 * x]);
    run = x && row[3 * x] == row[3 * (x - 1)] ? run + 1 : 1;
    found.widest = std::max(found.widest, run);
  }
  found.levels = levels.size();
  return found;
}

} // namespace

TEST_CASE("a smooth ramp has bands of a quarter of the width and of the height with 10 bits") {
  const std::vector<DeepImage> frames = ramps(3);
  for (const uint32_t codec : deep_codecs) {
    const VideoSettings flat = settings_of(codec, 4, 8), deep = settings_of(codec, 4);
    const Banding with8 = banding_of(decode_all(flat, encode_group(flat, narrowed(frames)))[2], frames[2]);
    const Banding with10 = banding_of(decode_all(deep, encode_group(deep, frames))[2], frames[2]);
    CAPTURE(find_video_codec(codec)->name, with8.rms, with10.rms, with8.levels, with10.levels, with8.widest,
            with10.widest);
    CHECK(with8.rms > 0.25);
    CHECK(with10.rms < 0.4 * with8.rms);
    CHECK(with8.levels <= 13);
    CHECK(with10.levels >= 35);
    CHECK(with8.widest >= 20);
    CHECK(2 * with10.widest <= with8.widest);
  }
}

TEST_CASE("10-bit groups are pure functions of the frames, with one record for all") {
  for (const uint32_t codec : deep_codecs) {
    CAPTURE(find_video_codec(codec)->name);
    const VideoSettings settings = settings_of(codec, 20);
    const std::vector<DeepImage> frames = ramps(6);
    const EncodedGroup group = encode_group(settings, frames), again = encode_group(settings, frames);
    REQUIRE(group.samples.size() == 6);
    for (size_t i = 0; i < 6; i++) {
      CHECK(group.samples[i].bytes == again.samples[i].bytes);
      CHECK(group.samples[i].key == (i == 0));
    }
    CHECK(encode_group(settings, ramps(1)).record == group.record);
    const std::vector<DeepImage> decoded = decode_all(settings, group);
    for (size_t i = 0; i < 6; i++) CHECK(psnr_luma(decoded[i], frames[i]) > 50);
  }
}

TEST_CASE("records and codec strings say 10 bits, and libfvv holds VCFG to it") {
  const struct {
    uint32_t codec;
    const char *string;
    size_t offset; // of the byte of the record with the profile, and its expected value under the mask
    unsigned mask, profile;
    size_t depth_offset; // the same of the depth
    unsigned depth_mask, depth;
  } cases[] = {{FVV_CODEC_HVC1, "hvc1.2.4.L30.90", 1, 31, 2, 17, 7, 2},
               {FVV_CODEC_VP09, "vp09.02.10.10", 4, 255, 2, 6, 0xf0, 10 << 4},
               {FVV_CODEC_AV01, "av01.0.00M.10", 1, 0xe0, 0, 2, 0x60, 0x40}};
  for (const auto &one : cases) {
    CAPTURE(one.string);
    const VideoSettings settings = settings_of(one.codec, 30);
    const EncodedGroup group = encode_group(settings, ramps(3));
    CHECK(group.codec_string == one.string);
    CHECK((group.record[one.offset] & one.mask) == one.profile);
    CHECK((group.record[one.depth_offset] & one.depth_mask) == one.depth);
    if (one.codec == FVV_CODEC_HVC1) CHECK((group.record[18] & 7) == 2); // chroma's
    fvv_video_config config = config_of(settings, group);
    CHECK(config.bit_depth == 10);
    fvv_diagnostic diagnostic = {};
    uint8_t payload[512];
    size_t size = 0;
    REQUIRE(fvv_video_config_encode(&config, payload, sizeof payload, &size, &diagnostic) == FVV_OK);
    for (const Sample &sample : group.samples)
      CHECK(fvv_video_sample_check(&config, sample.key, sample.bytes.data(), sample.bytes.size(),
                                   &diagnostic) == FVV_OK);
    fvv_video_config read = {};
    REQUIRE(fvv_video_config_decode(&read, payload, size, nullptr, &diagnostic) == FVV_OK);
    CHECK(Decoder(read).decode(group.samples[0].bytes.data(), group.samples[0].bytes.size()).width == width);
    for (const uint8_t wrong : {8, 12}) {
      config.bit_depth = wrong;
      CHECK(fvv_video_config_encode(&config, payload, sizeof payload, &size, &diagnostic) != FVV_OK);
      CHECK(diagnostic.issue == FVV_ISSUE_VIDEO_RECORD);
    }
  }
}

TEST_CASE("a stream of another depth than its configuration is found, not believed") {
  for (const bool deep : {false, true}) {
    const VideoSettings settings = settings_of(FVV_CODEC_VP09, 30, deep ? 10 : 8);
    const EncodedGroup group =
        deep ? encode_group(settings, ramps(1)) : encode_group(settings, narrowed(ramps(1)));
    // A frame of VP9 states its depth, which is not in its record.
    EncodedGroup other = group;
    other.record[4] = deep ? 0 : 2;
    other.record[6] = uint8_t((deep ? 8 : 10) << 4);
    const VideoSettings claimed = settings_of(FVV_CODEC_VP09, 30, deep ? 8 : 10);
    fvv_video_config config = config_of(claimed, other);
    config.codec_string = deep ? "vp09.00.10.08" : "vp09.02.10.10";
    Decoder decoder(config);
    CHECK_THAT(
        error_of([&] { decoder.decode(group.samples[0].bytes.data(), group.samples[0].bytes.size()); }),
        Contains(deep ? "is not 4:2:0 with 8 bits" : "is not 4:2:0 with 10 bits"));
  }
}

TEST_CASE("pictures of either kind come out of video of either depth") {
  const std::vector<DeepImage> frames = ramps(1);
  for (const VideoCodec &codec : display_codecs())
    for (const int bits : {8, 10}) {
      if (bits > codec.deepest) continue;
      CAPTURE(codec.name, bits);
      const VideoSettings settings = settings_of(codec.code, codec.code == FVV_CODEC_JPEG ? 95 : 10, bits);
      const EncodedGroup group =
          bits == 8 ? encode_group(settings, narrowed(frames)) : encode_group(settings, frames);
      Decoder decoder(config_of(settings, group));
      const std::vector<uint8_t> &bytes = group.samples[0].bytes;
      const DeepImage deep = decoder.decode<uint16_t>(bytes.data(), bytes.size());
      const Image flat = decoder.decode(bytes.data(), bytes.size());
      // The same real number rounded to either: at most half a unit of each apart.
      int worst = 0;
      for (size_t i = 0; i < flat.pixels.size(); i++)
        worst = std::max(worst, std::abs(257 * flat.pixels[i] - deep.pixels[i]));
      CHECK(worst <= (codec.code == FVV_CODEC_JPEG ? 0 : 130));
      CHECK(psnr_luma(deep, frames[0]) > 45);
    }
}

TEST_CASE("depths that a codec does not have are refused with a reason") {
  const std::vector<DeepImage> frames = ramps(1);
  const auto refused = [&](uint32_t codec, int bits) {
    return error_of([&] { encode_group(settings_of(codec, 20, bits), frames); });
  };
  CHECK_THAT(refused(FVV_CODEC_AVC1, 10), Contains("expected 8 for H.264: browsers do not decode High 10"));
  CHECK_THAT(refused(FVV_CODEC_JPEG, 10), Contains("10 bits a sample, expected 8 for JPEG"));
  for (const uint32_t codec : deep_codecs) {
    CHECK_THAT(refused(codec, 12), Contains("12 bits a sample, expected 8 or 10"));
    CHECK_THAT(refused(codec, 9), Contains("9 bits a sample, expected 8 or 10"));
    CHECK_THAT(refused(codec, 8), Contains("pictures of 16 bits came for video of 8 bits"));
    CHECK_THAT(error_of([&] { encode_group(settings_of(codec, 20), narrowed(frames)); }),
               Contains("pictures of 8 bits came for video of 10 bits"));
  }
}

TEST_CASE("the chosen quality of 10 bits is the cheapest that reaches the target") {
  // Texture over the ramp, so that there is something to lose.
  std::vector<DeepImage> frames = ramps(2);
  uint32_t seed = 1;
  for (DeepImage &frame : frames)
    for (uint16_t &sample : frame.pixels) sample = uint16_t(sample + next_random(seed) % 4000);
  for (const uint32_t codec : deep_codecs) {
    CAPTURE(find_video_codec(codec)->name);
    VideoSettings settings = settings_of(codec, 0);
    const auto reached = [&] {
      LumaError sum;
      const std::vector<DeepImage> decoded = decode_all(settings, encode_group(settings, frames));
      for (size_t i = 0; i < frames.size(); i++) {
        const LumaError one = luma_error(decoded[i], frames[i]);
        sum.squares += one.squares;
        sum.pixels += one.pixels;
      }
      return sum.psnr();
    };
    settings.quality = int(choose_quality(settings, frames, 41).group.quality);
    CHECK(reached() >= 41);
    settings.quality++;
    CHECK(reached() < 41);
  }
}
