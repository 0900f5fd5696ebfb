// video/: the VCFG payload and the H.264 configuration record in it.
#include "exact.h"

#include "fvv/video.h"

#include "fvv_catch.h"

#include <string>

extern "C" {
#include "base/bytes.h"
#include "base/layout.h"
}

namespace {

using bytes = std::vector<uint8_t>;

// High profile, level 4.0, one SPS and one PPS of made-up content, chroma format and bit depths.
const bytes high = {1, 100, 0, 40, 0xff, 0xe1, 0,    6,    0x67, 100,  0,    40, 9,
                    9, 1,   0, 4,  0x68, 0xee, 0x3c, 0x80, 0xfd, 0xf8, 0xf8, 0};
// Baseline, two SPS, two PPS, nothing after them.
const bytes baseline = {1,  66,   0xc0, 30, 0xff, 0xe2, 0, 4,    0x67, 66, 0xc0, 30,   0, 5, 0x67,
                        66, 0xc0, 30,   1,  2,    0,    2, 0x68, 1,    0,  3,    0x68, 2, 2};

fvv_video_config avc(const bytes &record, const std::string &text) {
  fvv_video_config c = {};
  c.codec = FVV_CODEC_AVC1;
  c.width = 960;
  c.height = 1088;
  c.shows = FVV_SHOWS_TILES;
  c.bit_depth = 8;
  c.colour_primaries = 1;
  c.transfer_characteristics = 2;
  c.matrix_coefficients = 3;
  c.record = record.data();
  c.record_size = record.size();
  c.codec_string = text.data();
  c.codec_string_size = text.size();
  return c;
}

fvv_video_config jpeg() {
  fvv_video_config c = {};
  c.codec = FVV_CODEC_JPEG;
  c.width = 480;
  c.height = 270;
  c.shows = FVV_SHOWS_ATLAS;
  c.bit_depth = 8;
  c.full_range = 1;
  return c;
}

bytes encoded(const fvv_video_config &c) {
  size_t size = 0;
  REQUIRE(fvv_video_config_encode(&c, nullptr, 0, &size, nullptr) == FVV_ERROR_BUFFER_TOO_SMALL);
  bytes out(size, 0xa5);
  REQUIRE(fvv_video_config_encode(&c, out.data(), size, &size, nullptr) == FVV_OK);
  return out;
}

fvv_status decode(const bytes &payload, size_t size, fvv_diagnostic *d, const fvv_limits *limits = nullptr) {
  const exact block(payload, size);
  fvv_video_config c = {};
  return fvv_video_config_decode(&c, block.data(), size, limits, d);
}

fvv_status check(const bytes &record, size_t size) {
  const exact block(record, size);
  fvv_diagnostic d;
  char text[FVV_CODEC_STRING_CAPACITY];
  const fvv_status status = fvv_video_codec_string(FVV_CODEC_AVC1, block.data(), size, text, &d);
  if (status != FVV_OK) REQUIRE((d.issue == FVV_ISSUE_VIDEO_RECORD && d.offset <= size));
  return status;
}

fvv_status check(const bytes &record) {
  return check(record, record.size());
}

} // namespace

TEST_CASE("a video configuration comes back byte for byte and value for value") {
  const std::string text = "avc1.640028", upper = "avc1.42C01E";
  for (const fvv_video_config &c : {avc(high, text), avc(baseline, upper), jpeg()}) {
    const bytes p = encoded(c);
    CHECK(p.size() == 24 + c.record_size + c.codec_string_size);
    fvv_video_config back = {};
    REQUIRE(fvv_video_config_decode(&back, p.data(), p.size(), nullptr, nullptr) == FVV_OK);
    CHECK((back.codec == c.codec && back.width == c.width && back.height == c.height));
    CHECK((back.shows == c.shows && back.bit_depth == c.bit_depth));
    CHECK((back.colour_primaries == c.colour_primaries && back.matrix_coefficients == c.matrix_coefficients));
    CHECK((back.transfer_characteristics == c.transfer_characteristics && back.full_range == c.full_range));
    CHECK(bytes(back.record, back.record + back.record_size) == bytes(c.record, c.record + c.record_size));
    CHECK(std::string(back.codec_string, back.codec_string_size) ==
          std::string(c.codec_string ? c.codec_string : "", c.codec_string_size));
    CHECK(encoded(back) == p);
  }
  const bytes p = encoded(avc(high, text));
  CHECK(std::string(p.begin(), p.begin() + 4) == "avc1");
  CHECK(fvv_get_u32(&p[8]) == 1088);
  CHECK(p[15] == 2);
  CHECK(fvv_get_u16(&p[18]) == text.size());
  CHECK(fvv_get_u32(&p[20]) == high.size());
  CHECK(std::string(p.end() - 11, p.end()) == text);
}

TEST_CASE("the bit depth of H.264 is the record's, or that of a profile which has no other") {
  const auto status = [](const bytes &record, const std::string &text, uint8_t depth) {
    fvv_video_config c = avc(record, text);
    c.bit_depth = depth;
    uint8_t payload[256];
    size_t size = 0;
    fvv_diagnostic d = {};
    const fvv_status result = fvv_video_config_encode(&c, payload, sizeof payload, &size, &d);
    if (result != FVV_OK) CHECK(d.issue == FVV_ISSUE_VIDEO_RECORD);
    return result;
  };
  bytes high10 = high;
  high10[1] = high10[9] = 110;
  high10[high10.size() - 3] = high10[high10.size() - 2] = 0xfa;
  const bytes short_high(high.begin(), high.end() - 4), short_high10(high10.begin(), high10.end() - 4);
  CHECK(status(high, "avc1.640028", 8) == FVV_OK);
  CHECK(status(high, "avc1.640028", 10) == FVV_ERROR_INPUT);
  CHECK(status(short_high, "avc1.640028", 8) == FVV_OK);
  CHECK(status(short_high, "avc1.640028", 10) == FVV_ERROR_INPUT);
  CHECK(status(baseline, "avc1.42c01e", 8) == FVV_OK);
  CHECK(status(baseline, "avc1.42c01e", 9) == FVV_ERROR_INPUT);
  CHECK(status(high10, "avc1.6e0028", 10) == FVV_OK);
  CHECK(status(high10, "avc1.6e0028", 8) == FVV_ERROR_INPUT);
  for (const uint8_t any : {8, 9, 10}) CHECK(status(short_high10, "avc1.6e0028", any) == FVV_OK);
  high10[high10.size() - 2] = 0xf8;
  CHECK(status(high10, "avc1.6e0028", 10) == FVV_ERROR_INPUT); // luma and chroma differ
}

TEST_CASE("JPEG has 8 bits") {
  bytes payload = encoded(jpeg());
  payload[FVV_VCFG_BIT_DEPTH] = 10;
  fvv_diagnostic d;
  CHECK(decode(payload, payload.size(), &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_VIDEO_RANGE);
}

TEST_CASE("every rule of VCFG has its number") {
  const struct {
    const char *what;
    uint32_t issue;
    size_t offset, width;
    uint32_t value;
  } faults[] = {
      {"width 0", FVV_ISSUE_VIDEO_RANGE, FVV_VCFG_WIDTH, 4, 0},
      {"height 0", FVV_ISSUE_VIDEO_RANGE, FVV_VCFG_HEIGHT, 4, 0},
      {"bit depth 7", FVV_ISSUE_VIDEO_RANGE, FVV_VCFG_BIT_DEPTH, 1, 7},
      {"bit depth 17", FVV_ISSUE_VIDEO_RANGE, FVV_VCFG_BIT_DEPTH, 1, 17},
      {"full range 2", FVV_ISSUE_VIDEO_RANGE, FVV_VCFG_FULL_RANGE, 1, 2},
      {"record one longer", FVV_ISSUE_VIDEO_PAYLOAD, FVV_VCFG_RECORD_SIZE, 4, 26},
      {"record of 4 GiB", FVV_ISSUE_VIDEO_PAYLOAD, FVV_VCFG_RECORD_SIZE, 4, 0xffffffffu},
      {"codec string one shorter", FVV_ISSUE_VIDEO_PAYLOAD, FVV_VCFG_CODEC_STRING_SIZE, 2, 10},
      {"record version", FVV_ISSUE_VIDEO_RECORD, FVV_VCFG_SIZE, 1, 0},
      {"another profile in the codec string", FVV_ISSUE_VIDEO_RECORD, FVV_VCFG_SIZE + 25 + 6, 1, '5'},
      {"another level in the codec string", FVV_ISSUE_VIDEO_RECORD, FVV_VCFG_SIZE + 25 + 10, 1, '9'},
      {"another entry in the codec string", FVV_ISSUE_VIDEO_RECORD, FVV_VCFG_SIZE + 25, 1, 'A'},
      {"codec string not UTF-8", FVV_ISSUE_TEXT, FVV_VCFG_SIZE + 25 + 3, 1, 0xff},
  };
  REQUIRE(high.size() == 25);
  const std::string text = "avc1.640028";
  const bytes good = encoded(avc(high, text));
  fvv_diagnostic d;
  for (const auto &f : faults) {
    CAPTURE(f.what);
    bytes bad = good;
    if (f.width == 1) bad[f.offset] = (uint8_t)f.value;
    if (f.width == 2) fvv_put_u16(&bad[f.offset], (uint16_t)f.value);
    if (f.width == 4) fvv_put_u32(&bad[f.offset], f.value);
    CHECK(decode(bad, bad.size(), &d) == FVV_ERROR_INVALID);
    CHECK(d.issue == f.issue);
    CHECK(d.chunk_type == FVV_CHUNK_VIDEO_CONFIG);
    CHECK(d.offset <= bad.size());
  }
  // Both sizes together are right but for 2^32.
  bytes bad = good;
  fvv_put_u16(&bad[FVV_VCFG_CODEC_STRING_SIZE], 0xffff);
  fvv_put_u32(&bad[FVV_VCFG_RECORD_SIZE], 0u - 0xffffu + 36u);
  CHECK(decode(bad, bad.size(), &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_VIDEO_PAYLOAD);
  // Offsets within the record are offsets within the payload.
  bad = good;
  bad[FVV_VCFG_SIZE + 4] = 0xfe;
  CHECK(decode(bad, bad.size(), &d) == FVV_ERROR_INVALID);
  CHECK(d.offset == FVV_VCFG_SIZE + 4);
  CHECK(std::string(d.message) == "H.264 record: lengthSizeMinusOne is 2, expected 3");

  // Without record or codec string H.264 cannot be decoded; with them JPEG is something else.
  const auto refused = [&](const fvv_video_config &c) {
    uint8_t out[256];
    size_t size;
    REQUIRE(fvv_video_config_encode(&c, out, sizeof out, &size, &d) == FVV_ERROR_INPUT);
    return d.issue;
  };
  CHECK(refused(avc({}, text)) == FVV_ISSUE_VIDEO_RECORD);
  CHECK(refused(avc(high, "")) == FVV_ISSUE_VIDEO_RECORD);
  CHECK(refused(avc(high, "avc1.640028 ")) == FVV_ISSUE_VIDEO_RECORD);
  fvv_video_config c = jpeg();
  c.codec_string = text.data();
  c.codec_string_size = 1;
  CHECK(refused(c) == FVV_ISSUE_VIDEO_RECORD);
  c = jpeg();
  c.record = high.data();
  c.record_size = high.size();
  CHECK(refused(c) == FVV_ISSUE_VIDEO_RECORD);
  c = jpeg();
  c.shows = 2;
  CHECK(refused(c) == FVV_ISSUE_VIDEO_CODEC);
  // What is not known stops a track and is not wrong.
  bad = good;
  bad[FVV_VCFG_SHOWS] = 2;
  CHECK(decode(bad, bad.size(), &d) == FVV_ERROR_UNSUPPORTED);
  CHECK(d.issue == FVV_ISSUE_VIDEO_CODEC);
}

TEST_CASE("unknown codecs are not supported, and named") {
  fvv_diagnostic d;
  const bytes good = encoded(jpeg());
  for (const uint32_t codec : {(uint32_t)0x30317076 /* vp10 */, (uint32_t)0, (uint32_t)0x31637641}) {
    bytes p = good;
    fvv_put_u32(&p[FVV_VCFG_CODEC], codec);
    CHECK(decode(p, p.size(), &d) == FVV_ERROR_UNSUPPORTED);
    CHECK(d.issue == FVV_ISSUE_VIDEO_CODEC);
    fvv_video_config c = jpeg();
    c.codec = codec;
    uint8_t out[64];
    size_t size;
    CHECK(fvv_video_config_encode(&c, out, sizeof out, &size, &d) == FVV_ERROR_INPUT);
    CHECK(d.issue == FVV_ISSUE_VIDEO_CODEC);
    CHECK(fvv_video_sample_check(&c, 1, out, 10, &d) == FVV_ERROR_UNSUPPORTED);
    CHECK(d.issue == FVV_ISSUE_VIDEO_CODEC);
  }
  bytes p = good;
  fvv_put_u32(&p[FVV_VCFG_CODEC], 0x30317076);
  REQUIRE(decode(p, p.size(), &d) == FVV_ERROR_UNSUPPORTED);
  CHECK(std::string(d.message) ==
        "codec 'vp10' is not supported, expected 'jpeg', 'avc1', 'hvc1', 'vp09', 'av01' or 'oexr'");
  char text[FVV_CODEC_STRING_CAPACITY];
  for (const uint32_t codec : {(uint32_t)FVV_CODEC_JPEG, (uint32_t)FVV_CODEC_OEXR}) {
    CHECK(fvv_video_codec_string(codec, p.data(), p.size(), text, &d) == FVV_ERROR_UNSUPPORTED);
    CHECK(d.issue == FVV_ISSUE_VIDEO_CODEC);
  }
}

TEST_CASE("the frame's sides have a limit") {
  const bytes p = encoded(jpeg());
  fvv_limits limits;
  fvv_limits_default(&limits);
  fvv_diagnostic d;
  limits.max_dimension = 480;
  CHECK(decode(p, p.size(), &d, &limits) == FVV_OK);
  limits.max_dimension = 479;
  CHECK(decode(p, p.size(), &d, &limits) == FVV_ERROR_LIMIT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
  bytes q = p;
  fvv_put_u32(&q[FVV_VCFG_HEIGHT], 0x80000000u);
  CHECK(decode(q, q.size(), &d) == FVV_ERROR_LIMIT);
}

TEST_CASE("H.264 records: what is well formed") {
  CHECK(check(high) == FVV_OK);
  CHECK(check(baseline) == FVV_OK);
  bytes r(high.begin(), high.end() - 4); // old writers leave the extension out
  CHECK(check(r) == FVV_OK);
  r = high;
  r[24] = 1; // one SPS extension
  r.insert(r.end(), {0, 3, 0x6d, 1, 2});
  CHECK(check(r) == FVV_OK);
  for (const int profile : {110, 122, 144, 244}) {
    r = high;
    r[1] = (uint8_t)profile;
    CHECK(check(r) == FVV_OK);
  }
}

TEST_CASE("H.264 records: what is not") {
  const auto with = [](bytes r, size_t offset, int value) {
    r[offset] = (uint8_t)value;
    return r;
  };
  for (const bytes &r : {high, baseline}) {
    CHECK(check(with(r, 0, 0)) == FVV_ERROR_INVALID);
    CHECK(check(with(r, 4, 0xfd)) == FVV_ERROR_INVALID); // 2-byte lengths
    CHECK(check(with(r, 4, 0x03)) == FVV_ERROR_INVALID); // reserved bits
    CHECK(check(with(r, 5, r[5] & 31)) == FVV_ERROR_INVALID);
    CHECK(check(with(r, 5, 0xe0)) == FVV_ERROR_INVALID); // no SPS
    CHECK(check(with(r, 5, 0xff)) == FVV_ERROR_INVALID); // 31 SPS
    CHECK(check(with(r, 7, 0)) == FVV_ERROR_INVALID);    // an SPS of no bytes
    CHECK(check(with(r, 7, 3)) == FVV_ERROR_INVALID);    // an SPS without level
    CHECK(check(with(r, 6, 0xff)) == FVV_ERROR_INVALID); // longer than the record
    CHECK(check(with(r, 8, 0x68)) == FVV_ERROR_INVALID); // a PPS among the SPS
    CHECK(check(with(r, 8, 0xe7)) == FVV_ERROR_INVALID); // forbidden bit
  }
  CHECK(check(with(high, 14, 0)) == FVV_ERROR_INVALID);    // no PPS
  CHECK(check(with(high, 14, 2)) == FVV_ERROR_INVALID);    // one PPS too few
  CHECK(check(with(high, 17, 0x67)) == FVV_ERROR_INVALID); // an SPS among the PPS
  CHECK(check(with(high, 16, 1)) == FVV_ERROR_INVALID);    // a PPS of its header alone
  CHECK(check(with(high, 21, 0x3d)) == FVV_ERROR_INVALID); // reserved bits of the extension
  CHECK(check(with(high, 22, 0x00)) == FVV_ERROR_INVALID);
  CHECK(check(with(high, 23, 0x00)) == FVV_ERROR_INVALID);
  CHECK(check(with(high, 24, 1)) == FVV_ERROR_INVALID);
  for (const int profile : {66, 77, 88}) CHECK(check(with(high, 1, profile)) == FVV_ERROR_INVALID);
  bytes r = baseline;
  r.push_back(0);
  CHECK(check(r) == FVV_ERROR_INVALID);
  r = high;
  r.push_back(0);
  CHECK(check(r) == FVV_ERROR_INVALID);
  for (const bytes &whole : {high, baseline})
    for (size_t size = 0; size < whole.size(); size++)
      CHECK((check(whole, size) == FVV_OK) == (size == 21 && whole.size() == 25));
}

TEST_CASE("no prefix of a video configuration decodes, and any byte of it may be anything") {
  const std::string text = "avc1.640028", upper = "avc1.42C01E";
  int accepted = 0, refused = 0;
  for (const fvv_video_config &c : {avc(high, text), avc(baseline, upper), jpeg()}) {
    const bytes payload = encoded(c);
    fvv_diagnostic d;
    for (size_t size = 0; size < payload.size(); size++) {
      REQUIRE(decode(payload, size, &d) == FVV_ERROR_INVALID);
      REQUIRE(d.issue == FVV_ISSUE_VIDEO_PAYLOAD);
    }
    for (size_t i = 0; i < payload.size(); i++)
      for (int value = 0; value < 256; value++) {
        bytes q = payload;
        q[i] = (uint8_t)value;
        const fvv_status status = decode(q, q.size(), &d);
        REQUIRE((status == FVV_OK || d.issue != 0));
        (status == FVV_OK ? accepted : refused)++;
      }
  }
  CHECK(accepted > 1000);
  CHECK(refused > 1000);
}

TEST_CASE("a video configuration that readers with default limits refuse is not encoded") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  for (uint32_t fvv_video_config::*side : {&fvv_video_config::width, &fvv_video_config::height}) {
    fvv_video_config c = jpeg();
    c.*side = limits.max_dimension;
    const bytes good = encoded(c);
    fvv_diagnostic d = {};
    CHECK(decode(good, good.size(), &d) == FVV_OK);
    c.*side = limits.max_dimension + 1;
    size_t size = 0;
    CHECK(fvv_video_config_encode(&c, nullptr, 0, &size, &d) == FVV_ERROR_INPUT);
    CHECK(d.issue == FVV_ISSUE_LIMIT);
  }
}
