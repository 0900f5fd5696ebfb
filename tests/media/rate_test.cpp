// fvv_media/video.h: groups that keep a bit rate.
#include "display_codecs.h"
#include "fvv_catch.h"
#include "fvv_media/video.h"
#include "pictures.h"

#include <cmath>

using namespace fvv::media;

namespace {

constexpr uint32_t width = 160, height = 96;

VideoSettings settings_of(uint32_t codec, int quality) {
  return {codec, width, height, quality, {1, 25}};
}

double bytes_of(const EncodedGroup &group) {
  double bytes = 0;
  for (const Sample &sample : group.samples) bytes += double(sample.bytes.size());
  return bytes;
}

// At a part of the way from the finest quality to the coarsest.
int quality_at(const VideoCodec &codec, double part) {
  return codec.finest + int(std::lround(part * (codec.coarsest - codec.finest)));
}

std::vector<std::vector<uint8_t>> samples_of(const EncodedGroup &group) {
  std::vector<std::vector<uint8_t>> out;
  for (const Sample &sample : group.samples) out.push_back(sample.bytes);
  return out;
}

} // namespace

TEST_CASE("a group takes at most its bit rate, and little less, wherever the search begins", "[long]") {
  const std::vector<Image> frames = clip(width, height, 25);
  for (const VideoCodec &codec : display_codecs())
    for (const double part : {0.3, 0.6}) {
      const EncodedGroup fixed = encode_group(settings_of(codec.code, quality_at(codec, part)), frames);
      // Between two qualities. 25 frames take a second.
      const double rate = 8 * bytes_of(fixed) * 1.03;
      for (const double begin : {0.0, 0.5, 1.0}) {
        CAPTURE(codec.name, part, begin, rate);
        VideoSettings settings = settings_of(codec.code, quality_at(codec, begin));
        settings.bit_rate = uint64_t(rate);
        const EncodedGroup group = encode_group(settings, frames);
        CHECK(!group.over_rate);
        CHECK(8 * bytes_of(group) <= rate);
        CHECK(8 * bytes_of(group) > 0.93 * rate);
        // Near the other: the bytes are not spent on something else.
        CHECK(std::abs(group.quality - quality_at(codec, part)) <=
              0.05 * std::abs(codec.coarsest - codec.finest));
        CHECK(group.record == fixed.record);
        Decoder decoder(config_of(settings, group));
        for (const Sample &sample : group.samples)
          CHECK(decoder.decode(sample.bytes.data(), sample.bytes.size()).width == width);
      }
    }
}

TEST_CASE("what a group may take goes by its length and the frame rate") {
  VideoSettings settings = settings_of(FVV_CODEC_AVC1, 24);
  settings.bit_rate = 800000;
  CHECK(rate_budget(settings, 25) == 100000);
  CHECK(rate_budget(settings, 10) == 40000);
  settings.frame_rate = {1001, 30000};
  CHECK(rate_budget(settings, 30) == 100100);
  // Half the frames in the same time: twice the bytes for each.
  settings.frame_rate = {2, 25};
  CHECK(rate_budget(settings, 25) == 200000);
}

TEST_CASE(
    "a bit rate out of reach gives the coarsest quality and says so, one that is not needed the finest") {
  const std::vector<Image> frames = clip(width, height, 4);
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    VideoSettings settings = settings_of(codec.code, quality_at(codec, 0.5));
    settings.bit_rate = 1000;
    const EncodedGroup least = encode_group(settings, frames);
    CHECK(least.over_rate);
    CHECK(least.quality == codec.coarsest);
    CHECK(samples_of(least) == samples_of(encode_group(settings_of(codec.code, codec.coarsest), frames)));
    settings.bit_rate = 10000000000;
    const EncodedGroup most = encode_group(settings, frames);
    CHECK(!most.over_rate);
    CHECK(most.quality == codec.finest);
    CHECK(samples_of(most) == samples_of(encode_group(settings_of(codec.code, codec.finest), frames)));
  }
}

TEST_CASE("JPEG mixes neighbouring qualities evenly to use up its bit rate") {
  const std::vector<Image> frames = clip(width, height, 20);
  const auto at = [&](int quality) { return encode_group(settings_of(FVV_CODEC_JPEG, quality), frames); };
  const EncodedGroup coarse = at(96), fine = at(97);
  VideoSettings settings = settings_of(FVV_CODEC_JPEG, 50);
  settings.bit_rate = uint64_t(8 * 25.0 / 20 * (bytes_of(coarse) + bytes_of(fine)) / 2);
  const EncodedGroup group = encode_group(settings, frames);
  CHECK(group.quality == 96);
  CHECK(bytes_of(group) <= double(rate_budget(settings, 20)));
  int finer = 0;
  for (size_t i = 0; i < frames.size(); i++) {
    const bool is_fine = group.samples[i].bytes == fine.samples[i].bytes;
    CHECK((is_fine || group.samples[i].bytes == coarse.samples[i].bytes));
    finer += is_fine;
    if (i == 9) CHECK((finer >= 4 && finer <= 5));
  }
  CHECK((finer >= 9 && finer <= 10));
}
