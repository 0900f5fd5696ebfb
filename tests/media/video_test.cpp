// fvv_media/video.h: groups of all codecs, their samples and records, and the choice of quality.
#include "display_codecs.h"
#include "fvv_catch.h"
#include "fvv_media/video.h"
#include "pictures.h"

extern "C" {
#include <libavcodec/avcodec.h>
}

#include <algorithm>
#include <cstring>
#include <set>

using namespace fvv::media;

namespace {

constexpr uint32_t width = 160, height = 96;
constexpr uint32_t inter_codecs[] = {FVV_CODEC_AVC1, FVV_CODEC_HVC1, FVV_CODEC_VP09, FVV_CODEC_AV01};

VideoSettings settings_of(uint32_t codec, int quality) {
  return {codec, width, height, quality, {1, 25}};
}

std::vector<Image> decode_all(const VideoSettings &settings, const EncodedGroup &group) {
  Decoder decoder(config_of(settings, group));
  std::vector<Image> out;
  for (const Sample &sample : group.samples)
    out.push_back(decoder.decode(sample.bytes.data(), sample.bytes.size()));
  return out;
}

// NAL unit types of a sample; the lengths must fill it.
std::vector<int> unit_types(const std::vector<uint8_t> &sample) {
  std::vector<int> types;
  size_t at = 0;
  while (at + 4 < sample.size()) {
    const size_t length = size_t(sample[at]) << 24 | size_t(sample[at + 1]) << 16 |
                          size_t(sample[at + 2]) << 8 | sample[at + 3];
    types.push_back(sample[at + 4] & 31);
    at += 4 + length;
  }
  REQUIRE(at == sample.size());
  return types;
}

double mean_psnr(const std::vector<Image> &a, const std::vector<Image> &b) {
  LumaError sum;
  for (size_t i = 0; i < a.size(); i++) {
    const LumaError one = luma_error(a[i], b[i]);
    sum.squares += one.squares;
    sum.pixels += one.pixels;
  }
  return sum.psnr();
}

} // namespace

TEST_CASE("all codecs round-trip above their floors, one picture a sample, in order") {
  const std::vector<Image> frames = clip(width, height, 9);
  const struct {
    uint32_t codec;
    int quality;
    double floor;
  } cases[] = {{FVV_CODEC_JPEG, 90, 36}, {FVV_CODEC_JPEG, 30, 28}, {FVV_CODEC_AVC1, 15, 40},
               {FVV_CODEC_AVC1, 32, 28}, {FVV_CODEC_HVC1, 15, 40}, {FVV_CODEC_HVC1, 32, 28},
               {FVV_CODEC_VP09, 12, 40}, {FVV_CODEC_VP09, 40, 28}, {FVV_CODEC_AV01, 12, 40},
               {FVV_CODEC_AV01, 40, 28}};
  for (const auto &one : cases) {
    CAPTURE(one.codec, one.quality);
    const VideoSettings settings = settings_of(one.codec, one.quality);
    const EncodedGroup group = encode_group(settings, frames);
    REQUIRE(group.samples.size() == frames.size());
    const std::vector<Image> decoded = decode_all(settings, group);
    for (size_t i = 0; i < frames.size(); i++) {
      CHECK(psnr_luma(decoded[i], frames[i]) > one.floor);
      // The square moves: a picture of the wrong moment would be nearer to another frame.
      if (i > 0) CHECK(psnr_luma(decoded[i], frames[i]) > psnr_luma(decoded[i], frames[i - 1]) + 3);
      if (i + 1 < frames.size())
        CHECK(psnr_luma(decoded[i], frames[i]) > psnr_luma(decoded[i], frames[i + 1]) + 3);
    }
  }
}

TEST_CASE("encoding is a pure function") {
  const std::vector<Image> frames = clip(width, height, 5), others = clip(width, height, 2);
  for (const VideoCodec &codec : display_codecs()) {
    const VideoSettings settings = settings_of(codec.code, 30);
    const EncodedGroup first = encode_group(settings, frames);
    encode_group(settings, others);
    const EncodedGroup again = encode_group(settings, frames);
    REQUIRE(first.samples.size() == again.samples.size());
    for (size_t i = 0; i < first.samples.size(); i++) CHECK(first.samples[i].bytes == again.samples[i].bytes);
    CHECK(first.record == again.record);
  }
}

TEST_CASE("groups of any length and content have the same record, and each decodes alone") {
  for (const uint32_t codec : inter_codecs) {
    const VideoSettings settings = settings_of(codec, 24);
    const EncodedGroup reference = encode_group(settings, clip(width, height, 12));
    for (const int length : {1, 2, 3, 50}) {
      CAPTURE(codec, length);
      std::vector<Image> frames = clip(width, height, length);
      for (Image &frame : frames) std::reverse(frame.pixels.begin(), frame.pixels.end());
      const EncodedGroup group = encode_group(settings, frames);
      CHECK(group.record == reference.record);
      CHECK(group.codec_string == reference.codec_string);
      CHECK(mean_psnr(decode_all(settings, group), frames) > 30);
    }
  }
}

TEST_CASE("codec strings say profile, level and depth") {
  const auto text = [](uint32_t codec, uint32_t wide, uint32_t high) {
    return encode_group({codec, wide, high, 40, {1, 25}}, clip(wide, high, 1)).codec_string;
  };
  CHECK(text(FVV_CODEC_AVC1, 160, 96).substr(0, 9) == "avc1.6400");
  CHECK(text(FVV_CODEC_HVC1, 160, 96) == "hvc1.1.6.L30.90");
  CHECK(text(FVV_CODEC_VP09, 160, 96) == "vp09.00.10.08");
  CHECK(text(FVV_CODEC_AV01, 160, 96) == "av01.0.00M.08");
  CHECK(text(FVV_CODEC_HVC1, 960, 544) == "hvc1.1.6.L90.90");
  CHECK(text(FVV_CODEC_VP09, 960, 544) == "vp09.00.30.08");
  CHECK(text(FVV_CODEC_AV01, 960, 544) == "av01.0.04M.08");
  // Higher than wide: the longer side counts.
  CHECK(text(FVV_CODEC_VP09, 32, 1024) == "vp09.00.21.08");
}

TEST_CASE("a hard cut inside a group opens no other key") {
  std::vector<Image> cut = clip(width, height, 40);
  for (size_t i = 20; i < cut.size(); i++)
    for (uint8_t &sample : cut[i].pixels) sample = uint8_t(255 - sample);
  for (const uint32_t codec : inter_codecs) {
    const EncodedGroup group = encode_group(settings_of(codec, 30), cut);
    for (size_t i = 0; i < cut.size(); i++) CHECK(group.samples[i].key == (i == 0));
    CHECK(mean_psnr(decode_all(settings_of(codec, 30), group), cut) > 28);
  }
}

TEST_CASE("H.264 samples are slices after lengths, IDR first and only first") {
  const EncodedGroup group = encode_group(settings_of(FVV_CODEC_AVC1, 24), clip(width, height, 60));
  for (size_t i = 0; i < group.samples.size(); i++) {
    const std::vector<int> types = unit_types(group.samples[i].bytes);
    CHECK(types == std::vector<int>{i == 0 ? 5 : 1});
    CHECK(group.samples[i].key == (i == 0));
  }
  // A hard cut inside the group must not open another IDR.
  std::vector<Image> cut = clip(width, height, 4);
  for (size_t i = 2; i < 4; i++)
    for (uint8_t &sample : cut[i].pixels) sample = uint8_t(255 - sample);
  const EncodedGroup with_cut = encode_group(settings_of(FVV_CODEC_AVC1, 24), cut);
  for (size_t i = 1; i < 4; i++) CHECK(unit_types(with_cut.samples[i].bytes) == std::vector<int>{1});
}

TEST_CASE("JPEG samples are files from SOI to EOI, all keys, without record") {
  const EncodedGroup group = encode_group(settings_of(FVV_CODEC_JPEG, 75), clip(width, height, 3));
  CHECK(group.record.empty());
  CHECK(group.codec_string.empty());
  for (const Sample &sample : group.samples) {
    CHECK(sample.key);
    REQUIRE(sample.bytes.size() > 4);
    CHECK((sample.bytes[0] == 0xff && sample.bytes[1] == 0xd8));
    CHECK((sample.bytes.end()[-2] == 0xff && sample.bytes.end()[-1] == 0xd9));
  }
}

TEST_CASE("libfvv's own rules accept what the encoders make") {
  for (const VideoCodec &codec : display_codecs()) {
    const VideoSettings settings = settings_of(codec.code, 30);
    const EncodedGroup group = encode_group(settings, clip(width, height, 4));
    const fvv_video_config config = config_of(settings, group);
    fvv_diagnostic diagnostic = {};
    uint8_t payload[512];
    size_t size = 0;
    CHECK(fvv_video_config_encode(&config, payload, sizeof payload, &size, &diagnostic) == FVV_OK);
    CAPTURE(diagnostic.message);
    for (const Sample &sample : group.samples)
      CHECK(fvv_video_sample_check(&config, sample.key, sample.bytes.data(), sample.bytes.size(),
                                   &diagnostic) == FVV_OK);
    // The decoder takes the configuration as a reader of the stream has it.
    fvv_video_config read = {};
    fvv_limits limits = {};
    limits.struct_size = sizeof limits;
    fvv_limits_default(&limits);
    REQUIRE(fvv_video_config_decode(&read, payload, size, &limits, &diagnostic) == FVV_OK);
    const Sample &first = group.samples[0];
    CHECK(Decoder(read).decode(first.bytes.data(), first.bytes.size()).width == width);
  }
}

TEST_CASE("a decoder continues at any key and only there") {
  for (const uint32_t codec : inter_codecs) {
    CAPTURE(codec);
    const VideoSettings settings = settings_of(codec, 24);
    const EncodedGroup group = encode_group(settings, clip(width, height, 6));
    const std::vector<Image> expected = decode_all(settings, group);
    Decoder decoder(config_of(settings, group));
    const auto decode = [&](size_t i) {
      return decoder.decode(group.samples[i].bytes.data(), group.samples[i].bytes.size());
    };
    CHECK_THAT(error_of([&] { decode(1); }), Contains("is not a key"));
    CHECK(decode(0).pixels == expected[0].pixels);
    CHECK(decode(1).pixels == expected[1].pixels);
    CHECK(decode(0).pixels == expected[0].pixels); // back to the start
    CHECK(decode(1).pixels == expected[1].pixels);
    CHECK(!error_of([&] { decoder.decode(group.samples[2].bytes.data(), 0); }).empty());
    CHECK_THAT(error_of([&] { decode(2); }), Contains("is not a key"));
    for (size_t i = 0; i < 3; i++) CHECK(decode(i).pixels == expected[i].pixels);
  }
}

TEST_CASE("an H.264 sample that is damaged within makes the decoder wait for a key") {
  const VideoSettings settings = settings_of(FVV_CODEC_AVC1, 24);
  const EncodedGroup group = encode_group(settings, clip(width, height, 6));
  Decoder decoder(config_of(settings, group));
  const auto decode = [&](size_t i) {
    return decoder.decode(group.samples[i].bytes.data(), group.samples[i].bytes.size());
  };
  const Image first = decode(0);
  std::vector<uint8_t> short_slice(group.samples[3].bytes.begin(), group.samples[3].bytes.begin() + 12);
  short_slice[0] = short_slice[1] = short_slice[2] = 0;
  short_slice[3] = 8;
  CHECK_THAT(error_of([&] { decoder.decode(short_slice.data(), short_slice.size()); }),
             Contains("is damaged"));
  CHECK_THAT(error_of([&] { decode(4); }), Contains("is not a key"));
  CHECK_THAT(error_of([&] { decode(5); }), Contains("is not a key"));
  CHECK(decode(0).pixels == first.pixels);
}

namespace {

// The result of libavcodec's H.264 decoder for the second of two samples, with its own settings and
// concealment.
bool witness_misses_blocks(const EncodedGroup &group, const std::vector<uint8_t> &second) {
  const AVCodec *codec = avcodec_find_decoder(AV_CODEC_ID_H264);
  AVCodecContext *context = avcodec_alloc_context3(codec);
  context->extradata = static_cast<uint8_t *>(av_mallocz(group.record.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  memcpy(context->extradata, group.record.data(), group.record.size());
  context->extradata_size = int(group.record.size());
  context->thread_count = 1;
  context->flags |= AV_CODEC_FLAG_LOW_DELAY;
  REQUIRE(avcodec_open2(context, codec, nullptr) == 0);
  AVPacket *packet = av_packet_alloc();
  AVFrame *frame = av_frame_alloc();
  bool misses = false;
  for (const std::vector<uint8_t> &bytes : {group.samples[0].bytes, second}) {
    REQUIRE(av_new_packet(packet, int(bytes.size())) == 0);
    memcpy(packet->data, bytes.data(), bytes.size());
    misses = avcodec_send_packet(context, packet) == 0 && avcodec_receive_frame(context, frame) == 0 &&
             frame->decode_error_flags != 0;
    av_packet_unref(packet);
  }
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&context);
  return misses;
}

} // namespace

TEST_CASE("an H.264 picture with missing blocks is an error, not a picture") {
  const EncodedGroup group = encode_group(settings_of(FVV_CODEC_AVC1, 24), clip(width, height, 2));
  const fvv_video_config config = config_of(settings_of(FVV_CODEC_AVC1, 24), group);
  const std::vector<uint8_t> &first = group.samples[0].bytes, &good = group.samples[1].bytes;
  int missing = 0;
  for (size_t bit = 6 * 8; bit < good.size() * 8; bit += 11) {
    std::vector<uint8_t> damaged = good;
    damaged[bit / 8] ^= uint8_t(1 << bit % 8);
    if (!witness_misses_blocks(group, damaged)) continue;
    missing++;
    CAPTURE(bit);
    Decoder decoder(config);
    decoder.decode(first.data(), first.size());
    CHECK_THAT(error_of([&] { decoder.decode(damaged.data(), damaged.size()); }), Contains("is damaged"));
    CHECK_THAT(error_of([&] { decoder.decode(good.data(), good.size()); }), Contains("is not a key"));
  }
  CHECK(missing > 10);
}

TEST_CASE("settings that cannot be are refused with a reason") {
  const std::vector<Image> frames = clip(width, height, 2);
  const auto error_with = [&](auto change) {
    VideoSettings settings = settings_of(FVV_CODEC_AVC1, 24);
    change(settings);
    return error_of([&] { encode_group(settings, frames); });
  };
  CHECK_THAT(error_with([](VideoSettings &s) { s.codec = 0x30317076; }),
             Contains("codec vp10 is none of JPEG H.264 HEVC VP9 AV1 OpenEXR"));
  for (const VideoCodec &codec : display_codecs())
    for (const int wrong : {0, std::max(codec.finest, codec.coarsest) + 1})
      CHECK_THAT(error_with([&](VideoSettings &s) {
                   s.codec = codec.code;
                   s.quality = wrong;
                 }),
                 Contains(codec.name));
  CHECK_THAT(error_of([] {
               encode_group({FVV_CODEC_HVC1, 16, 8, 24, {1, 25}}, {scene(16, 8, 0)});
             }),
             Contains("at least 16 x 16"));
  CHECK_THAT(error_with([](VideoSettings &s) { s.quality = 0; }), Contains("CRF 0, expected 1 to 51"));
  CHECK_THAT(error_with([](VideoSettings &s) { s.quality = 52; }), Contains("CRF 52"));
  CHECK_THAT(error_with([](VideoSettings &s) { s.width = 162; }),
             Contains("frame 0 of the group is 160 x 96 x 3"));
  CHECK_THAT(error_with([](VideoSettings &s) { s.frame_rate = {0, 25}; }), Contains("frame rate is 0/25"));
  CHECK_THAT(error_with([](VideoSettings &s) {
               s.codec = FVV_CODEC_JPEG;
               s.quality = 0;
             }),
             Contains("JPEG quality is 0"));
  CHECK_THAT(error_of([] {
               encode_group({FVV_CODEC_AVC1, 31, 32, 24, {1, 25}}, {scene(31, 32, 0)});
             }),
             Contains("expected even"));
  CHECK_THAT(error_of([] { encode_group(settings_of(FVV_CODEC_AVC1, 24), {}); }),
             Contains("at least one frame"));
}

TEST_CASE("the chosen quality is the cheapest that reaches the target") {
  const std::vector<Image> frames = clip(width, height, 4);
  for (const VideoCodec &codec : display_codecs())
    for (const double target : {34.0, 43.0}) {
      CAPTURE(codec.name, target);
      VideoSettings settings = settings_of(codec.code, 0);
      const int quality = int(choose_quality(settings, frames, target).group.quality);
      settings.quality = quality;
      const double psnr = mean_psnr(decode_all(settings, encode_group(settings, frames)), frames);
      CHECK(psnr >= target);
      if (quality == codec.coarsest) {
        CHECK((codec.code == FVV_CODEC_AV01 && target == 34)); // its coarsest is finer than that
        continue;
      }
      CHECK(psnr < target + 2);
      settings.quality += codec.coarsest < codec.finest ? -1 : 1;
      CHECK(mean_psnr(decode_all(settings, encode_group(settings, frames)), frames) < target);
    }
}

TEST_CASE("parts of a quality spend what a whole one leaves", "[long]") {
  // With noise that stays in a part of the picture: libx264 rounds its quantiser block by block, and blocks
  // of which later frames are predicted have one of their own.
  std::vector<Image> frames = clip(width, height, 4);
  uint32_t moving = 7;
  for (Image &frame : frames) {
    uint32_t still = 1;
    for (size_t i = 0; i < frame.pixels.size(); i++) {
      const uint32_t fixed = next_random(still) & 63, other = next_random(moving) & 31;
      frame.pixels[i] = uint8_t(frame.pixels[i] / 2 + (i % (3 * width) < 2 * width ? fixed : other));
    }
  }
  const auto source = GroupSource<uint8_t>::borrowed(frames);
  const auto bytes_of = [](const EncodedGroup &group) {
    size_t sum = 0;
    for (const Sample &sample : group.samples) sum += sample.bytes.size();
    return sum;
  };
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    VideoSettings settings = settings_of(codec.code, 0);
    const bool has_parts = codec.code == FVV_CODEC_AVC1 || codec.code == FVV_CODEC_HVC1;
    CHECK(parts_of_quality(codec.code) == (has_parts ? 8 : 1));
    size_t whole = 0, in_parts = 0;
    for (const double target : {36.0, 36.3, 36.6, 37.0}) {
      const MeasuredGroup without = choose_quality(settings, source, target),
                          with = choose_quality(settings, source, target, true);
      CHECK(with.psnr >= target);
      CHECK(bytes_of(with.group) <= bytes_of(without.group));
      whole += bytes_of(without.group);
      in_parts += bytes_of(with.group);
      settings.quality = int(with.group.quality);
      settings.parts = with.group.quality - settings.quality;
      CHECK((has_parts || settings.parts == 0));
      CHECK(encode_measured(settings, source).psnr == with.psnr);
      CHECK(with.group.record == without.group.record);
    }
    CAPTURE(whole, in_parts);
    CHECK((has_parts ? in_parts < whole : in_parts == whole));
    settings.parts = 1.0 / 16;
    CHECK_THAT(error_of([&] { encode_group(settings, frames); }), Contains("parts a unit"));
  }
}

TEST_CASE("the smallest frames that tiles make can be coded") {
  for (const VideoCodec &codec : display_codecs())
    for (const uint32_t side : {16u, 32u, 48u}) {
      CAPTURE(codec.name, side);
      const VideoSettings settings = {codec.code, 16, side, 30, {1, 25}};
      const std::vector<Image> frames = clip(16, side, 3);
      CHECK(mean_psnr(decode_all(settings, encode_group(settings, frames)), frames) > 22);
    }
}

TEST_CASE("only what the masks count decides the quality") {
  // Noise on the left, a smooth ramp on the right: the ramp alone is content with far less.
  Image frame = make_image(width, height, 3, 0);
  Image mask = make_image(width, height, 1, 0);
  uint32_t state = 1;
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      memset(&frame.pixels[(size_t(y) * width + x) * 3],
             x < width / 2 ? int(next_random(state) & 255) : int(y), 3);
      mask.pixels[size_t(y) * width + x] = x < width / 2 ? 0 : 255;
    }
  const VideoSettings settings = settings_of(FVV_CODEC_JPEG, 0);
  const double all = choose_quality(settings, {frame}, 36).group.quality,
               right = choose_quality(settings, {frame}, 36, {mask}).group.quality;
  CHECK(right < all);
  CHECK_THAT(error_of([&] {
               choose_quality(settings, {frame}, 36, {mask, mask});
             }),
             Contains("2 masks came with 1"));
}

TEST_CASE("where no quality reaches the target, it is the cheapest that is as good as the best") {
  // Half the resolution of chroma loses what no quality brings back; colours that are clipped lose luma too.
  Image frame = make_image(width, height, 3, 0);
  uint32_t state = 1;
  for (uint8_t &value : frame.pixels) value = next_random(state) & 1 ? 255 : 0;
  const std::vector<Image> frames = {frame};
  const GroupSource<uint8_t> source = GroupSource<uint8_t>::borrowed(frames);
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    VideoSettings settings = settings_of(codec.code, codec.finest);
    const double best = encode_measured(settings, source).psnr;
    const MeasuredGroup chosen = choose_quality(settings, source, 99);
    CHECK(chosen.psnr < 99);
    CHECK(chosen.psnr >= best - 0.1);
    settings.quality = int(chosen.group.quality) + (codec.coarsest < codec.finest ? -1 : 1);
    CHECK(encode_measured(settings, source).psnr < best - 0.1);
  }
}

TEST_CASE("encoders ask for room before they load, more for more frames, and leave it when they are done") {
  const std::vector<Image> frames = clip(width, height, 12);
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    std::vector<uint64_t> asked;
    for (const size_t count : {size_t(2), frames.size()}) {
      size_t loads = 0, open = 0;
      const GroupSource<uint8_t> source = {
          count,
          [&](size_t i) {
            loads++;
            CHECK(open == 1);
            return GroupFrame<uint8_t>{std::make_shared<Image>(frames[i]), nullptr};
          },
          [&](uint64_t bytes) {
            CHECK(loads == 0);
            asked.push_back(bytes);
            open++;
            return std::shared_ptr<void>(&open, [&](void *) { open--; });
          }};
      encode_group(settings_of(codec.code, 30), source);
      CHECK(open == 0);
      CHECK(loads == count);
    }
    REQUIRE(asked.size() == 2);
    CHECK(asked[0] >= width * height * 3);
    const bool keeps_frames = !codec.is_stills() && codec.code != FVV_CODEC_AV01;
    CHECK((asked[1] > asked[0]) == keeps_frames);
    CHECK(asked[1] < 200 * width * height);
  }
}
