// video/: records and samples of HEVC, VP9 and AV1, and what is checked of a sample before a decoder sees it.
#include "exact.h"
#include "fvv/video.h"
#include "fvv_catch.h"

#include <string>

namespace {

using bytes = std::vector<uint8_t>;

bytes joined(std::initializer_list<bytes> parts) {
  bytes all;
  for (const bytes &part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

bytes with(bytes b, size_t offset, int value) {
  b[offset] = (uint8_t)value;
  return b;
}

// The codec string of a record, or "" when it is refused.
std::string text_of(uint32_t codec, const bytes &record, size_t size) {
  const exact block(record, size);
  char text[FVV_CODEC_STRING_CAPACITY];
  fvv_diagnostic d;
  const fvv_status status = fvv_video_codec_string(codec, block.data(), size, text, &d);
  if (status != FVV_OK) {
    REQUIRE(status == FVV_ERROR_INVALID);
    REQUIRE((d.issue == FVV_ISSUE_VIDEO_RECORD && d.chunk_type == FVV_CHUNK_VIDEO_CONFIG));
    REQUIRE(d.offset <= size);
  }
  return text;
}
std::string text_of(uint32_t codec, const bytes &record) {
  return text_of(codec, record, record.size());
}

fvv_status check(uint32_t codec, int key, const bytes &sample, size_t size) {
  const exact block(sample, size);
  fvv_video_config c = {};
  c.codec = codec;
  fvv_diagnostic d;
  const fvv_status status = fvv_video_sample_check(&c, key, block.data(), size, &d);
  int found = 2;
  const fvv_status inspected = fvv_video_sample_inspect(&c, block.data(), size, &found, nullptr);
  REQUIRE((status == FVV_OK) == (inspected == FVV_OK && found == key));
  if (status != FVV_OK) {
    REQUIRE(status == FVV_ERROR_INVALID);
    REQUIRE(d.issue == (codec == FVV_CODEC_HVC1   ? FVV_ISSUE_SAMPLE_HEVC
                        : codec == FVV_CODEC_VP09 ? FVV_ISSUE_SAMPLE_VP9
                                                  : FVV_ISSUE_SAMPLE_AV1));
    REQUIRE((d.chunk_type == FVV_CHUNK_VIDEO_PACKET && d.offset <= size));
  }
  return status;
}

fvv_status hevc(int key, const bytes &sample) {
  return check(FVV_CODEC_HVC1, key, sample, sample.size());
}
fvv_status vp9(int key, const bytes &sample) {
  return check(FVV_CODEC_VP09, key, sample, sample.size());
}
fvv_status av1(int key, const bytes &sample) {
  return check(FVV_CODEC_AV01, key, sample, sample.size());
}

// Main profile, Main tier, level 3.1, one VPS, SPS and PPS of made-up content.
const bytes hvcc = joined({{1, 0x01, 0x60, 0, 0, 0, 0xb0, 0, 0, 0, 0, 0, 93},
                           {0xf0, 0, 0xfc, 0xfd, 0xf8, 0xf8, 0, 0, 0x0f, 3},
                           {0xa0, 0, 1, 0, 3, 0x40, 1, 7},
                           {0xa1, 0, 1, 0, 4, 0x42, 1, 7, 7},
                           {0xa2, 0, 1, 0, 3, 0x44, 1, 7}});
const bytes vpcc = {1, 0, 0, 0, 0, 31, 0x80, 1, 13, 1, 0, 0};
// Main profile, level 3.0; a sequence header of 3 bytes.
const bytes av1c = {0x81, 0x04, 0x0c, 0, 0x0a, 3, 0x00, 0x11, 0x22};

// A slice segment after its length.
bytes unit(int type, bool first = true, size_t size = 6) {
  bytes u = {0, 0, 0, (uint8_t)size, (uint8_t)(type << 1), 1, (uint8_t)(first ? 0x80 : 0)};
  u.resize(4 + size, 0x42);
  return u;
}

const bytes vp9_key = {0x82, 0x49, 0x83, 0x42, 0, 9, 9}, vp9_inter = {0x86, 1, 2, 3},
            vp9_hidden = {0x84, 1, 2};

// Of frames of less than 256 bytes.
bytes superframe(std::initializer_list<bytes> frames) {
  bytes all = joined(frames);
  const uint8_t marker = (uint8_t)(0xc0 | (frames.size() - 1));
  all.push_back(marker);
  for (const bytes &frame : frames) all.push_back((uint8_t)frame.size());
  all.push_back(marker);
  return all;
}

bytes obu(int type, const bytes &payload) {
  return joined({{(uint8_t)(type << 3 | 2), (uint8_t)payload.size()}, payload});
}
const bytes sequence = obu(1, {0x00, 0x11}), key_frame = obu(6, {0x10, 1, 2}), inter = obu(6, {0x30, 1, 2}),
            hidden = obu(6, {0x20, 1}), existing = obu(3, {0x80});

fvv_video_config config(uint32_t codec, const bytes &record, const std::string &text) {
  fvv_video_config c = {};
  c.codec = codec;
  c.width = c.height = 64;
  c.bit_depth = 8;
  c.record = record.data();
  c.record_size = record.size();
  c.codec_string = text.data();
  c.codec_string_size = text.size();
  return c;
}

} // namespace

TEST_CASE("configurations of HEVC, VP9 and AV1 come back, and their codec strings say what the record does") {
  const struct {
    uint32_t codec;
    const bytes &record;
    const char *text, *wrong;
  } cases[] = {{FVV_CODEC_HVC1, hvcc, "hvc1.1.6.L93.B0", "hvc1.1.6.L93.90"},
               {FVV_CODEC_VP09, vpcc, "vp09.00.31.08", "vp09.00.30.08"},
               {FVV_CODEC_AV01, av1c, "av01.0.04M.08", "av01.0.04H.08"}};
  for (const auto &one : cases) {
    CAPTURE(one.text);
    CHECK(text_of(one.codec, one.record) == one.text);
    const std::string text = one.text, wrong = one.wrong;
    fvv_video_config c = config(one.codec, one.record, text);
    uint8_t payload[256];
    size_t size = 0;
    REQUIRE(fvv_video_config_encode(&c, payload, sizeof payload, &size, nullptr) == FVV_OK);
    fvv_video_config back = {};
    REQUIRE(fvv_video_config_decode(&back, payload, size, nullptr, nullptr) == FVV_OK);
    CHECK(bytes(back.record, back.record + back.record_size) == one.record);
    CHECK(std::string(back.codec_string, back.codec_string_size) == text);
    const auto refused = [&] {
      fvv_diagnostic d;
      return fvv_video_config_encode(&c, payload, sizeof payload, &size, &d) == FVV_ERROR_INPUT &&
             d.issue == FVV_ISSUE_VIDEO_RECORD;
    };
    c.bit_depth = 10;
    CHECK(refused());
    c.bit_depth = 8;
    c.codec_string = wrong.data();
    CHECK(refused());
    c.codec_string = text.data();
    c.codec_string_size--;
    CHECK(refused());
    c.codec_string_size = 0;
    CHECK(refused());
  }
  const std::string lower = "hvc1.1.6.L93.b0";
  fvv_video_config c = config(FVV_CODEC_HVC1, hvcc, lower);
  uint8_t payload[256];
  size_t size = 0;
  CHECK(fvv_video_config_encode(&c, payload, sizeof payload, &size, nullptr) == FVV_OK);
}

TEST_CASE("configurations of 10 bits come back, and the record must say 10 of both luma and chroma") {
  const bytes hevc = with(with(with(with(hvcc, 1, 0x02), 2, 0x20), 17, 0xfa), 18, 0xfa);
  const struct {
    uint32_t codec;
    bytes record;
    const char *text;
  } cases[] = {{FVV_CODEC_HVC1, hevc, "hvc1.2.4.L93.B0"},
               {FVV_CODEC_VP09, with(with(vpcc, 4, 2), 6, 0xa0), "vp09.02.31.10"},
               {FVV_CODEC_AV01, with(av1c, 2, av1c[2] | 0x40), "av01.0.04M.10"}};
  for (const auto &one : cases) {
    const std::string text = one.text;
    CAPTURE(text);
    fvv_video_config c = config(one.codec, one.record, text);
    for (const uint8_t depth : {8, 10, 12}) {
      c.bit_depth = depth;
      uint8_t payload[256];
      size_t size = 0;
      fvv_diagnostic d = {};
      const fvv_status status = fvv_video_config_encode(&c, payload, sizeof payload, &size, &d);
      CHECK(status == (depth == 10 ? FVV_OK : FVV_ERROR_INPUT));
      CHECK(d.issue == (depth == 10 ? 0u : uint32_t(FVV_ISSUE_VIDEO_RECORD)));
      fvv_video_config back = {};
      if (depth == 10) REQUIRE(fvv_video_config_decode(&back, payload, size, nullptr, nullptr) == FVV_OK);
    }
  }
  char text[FVV_CODEC_STRING_CAPACITY];
  fvv_diagnostic d = {};
  const bytes mixed = with(hevc, 18, 0xf8);
  CHECK(fvv_video_codec_string(FVV_CODEC_HVC1, mixed.data(), mixed.size(), text, &d) == FVV_ERROR_INVALID);
  CHECK(std::string(d.message).find("the bit depth of chroma is 8, expected 10") != std::string::npos);
}

TEST_CASE("codec strings of other profiles, tiers, levels and depths") {
  bytes r = with(with(with(hvcc, 1, 0x22), 12, 153), 2, 0x20); // Main 10, High tier, level 5.1
  CHECK(text_of(FVV_CODEC_HVC1, r) == "hvc1.2.4.H153.B0");
  CHECK(text_of(FVV_CODEC_HVC1, with(r, 6, 0)) == "hvc1.2.4.H153");
  CHECK(text_of(FVV_CODEC_HVC1, with(r, 8, 0x0a)) == "hvc1.2.4.H153.B0.00.0A");
  CHECK(text_of(FVV_CODEC_HVC1, with(with(hvcc, 5, 1), 2, 0)) == "hvc1.1.80000000.L93.B0");
  CHECK(text_of(FVV_CODEC_VP09, with(with(vpcc, 4, 2), 6, 0xa2)) == "vp09.02.31.10");
  CHECK(text_of(FVV_CODEC_VP09, with(with(vpcc, 4, 3), 6, 0xc6)) == "vp09.03.31.12");
  CHECK(text_of(FVV_CODEC_AV01, with(with(av1c, 1, 0x0d), 2, 0xcc)) == "av01.0.13H.10");
  r = with(with(with(av1c, 1, 0x44), 2, 0x60), 6, 0x40);
  CHECK(text_of(FVV_CODEC_AV01, r) == "av01.2.04M.12");
}

TEST_CASE("HEVC records: what is not well formed") {
  const int faults[][2] = {{0, 0},     {1, 0x41}, {13, 0},    {15, 0},    {16, 0x01}, {17, 0x00}, {18, 0x00},
                           {21, 0x0d}, {22, 2},   {22, 4},    {23, 0x20}, {23, 0xa1}, {25, 0},    {25, 2},
                           {27, 2},    {27, 9},   {28, 0x42}, {28, 0xc0}, {31, 0xa2}, {40, 0xa7}};
  for (const auto &fault : faults) {
    CAPTURE(fault[0], fault[1]);
    CHECK(text_of(FVV_CODEC_HVC1, with(hvcc, (size_t)fault[0], fault[1])).empty());
  }
  bytes r = hvcc;
  r.push_back(0);
  CHECK(text_of(FVV_CODEC_HVC1, r).empty());
  // Two PPS.
  r = with(hvcc, 42, 2);
  r.insert(r.end(), {0, 3, 0x44, 1, 8});
  CHECK(text_of(FVV_CODEC_HVC1, r) == "hvc1.1.6.L93.B0");
}

TEST_CASE("VP9 and AV1 records: what is not well formed") {
  const int vp9_faults[][2] = {{0, 0},    {1, 1},    {2, 1},    {3, 1},    {4, 4},  {4, 2},
                               {6, 0xa0}, {6, 0x84}, {6, 0x88}, {6, 0x70}, {10, 1}, {11, 1}};
  for (const auto &fault : vp9_faults) {
    CAPTURE(fault[0], fault[1]);
    CHECK(text_of(FVV_CODEC_VP09, with(vpcc, (size_t)fault[0], fault[1])).empty());
  }
  CHECK(text_of(FVV_CODEC_VP09, with(with(vpcc, 4, 2), 6, 0xb0)).empty()); // 11 bits
  bytes r = vpcc;
  r.push_back(0);
  CHECK(text_of(FVV_CODEC_VP09, r).empty());

  const int av1_faults[][2] = {{0, 0x80}, {0, 1},    {1, 0x64}, {1, 0x24}, {2, 0x2c},
                               {2, 0x6c}, {3, 0x20}, {3, 1},    {4, 0x08}, {4, 0x8a},
                               {4, 0x2a}, {5, 4},    {5, 2},    {6, 0x08}, {6, 0x20}};
  for (const auto &fault : av1_faults) {
    CAPTURE(fault[0], fault[1]);
    CHECK(text_of(FVV_CODEC_AV01, with(av1c, (size_t)fault[0], fault[1])).empty());
  }
  CHECK(text_of(FVV_CODEC_AV01, with(av1c, 3, 0x1f)) == "av01.0.04M.08"); // a presentation delay
  const bytes head(av1c.begin(), av1c.begin() + 4);
  CHECK(text_of(FVV_CODEC_AV01, head).empty());
  CHECK(text_of(FVV_CODEC_AV01, joined({head, obu(1, {})})).empty());
  CHECK(text_of(FVV_CODEC_AV01, joined({av1c, obu(5, {1, 2})})) == "av01.0.04M.08");
  CHECK(text_of(FVV_CODEC_AV01, joined({av1c, sequence})).empty());
  CHECK(text_of(FVV_CODEC_AV01, joined({obu(5, {1}), av1c})).empty());
}

TEST_CASE("HEVC samples have one picture, and an IRAP picture when they are key samples") {
  for (int type = 16; type <= 23; type++) {
    CHECK(hevc(1, unit(type)) == FVV_OK);
    CHECK(hevc(0, unit(type)) == FVV_ERROR_INVALID);
  }
  for (const int type : {0, 1, 5, 15, 24}) {
    CHECK(hevc(0, unit(type)) == FVV_OK);
    CHECK(hevc(1, unit(type)) == FVV_ERROR_INVALID);
  }
  CHECK(hevc(1, joined({unit(35), unit(39), unit(19), unit(19, false)})) == FVV_OK);
  CHECK(hevc(0, joined({unit(1), unit(1)})) == FVV_ERROR_INVALID); // two pictures
  CHECK(hevc(0, unit(1, false)) == FVV_ERROR_INVALID);             // none begins
  CHECK(hevc(0, unit(39)) == FVV_ERROR_INVALID);
  for (const int type : {6, 7, 8, 9}) CHECK(hevc(0, unit(type)) == FVV_ERROR_INVALID);
  CHECK(hevc(0, with(unit(1), 4, 0x82)) == FVV_ERROR_INVALID); // forbidden bit
  CHECK(hevc(0, with(unit(1), 5, 0)) == FVV_ERROR_INVALID);    // no temporal id
  CHECK(hevc(0, {0, 0, 0, 2, 2, 1}) == FVV_ERROR_INVALID);     // a slice of its header alone
  CHECK(hevc(0, {0, 0, 0, 1, 2}) == FVV_ERROR_INVALID);
  CHECK(hevc(1, {}) == FVV_ERROR_INVALID);
  CHECK(hevc(1, {0, 0, 0, 1, 0x26, 1, 0xaf, 0, 0}) == FVV_ERROR_INVALID); // Annex B
}

TEST_CASE("VP9 samples show their last frame, and begin with a key frame when they are key samples") {
  CHECK(vp9(1, vp9_key) == FVV_OK);
  CHECK(vp9(0, vp9_key) == FVV_ERROR_INVALID);
  CHECK(vp9(0, vp9_inter) == FVV_OK);
  CHECK(vp9(1, vp9_inter) == FVV_ERROR_INVALID);
  CHECK(vp9(0, {0x88}) == FVV_OK); // shows a frame that was hidden
  CHECK(vp9(1, {0x88}) == FVV_ERROR_INVALID);
  CHECK(vp9(0, {}) == FVV_ERROR_INVALID);
  CHECK(vp9(0, vp9_hidden) == FVV_ERROR_INVALID);
  CHECK(vp9(0, {0x46, 1, 2}) == FVV_ERROR_INVALID);
  for (size_t i = 1; i < 4; i++) CHECK(vp9(1, with(vp9_key, i, 0)) == FVV_ERROR_INVALID);
  CHECK(vp9(1, {0x82, 0x49, 0x83, 0x42}) == FVV_ERROR_INVALID);
  // Profile 3: one more reserved bit before, so that the sync code is one bit later.
  CHECK(vp9(1, {0xb1, 0x24, 0xc1, 0xa1, 0x00, 0}) == FVV_OK);
  CHECK(vp9(1, {0xb9, 0x24, 0xc1, 0xa1, 0x00, 0}) == FVV_ERROR_INVALID);
  CHECK(vp9(1, {0xb1, 0x49, 0x83, 0x42, 0x00, 0}) == FVV_ERROR_INVALID);
  CHECK(vp9(0, {0xb3, 0}) == FVV_OK);
  CHECK(vp9(0, {0xb4}) == FVV_OK);

  CHECK(vp9(0, superframe({vp9_hidden, vp9_inter})) == FVV_OK);
  CHECK(vp9(1, superframe({vp9_key})) == FVV_OK);
  CHECK(vp9(0, superframe({vp9_inter, vp9_inter})) == FVV_ERROR_INVALID);
  CHECK(vp9(0, superframe({vp9_inter, vp9_hidden})) == FVV_ERROR_INVALID);
  const bytes key_hidden = with(vp9_key, 0, 0x80);
  CHECK(vp9(1, superframe({key_hidden, vp9_inter})) == FVV_OK);
  CHECK(vp9(0, superframe({vp9_hidden, vp9_key})) == FVV_OK); // a key frame that is not first
  const bytes good = superframe({vp9_hidden, vp9_inter});
  REQUIRE(good.size() == 11);
  CHECK(vp9(0, with(good, 8, 4)) == FVV_ERROR_INVALID);
  CHECK(vp9(0, with(good, 8, 2)) == FVV_ERROR_INVALID);
  CHECK(vp9(0, with(good, 8, 0)) == FVV_ERROR_INVALID);
  CHECK(vp9(0, with(good, 9, 3)) == FVV_ERROR_INVALID);
  CHECK(vp9(0, with(good, 9, 5)) == FVV_ERROR_INVALID);
  // Sizes of two bytes.
  CHECK(vp9(0, joined({vp9_hidden, vp9_inter, {0xc9, 3, 0, 4, 0, 0xc9}})) == FVV_OK);
  CHECK(vp9(0, joined({vp9_hidden, vp9_inter, {0xc9, 3, 0, 4, 1, 0xc9}})) == FVV_ERROR_INVALID);
  // A last byte that looks like a marker without its twin belongs to the frame.
  CHECK(vp9(0, joined({vp9_inter, {7, 7, 0xc0}})) == FVV_OK);
}

TEST_CASE("AV1 samples show one frame, a key frame after a sequence header when they are key samples") {
  CHECK(av1(1, joined({sequence, key_frame})) == FVV_OK);
  CHECK(av1(0, joined({sequence, key_frame})) == FVV_ERROR_INVALID);
  CHECK(av1(0, key_frame) == FVV_OK); // without a sequence header it is no sync sample
  CHECK(av1(1, key_frame) == FVV_ERROR_INVALID);
  CHECK(av1(0, joined({key_frame, sequence})) == FVV_OK);
  CHECK(av1(0, inter) == FVV_OK);
  CHECK(av1(0, joined({sequence, inter})) == FVV_OK);
  CHECK(av1(1, joined({sequence, inter})) == FVV_ERROR_INVALID);
  CHECK(av1(0, joined({hidden, inter})) == FVV_OK);
  CHECK(av1(0, joined({hidden, existing})) == FVV_OK);
  CHECK(av1(1, joined({sequence, obu(5, {1}), obu(3, {0x10}), obu(4, {1, 2}), obu(15, {0})})) == FVV_OK);
  CHECK(av1(0, hidden) == FVV_ERROR_INVALID);
  CHECK(av1(0, joined({inter, inter})) == FVV_ERROR_INVALID);
  CHECK(av1(0, joined({inter, existing})) == FVV_ERROR_INVALID);
  CHECK(av1(0, {}) == FVV_ERROR_INVALID);
  CHECK(av1(0, joined({obu(2, {}), inter})) == FVV_ERROR_INVALID);
  CHECK(av1(0, joined({obu(8, {1}), inter})) == FVV_ERROR_INVALID);
  CHECK(av1(0, joined({obu(6, {}), inter})) == FVV_ERROR_INVALID);
  CHECK(av1(1, joined({obu(1, {}), key_frame})) == FVV_ERROR_INVALID);
  CHECK(av1(1, joined({obu(1, {0x08}), key_frame})) == FVV_ERROR_INVALID); // of a still picture
  CHECK(av1(0, with(inter, 0, 0x30)) == FVV_ERROR_INVALID);                // no size
  CHECK(av1(0, with(inter, 0, 0xb2)) == FVV_ERROR_INVALID);                // forbidden bit
  CHECK(av1(0, with(inter, 1, 4)) == FVV_ERROR_INVALID);
  // An extension byte, and a size in more bytes than it needs.
  CHECK(av1(0, {0x36, 0x08, 3, 0x30, 1, 2}) == FVV_OK);
  CHECK(av1(0, {0x32, 0x83, 0x80, 0x00, 0x30, 1, 2}) == FVV_OK);
  CHECK(av1(0, {0x32, 0x83, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x00, 0x30, 1, 2}) ==
        FVV_ERROR_INVALID);
  CHECK(av1(0, {0x32, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f, 0x30}) == FVV_ERROR_INVALID);
}

TEST_CASE("no prefix of a record passes, of samples few, and any byte of them may be anything") {
  for (size_t size = 0; size < hvcc.size(); size++) REQUIRE(text_of(FVV_CODEC_HVC1, hvcc, size).empty());
  for (size_t size = 0; size < vpcc.size(); size++) REQUIRE(text_of(FVV_CODEC_VP09, vpcc, size).empty());
  for (size_t size = 0; size < av1c.size(); size++) REQUIRE(text_of(FVV_CODEC_AV01, av1c, size).empty());
  const bytes access = joined({unit(39), unit(19)}), unit_of_time = joined({sequence, key_frame}),
              frames = superframe({with(vp9_key, 0, 0x80), vp9_inter});
  for (size_t size = 0; size < access.size(); size++)
    REQUIRE(check(FVV_CODEC_HVC1, 1, access, size) == FVV_ERROR_INVALID);
  for (size_t size = 0; size < unit_of_time.size(); size++)
    REQUIRE(check(FVV_CODEC_AV01, 1, unit_of_time, size) == FVV_ERROR_INVALID);
  // Without its index a superframe is one frame, here a hidden one.
  for (size_t size = 0; size < frames.size(); size++)
    REQUIRE(check(FVV_CODEC_VP09, 1, frames, size) == FVV_ERROR_INVALID);
  int accepted = 0, refused = 0;
  const struct {
    uint32_t codec;
    const bytes &sample, &record;
  } all[] = {
      {FVV_CODEC_HVC1, access, hvcc}, {FVV_CODEC_VP09, frames, vpcc}, {FVV_CODEC_AV01, unit_of_time, av1c}};
  for (const auto &one : all)
    for (int value = 0; value < 256; value++) {
      for (size_t i = 0; i < one.sample.size(); i++) {
        const bytes q = with(one.sample, i, value);
        (check(one.codec, 1, q, q.size()) == FVV_OK ? accepted : refused)++;
      }
      for (size_t i = 0; i < one.record.size(); i++)
        (text_of(one.codec, with(one.record, i, value)).empty() ? refused : accepted)++;
    }
  CHECK(accepted > 1000);
  CHECK(refused > 1000);
}

// ---- video/: what is checked of a sample before a decoder sees it.

namespace {

fvv_video_config config(uint32_t codec) {
  fvv_video_config c = {};
  c.codec = codec;
  c.width = 480;
  c.height = 270;
  c.bit_depth = 8;
  return c;
}

fvv_status check_sized(uint32_t codec, int key, const bytes &sample, size_t size) {
  const exact block(sample, size);
  const fvv_video_config c = config(codec);
  fvv_diagnostic d;
  const fvv_status status = fvv_video_sample_check(&c, key, block.data(), size, &d);
  if (status != FVV_OK) {
    REQUIRE(status == FVV_ERROR_INVALID);
    REQUIRE(d.issue == (codec == FVV_CODEC_JPEG ? FVV_ISSUE_SAMPLE_JPEG : FVV_ISSUE_SAMPLE_AVC));
    REQUIRE(d.chunk_type == FVV_CHUNK_VIDEO_PACKET);
    REQUIRE(d.offset <= size);
  }
  return status;
}

fvv_status jpeg(const bytes &sample) {
  return check_sized(FVV_CODEC_JPEG, 1, sample, sample.size());
}

fvv_status avc(int key, const bytes &sample) {
  return check_sized(FVV_CODEC_AVC1, key, sample, sample.size());
}

const bytes soi = {0xff, 0xd8}, eoi = {0xff, 0xd9};
const bytes jfif = {0xff, 0xe0, 0, 16, 'J', 'F', 'I', 'F', 0, 1, 1, 0, 0, 1, 0, 1, 0, 0};
const bytes table = {0xff, 0xdb, 0, 5, 1, 2, 3};
const bytes scan = {0xff, 0xda, 0, 2, 0x12, 0xff, 0x00, 0x34};

// A frame header of 480 x 270 pixels: SOF0 0xc0 by default.
bytes frame(int marker = 0xc0, int components = 3, int bits = 8, int width = 480, int height = 270) {
  bytes f = {0xff,
             (uint8_t)marker,
             0,
             (uint8_t)(8 + 3 * components),
             (uint8_t)bits,
             (uint8_t)(height >> 8),
             (uint8_t)height,
             (uint8_t)(width >> 8),
             (uint8_t)width,
             (uint8_t)components};
  for (int i = 1; i <= components; i++)
    for (const int b : {i, 0x11, 0}) f.push_back((uint8_t)b);
  return f;
}

bytes avc_unit(int header, size_t size) {
  bytes u = {(uint8_t)(size >> 24), (uint8_t)(size >> 16), (uint8_t)(size >> 8), (uint8_t)size};
  u.push_back((uint8_t)header);
  u.resize(4 + size, 0x42);
  return u;
}

const bytes idr = avc_unit(0x65, 20), slice = avc_unit(0x41, 9), sei = avc_unit(0x06, 3),
            delimiter = avc_unit(0x09, 2);

} // namespace

TEST_CASE("JPEG samples of the configured size pass") {
  CHECK(jpeg(joined({soi, jfif, table, frame(), scan, eoi})) == FVV_OK);
  CHECK(jpeg(joined({soi, frame(0xc0, 1), scan, eoi})) == FVV_OK);
  for (const int marker : {0xc1, 0xc2}) CHECK(jpeg(joined({soi, table, frame(marker), scan, eoi})) == FVV_OK);
  // Fill bytes before a marker, and TEM, which has no length.
  CHECK(jpeg(joined({soi, {0xff, 0xff, 0xff}, jfif, {0xff, 0x01}, {0xff}, frame(), scan, eoi})) == FVV_OK);
  // Huffman tables have a number among those of the frame headers.
  CHECK(jpeg(joined({soi, {0xff, 0xc4, 0, 4, 1, 2}, frame(), scan, eoi})) == FVV_OK);
}

TEST_CASE("JPEG samples that are something else do not") {
  CHECK(jpeg({}) == FVV_ERROR_INVALID);
  CHECK(jpeg(soi) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg({0xff, 0xd8, 0xd9}) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({frame(), scan, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, frame(), scan})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, frame(), scan, eoi, {0}})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, jfif, scan, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, scan, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, eoi, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, soi, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, {0xff, 0xd0}, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, {0x00}, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, {0xff, 0x00}, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, {0xff, 0xff, 0xff}, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, {0xff, 0xe0, 0, 1}, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, {0xff, 0xe0, 0xff, 0xff}, frame(), eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, {0xff, 0xe0, 0}, eoi})) == FVV_ERROR_INVALID);
  // The last segment reaches into EOI.
  CHECK(jpeg(joined({soi, {0xff, 0xe0, 0, 4}, eoi})) == FVV_ERROR_INVALID);
  bytes grey = frame(0xc0, 1);
  grey.resize(grey.size() - 2);
  CHECK(jpeg(joined({soi, grey, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, frame(0xc0, 3, 8, 481, 270), scan, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, frame(0xc0, 3, 8, 480, 0), scan, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, frame(0xc0, 3, 8, 270, 480), scan, eoi})) == FVV_ERROR_INVALID);
  CHECK(jpeg(joined({soi, frame(0xc1, 3, 12), scan, eoi})) == FVV_ERROR_INVALID);
  for (const int components : {0, 2, 4})
    CHECK(jpeg(joined({soi, frame(0xc0, components), eoi})) == FVV_ERROR_INVALID);
  bytes wrong = frame();
  wrong[3] = 8;
  CHECK(jpeg(joined({soi, wrong, scan, eoi})) == FVV_ERROR_INVALID);
  wrong[3] = 7;
  CHECK(jpeg(joined({soi, wrong, scan, eoi})) == FVV_ERROR_INVALID);
  // Every JPEG sample is a key sample.
  const bytes good = joined({soi, frame(), scan, eoi});
  CHECK(check_sized(FVV_CODEC_JPEG, 0, good, good.size()) == FVV_ERROR_INVALID);
}

TEST_CASE("H.264 samples are filled by their units and have an IDR picture when they are key samples") {
  CHECK(avc(1, idr) == FVV_OK);
  CHECK(avc(1, joined({delimiter, sei, idr, idr})) == FVV_OK);
  CHECK(avc(1, joined({avc_unit(0x67, 8), avc_unit(0x68, 4), idr})) == FVV_OK);
  CHECK(avc(0, slice) == FVV_OK);
  CHECK(avc(0, joined({delimiter, slice, slice})) == FVV_OK);
  CHECK(avc(0, avc_unit(0x41, 1)) == FVV_OK);

  CHECK(avc(1, slice) == FVV_ERROR_INVALID);
  CHECK(avc(0, idr) == FVV_ERROR_INVALID);
  CHECK(avc(0, joined({slice, idr})) == FVV_ERROR_INVALID);
  CHECK(avc(0, {}) == FVV_ERROR_INVALID);
  CHECK(avc(1, {}) == FVV_ERROR_INVALID);
  CHECK(avc(0, {0, 0, 0, 0}) == FVV_ERROR_INVALID);
  CHECK(avc(0, joined({slice, {0, 0, 0, 0}})) == FVV_ERROR_INVALID);
  CHECK(avc(0, joined({slice, {0, 0, 0}})) == FVV_ERROR_INVALID);
  CHECK(avc(0, {0xff, 0xff, 0xff, 0xff, 0x41}) == FVV_ERROR_INVALID);
  CHECK(avc(0, {0xff, 0xff, 0xff, 0xfc, 0x41}) == FVV_ERROR_INVALID);
  CHECK(avc(0, avc_unit(0xc1, 9)) == FVV_ERROR_INVALID);
  // Start codes instead of lengths: Annex B, the usual mistake.
  CHECK(avc(1, {0, 0, 0, 1, 0x65, 0x88, 0x84, 0, 0, 0, 1, 0x65, 0x88}) == FVV_ERROR_INVALID);
}

TEST_CASE("no prefix of a sample passes, and any byte of it may be anything") {
  const bytes picture = joined({soi, jfif, table, frame(), scan, eoi}),
              access = joined({delimiter, sei, idr});
  for (size_t size = 0; size < picture.size(); size++)
    REQUIRE(check_sized(FVV_CODEC_JPEG, 1, picture, size) == FVV_ERROR_INVALID);
  for (size_t size = 0; size < access.size(); size++)
    REQUIRE(check_sized(FVV_CODEC_AVC1, 1, access, size) == FVV_ERROR_INVALID);
  int accepted = 0, refused = 0;
  for (const uint32_t codec : {(uint32_t)FVV_CODEC_JPEG, (uint32_t)FVV_CODEC_AVC1}) {
    const bytes &sample = codec == FVV_CODEC_JPEG ? picture : access;
    for (size_t i = 0; i < sample.size(); i++)
      for (int value = 0; value < 256; value++) {
        bytes q = sample;
        q[i] = (uint8_t)value;
        (check_sized(codec, 1, q, q.size()) == FVV_OK ? accepted : refused)++;
      }
  }
  CHECK(accepted > 1000);
  CHECK(refused > 1000);
}
