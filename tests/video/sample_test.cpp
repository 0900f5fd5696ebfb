// video/: what is checked of a sample before a decoder sees it.
#include "exact.h"

#include "fvv/video.h"

#include "fvv_catch.h"

#include <string>

namespace {

using bytes = std::vector<uint8_t>;

fvv_video_config config(uint32_t codec) {
  fvv_video_config c = {};
  c.codec = codec;
  c.width = 480;
  c.height = 270;
  c.bit_depth = 8;
  c.camera_id = FVV_NO_CAMERA;
  return c;
}

fvv_status check(uint32_t codec, int key, const bytes &sample, size_t size) {
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
  return check(FVV_CODEC_JPEG, 1, sample, sample.size());
}

fvv_status avc(int key, const bytes &sample) {
  return check(FVV_CODEC_AVC1, key, sample, sample.size());
}

bytes joined(std::initializer_list<bytes> parts) {
  bytes all;
  for (const bytes &part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const bytes soi = {0xff, 0xd8}, eoi = {0xff, 0xd9};
const bytes jfif = {0xff, 0xe0, 0, 16, 'J', 'F', 'I', 'F', 0, 1, 1, 0, 0, 1, 0, 1, 0, 0};
const bytes table = {0xff, 0xdb, 0, 5, 1, 2, 3};
const bytes scan = {0xff, 0xda, 0, 2, 0x12, 0xff, 0x00, 0x34};

// A frame header of 480 x 270 pixels: SOF0 0xc0 unless told.
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

bytes unit(int header, size_t size) {
  bytes u = {(uint8_t)(size >> 24), (uint8_t)(size >> 16), (uint8_t)(size >> 8), (uint8_t)size};
  u.push_back((uint8_t)header);
  u.resize(4 + size, 0x42);
  return u;
}

const bytes idr = unit(0x65, 20), slice = unit(0x41, 9), sei = unit(0x06, 3), delimiter = unit(0x09, 2);

} // namespace

TEST_CASE("JPEG samples of the configured size pass") {
  CHECK(jpeg(joined({soi, jfif, table, frame(), scan, eoi})) == FVV_OK);
  CHECK(jpeg(joined({soi, frame(0xc0, 1), scan, eoi})) == FVV_OK);
  for (const int marker : {0xc1, 0xc2}) CHECK(jpeg(joined({soi, table, frame(marker), scan, eoi})) == FVV_OK);
  // Fill bytes in front of a marker, and TEM, which has no length.
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
  CHECK(check(FVV_CODEC_JPEG, 0, good, good.size()) == FVV_ERROR_INVALID);
}

TEST_CASE("H.264 samples are filled by their units and have an IDR picture when they are key samples") {
  CHECK(avc(1, idr) == FVV_OK);
  CHECK(avc(1, joined({delimiter, sei, idr, idr})) == FVV_OK);
  CHECK(avc(1, joined({unit(0x67, 8), unit(0x68, 4), idr})) == FVV_OK);
  CHECK(avc(0, slice) == FVV_OK);
  CHECK(avc(0, joined({delimiter, slice, slice})) == FVV_OK);
  CHECK(avc(0, unit(0x41, 1)) == FVV_OK);

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
  CHECK(avc(0, unit(0xc1, 9)) == FVV_ERROR_INVALID);
  // Start codes instead of lengths: Annex B, the usual mistake.
  CHECK(avc(1, {0, 0, 0, 1, 0x65, 0x88, 0x84, 0, 0, 0, 1, 0x65, 0x88}) == FVV_ERROR_INVALID);
}

TEST_CASE("no prefix of a sample passes, and any byte of it may be anything") {
  const bytes picture = joined({soi, jfif, table, frame(), scan, eoi}),
              access = joined({delimiter, sei, idr});
  for (size_t size = 0; size < picture.size(); size++)
    REQUIRE(check(FVV_CODEC_JPEG, 1, picture, size) == FVV_ERROR_INVALID);
  for (size_t size = 0; size < access.size(); size++)
    REQUIRE(check(FVV_CODEC_AVC1, 1, access, size) == FVV_ERROR_INVALID);
  int accepted = 0, refused = 0;
  for (const uint32_t codec : {(uint32_t)FVV_CODEC_JPEG, (uint32_t)FVV_CODEC_AVC1}) {
    const bytes &sample = codec == FVV_CODEC_JPEG ? picture : access;
    for (size_t i = 0; i < sample.size(); i++)
      for (int value = 0; value < 256; value++) {
        bytes q = sample;
        q[i] = (uint8_t)value;
        (check(codec, 1, q, q.size()) == FVV_OK ? accepted : refused)++;
      }
  }
  CHECK(accepted > 1000);
  CHECK(refused > 1000);
}
