// Pictures of a track in any order, from single samples, and after damage.
#include "demux_fixture.h"
#include "fvv_demux/frame_plan.h"
#include "fvv_demux/picture_decoder.h"

#include <memory>

using namespace fvv;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

constexpr uint16_t video_track = 2;

// A stream in memory whose reads may be made to fail.
struct Opened {
  explicit Opened(const Bytes &stream) : bytes(stream) {
    const fvv_input input = {read_at, this, bytes.size()};
    fvv_stream *handle = nullptr;
    REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &handle, nullptr) == FVV_OK);
    opened.reset(handle);
  }
  static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
    const auto &self = *static_cast<Opened *>(user);
    if (self.fails) return FVV_ERROR_IO;
    std::copy_n(self.bytes.begin() + std::ptrdiff_t(offset), size, static_cast<uint8_t *>(out));
    return FVV_OK;
  }
  const fvv_video_layout &video() const {
    const fvv_configuration *configuration = nullptr;
    REQUIRE(fvv_stream_configuration(opened.get(), 0, &configuration, nullptr) == FVV_OK);
    const fvv_video_layout *found = fvv_configuration_video(configuration, video_track);
    REQUIRE(found);
    return *found;
  }
  fvv_status decode(demux::PictureDecoder &decoder, size_t frame) const {
    return decoder.decode(opened.get(), frame / frames_per_group * frames_per_group, frame);
  }
  std::pair<Bytes, bool> sample(size_t frame) const {
    const uint8_t *found = nullptr;
    size_t size = 0;
    int key = 0;
    REQUIRE(fvv_stream_sample(opened.get(), frame, video_track, &found, &size, &key, nullptr) == FVV_OK);
    return {Bytes(found, found + size), key != 0};
  }

  const Bytes bytes;
  bool fails = false;
  demux::Stream opened;
};

template <class Sample> bool same(const media::BasicImage<Sample> &a, const media::BasicImage<Sample> &b) {
  return a.width == b.width && a.height == b.height && a.pixels == b.pixels;
}

bool same(const demux::VideoFrame &a, const demux::VideoFrame &b) {
  if (a.index() != b.index()) return false;
  return std::visit([&](const auto &one) { return same(one, std::get<std::decay_t<decltype(one)>>(b)); }, a);
}

// The bytes with one of the payload of the n-th sample flipped; where: the offset of its chunk.
Bytes damaged(Bytes stream, size_t n, uint64_t *where = nullptr) {
  for (size_t at = 24; at < stream.size();) {
    uint64_t size = 0;
    for (size_t i = 8; i--;) size = size << 8 | stream[at + 16 + i];
    if (std::equal(stream.begin() + std::ptrdiff_t(at), stream.begin() + std::ptrdiff_t(at + 4), "VPKT") &&
        !n--) {
      stream[at + 32 + size_t(size) / 2] ^= 0x40;
      if (where) *where = at;
      return stream;
    }
    at += size_t((32 + size + 7) / 8 * 8);
  }
  FAIL("the stream has fewer samples");
  return stream;
}

StreamOptions with(uint32_t codec, int bit_depth = 8) {
  StreamOptions options;
  options.codec = codec;
  options.bit_depth = bit_depth;
  return options;
}

} // namespace

TEST_CASE("picture decoder: any order gives the pictures that frames in order give") {
  const auto [codec, bit_depth] = GENERATE(std::pair(FVV_CODEC_JPEG, 8), std::pair(FVV_CODEC_AVC1, 8),
                                           std::pair(FVV_CODEC_HVC1, 10), std::pair(FVV_CODEC_VP09, 8));
  CAPTURE(codec);
  const Opened stream(make_stream(with(codec, bit_depth)));
  demux::PictureDecoder in_order(stream.video()), decoder(stream.video());
  std::vector<std::shared_ptr<const demux::VideoFrame>> pictures;
  for (size_t frame = 0; frame < 6; frame++) {
    REQUIRE(stream.decode(in_order, frame) == FVV_OK);
    pictures.push_back(in_order.frame());
    REQUIRE(pictures.back()->index() == (bit_depth > 8 ? 1 : 0));
  }
  CHECK(!same(*pictures[0], *pictures[1]));
  for (const size_t frame : {5, 0, 2, 2, 1, 4, 3, 5}) {
    CAPTURE(frame);
    REQUIRE(stream.decode(decoder, frame) == FVV_OK);
    CHECK(same(*decoder.frame(), *pictures[frame]));
    const auto kept = decoder.frame();
    REQUIRE(stream.decode(decoder, frame) == FVV_OK);
    CHECK(decoder.frame() == kept); // not decoded again
  }
}

TEST_CASE("picture decoder: samples as they arrive give the pictures of frames by number") {
  const Opened stream(make_stream(with(FVV_CODEC_AVC1)));
  demux::PictureDecoder by_number(stream.video()), arriving(stream.video());
  for (size_t frame = 0; frame < 6; frame++) {
    if (frame == frames_per_group) arriving.begin_group();
    const auto [sample, key] = stream.sample(frame);
    REQUIRE(key == (frame % frames_per_group == 0));
    REQUIRE(arriving.decode(sample.data(), sample.size(), key) == FVV_OK);
    REQUIRE(stream.decode(by_number, frame) == FVV_OK);
    CHECK(same(*arriving.frame(), *by_number.frame()));
  }
}

TEST_CASE("picture decoder: pictures have the requested type") {
  using demux::Samples;
  const Opened stream(make_stream(with(FVV_CODEC_HVC1, 10)));
  const auto index_of = [&](Samples samples) {
    demux::PictureDecoder decoder(stream.video(), samples);
    REQUIRE(stream.decode(decoder, 1) == FVV_OK);
    return decoder.frame()->index();
  };
  CHECK(index_of(Samples::eight_bits) == 0);
  CHECK(index_of(Samples::sixteen_bits) == 1);
  CHECK(index_of(Samples::linear) == 2);
  CHECK(index_of(Samples::coded) == 1);
}

TEST_CASE("picture decoder: damage costs the pictures up to the next key") {
  uint64_t where = 0;
  const bool stills = GENERATE(false, true);
  const Opened stream(damaged(make_stream(with(stills ? FVV_CODEC_JPEG : FVV_CODEC_AVC1)), 1, &where));
  for (const std::vector<size_t> &order : {std::vector<size_t>{0, 1, 2, 3, 4, 5}, {5, 2, 4, 1, 0, 2, 3}}) {
    demux::PictureDecoder decoder(stream.video());
    for (const size_t frame : order) {
      CAPTURE(stills, frame);
      const bool lost = frame == 1 || (frame == 2 && !stills);
      CHECK(stream.decode(decoder, frame) == (lost ? FVV_ERROR_DAMAGED : FVV_OK));
      CHECK((decoder.frame() == nullptr) == lost);
      if (!lost) continue;
      CHECK(decoder.diagnostic().issue != 0);
      CHECK(decoder.diagnostic().offset == where);
      CHECK(decoder.why() == demux::text_of(decoder.diagnostic()));
    }
  }
}

TEST_CASE("picture decoder: a sample that the codec refuses costs the pictures up to the next key") {
  const Opened stream(make_stream(with(FVV_CODEC_AVC1)));
  demux::PictureDecoder decoder(stream.video());
  const auto push = [&](size_t frame, size_t size = SIZE_MAX) {
    const auto [sample, key] = stream.sample(frame);
    return decoder.decode(sample.data(), std::min(size, sample.size()), key);
  };
  REQUIRE(push(0) == FVV_OK);
  CHECK(push(1, 6) == FVV_ERROR_DAMAGED);
  CHECK(!decoder.frame());
  CHECK(decoder.diagnostic().status == FVV_OK);
  CHECK_THAT(decoder.why(), StartsWith("track 2: "));
  const std::string reason = decoder.why();
  CHECK(push(2) == FVV_ERROR_DAMAGED);
  CHECK(decoder.why() == reason);
  CHECK(push(3) == FVV_OK);
  decoder.begin_group();
  CHECK(!decoder.frame());
  CHECK(push(1) == FVV_ERROR_DAMAGED);
  CHECK_THAT(decoder.why(), Contains("before its key picture"));
}

TEST_CASE("picture decoder: without a decoder every picture is lost, and a frame without a sample has none") {
  const Opened stream(make_stream(with(FVV_CODEC_AVC1)));
  fvv_video_layout video = stream.video();
  video.config.record_size = 4;
  demux::PictureDecoder unusable(video);
  CHECK(stream.decode(unusable, 0) == FVV_ERROR_DAMAGED);
  CHECK(stream.decode(unusable, 3) == FVV_ERROR_DAMAGED);
  CHECK_THAT(unusable.why(), StartsWith("track 2: "));
  CHECK(!unusable.frame());
  video = stream.video();
  video.track = 9;
  demux::PictureDecoder other(video);
  CHECK(stream.decode(other, 0) == FVV_END);
  CHECK(stream.decode(other, 4) == FVV_END);
  CHECK(!other.frame());
}

TEST_CASE("picture decoder: a failing read is no damage: the next call starts again") {
  Opened stream(make_stream(with(FVV_CODEC_AVC1)));
  demux::PictureDecoder decoder(stream.video());
  REQUIRE(stream.decode(decoder, 1) == FVV_OK);
  const auto before = decoder.frame();
  stream.fails = true;
  CHECK(stream.decode(decoder, 2) == FVV_ERROR_IO);
  CHECK(decoder.diagnostic().status == FVV_ERROR_IO);
  CHECK(!decoder.frame());
  stream.fails = false;
  CHECK(stream.decode(decoder, 2) == FVV_OK);
  CHECK(stream.decode(decoder, 1) == FVV_OK);
  CHECK(same(*decoder.frame(), *before));
}
