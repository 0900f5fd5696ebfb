// calibration/: the CAMR payload: there and back, every rule broken once, cut and flipped bytes.
#include "cameras.h"

#include "fvv_catch.h"

#include <cstring>
#include <limits>
#include <memory>

extern "C" {
#include "base/bytes.h"
#include "base/layout.h"
}

namespace {

using bytes = std::vector<uint8_t>;

bytes encoded(const fvv_camera &c) {
  size_t size = 0;
  REQUIRE(fvv_camera_encode(&c, nullptr, 0, &size, nullptr) == FVV_ERROR_BUFFER_TOO_SMALL);
  bytes out(size);
  REQUIRE(fvv_camera_encode(&c, out.data(), size, &size, nullptr) == FVV_OK);
  REQUIRE(size == out.size());
  return out;
}

fvv_camera named(const char *name, size_t size) {
  fvv_camera c = camera_with(FVV_LENS_RADTAN, {-0.281, 0.0914, 0.0012, -0.0007, -0.013});
  c.name = name;
  c.name_size = size;
  return c;
}

// Decodes from a heap block of exactly that size, so that AddressSanitizer sees a byte too far.
fvv_status decode_exact(const bytes &payload, size_t size, fvv_diagnostic *d,
                        const fvv_limits *limits = nullptr) {
  std::unique_ptr<uint8_t[]> block(new uint8_t[size ? size : 1]);
  if (size) memcpy(block.get(), payload.data(), size);
  fvv_camera c = {};
  const fvv_status status = fvv_camera_decode(&c, size ? block.get() : nullptr, size, limits, d);
  if (status == FVV_OK) {
    // What is accepted must be safe to use.
    const double world[3] = {0.5, 0.25, 2}, pixel[2] = {100.5, 900.5};
    double out[3];
    fvv_camera_project(&c, world, out, nullptr);
    fvv_camera_unproject(&c, pixel, out);
    fvv_camera_r_max(&c);
  }
  return status;
}

} // namespace

TEST_CASE("a camera's record comes back byte for byte and value for value") {
  for (auto &[name, camera] : lenses()) {
    fvv_camera c = camera;
    c.name = name.data();
    c.name_size = name.size();
    const bytes first = encoded(c);
    CHECK(first.size() == FVV_CAMR_SIZE + name.size());
    fvv_camera back = {};
    REQUIRE(fvv_camera_decode(&back, first.data(), first.size(), nullptr, nullptr) == FVV_OK);
    CHECK(back.id == c.id);
    CHECK(back.lens == c.lens);
    CHECK((back.width == c.width && back.height == c.height));
    CHECK((back.fx == c.fx && back.fy == c.fy && back.cx == c.cx && back.cy == c.cy && back.skew == c.skew));
    CHECK(memcmp(back.distortion, c.distortion, sizeof c.distortion) == 0);
    CHECK(memcmp(back.rotation, c.rotation, sizeof c.rotation) == 0);
    CHECK(memcmp(back.translation, c.translation, sizeof c.translation) == 0);
    CHECK(back.r_max == c.r_max);
    CHECK(std::string(back.name, back.name_size) == name);
    CHECK(encoded(back) == first);
  }
}

TEST_CASE("fields have the offsets of clause 9.2") {
  const fvv_camera c = named("A", 1);
  const bytes p = encoded(c);
  CHECK(fvv_get_u16(&p[0]) == 7);
  CHECK(p[2] == FVV_LENS_RADTAN);
  CHECK(fvv_get_u32(&p[4]) == 1);
  CHECK(fvv_get_u32(&p[8]) == 1920);
  CHECK(fvv_get_u32(&p[12]) == 1080);
  CHECK(fvv_get_f64(&p[16]) == 1500);
  CHECK(fvv_get_f64(&p[72]) == 0.0012); // p1 is the third coefficient
  CHECK(fvv_get_f64(&p[120]) == c.r_max);
  CHECK(fvv_get_f64(&p[128 + 8]) == c.rotation[1]);
  CHECK(fvv_get_f64(&p[216]) == 4.5);
  CHECK(p[224] == 'A');
}

TEST_CASE("with a buffer that is too small the needed size is returned, and the buffer is not changed") {
  const fvv_camera c = named("side", 4);
  uint8_t out[FVV_CAMR_SIZE + 3];
  memset(out, 0xa5, sizeof out);
  size_t size = 0;
  fvv_diagnostic d;
  CHECK(fvv_camera_encode(&c, out, sizeof out, &size, &d) == FVV_ERROR_BUFFER_TOO_SMALL);
  CHECK(size == FVV_CAMR_SIZE + 4);
  CHECK(d.issue == 0);
  for (const uint8_t b : out) REQUIRE(b == 0xa5);
}

TEST_CASE("every rule of CAMR has its number, decoding and encoding") {
  const double nan_value = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  struct fault {
    const char *what;
    uint32_t issue;
    size_t offset, width; // of the field; width 1, 2, 4 integer, 8 float
    double value;
  };
  const fault faults[] = {
      {"identifier", FVV_ISSUE_CAMERA_ID, FVV_CAMR_ID, 2, 65535},
      {"lens", FVV_ISSUE_CAMERA_LENS, FVV_CAMR_LENS, 1, 3},
      {"flags", FVV_ISSUE_CAMERA_PAYLOAD, FVV_CAMR_FLAGS, 1, 2},
      {"width 0", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_WIDTH, 4, 0},
      {"height 0", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_HEIGHT, 4, 0},
      {"fx 0", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_FX, 8, 0},
      {"fx below 0", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_FX, 8, -1500},
      {"fy NaN", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_FY, 8, nan_value},
      {"fy infinite", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_FY, 8, infinity},
      {"cx NaN", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_CX, 8, nan_value},
      {"cy infinite", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_CY, 8, -infinity},
      {"skew NaN", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_SKEW, 8, nan_value},
      {"k1 NaN", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_DISTORTION, 8, nan_value},
      {"k6 infinite", FVV_ISSUE_CAMERA_INTRINSICS, FVV_CAMR_DISTORTION + 56, 8, infinity},
      {"rotation scaled", FVV_ISSUE_CAMERA_ROTATION, FVV_CAMR_ROTATION, 8, 1.01},
      {"rotation NaN", FVV_ISSUE_CAMERA_ROTATION, FVV_CAMR_ROTATION + 64, 8, nan_value},
      {"translation infinite", FVV_ISSUE_CAMERA_ROTATION, FVV_CAMR_TRANSLATION + 16, 8, infinity},
      {"r_max 0", FVV_ISSUE_CAMERA_R_MAX, FVV_CAMR_R_MAX, 8, 0},
      {"r_max NaN", FVV_ISSUE_CAMERA_R_MAX, FVV_CAMR_R_MAX, 8, nan_value},
      {"r_max infinite with a lens", FVV_ISSUE_CAMERA_R_MAX, FVV_CAMR_R_MAX, 8, infinity},
      {"r_max beyond the fold", FVV_ISSUE_CAMERA_R_MAX, FVV_CAMR_R_MAX, 8, 50},
      {"name longer than the payload", FVV_ISSUE_CAMERA_PAYLOAD, FVV_CAMR_NAME_SIZE, 4, 5},
      {"name size overflowing", FVV_ISSUE_CAMERA_PAYLOAD, FVV_CAMR_NAME_SIZE, 4, 4294967295.0},
      {"name shorter than the payload", FVV_ISSUE_CAMERA_PAYLOAD, FVV_CAMR_NAME_SIZE, 4, 3},
      {"name with NUL", FVV_ISSUE_TEXT, FVV_CAMR_SIZE + 1, 1, 0},
      {"name not UTF-8", FVV_ISSUE_TEXT, FVV_CAMR_SIZE + 3, 1, 0xc3},
  };
  const fvv_camera camera = named("side", 4);
  const bytes good = encoded(camera);
  for (const fault &f : faults) {
    CAPTURE(f.what);
    bytes bad = good;
    if (f.width == 1) bad[f.offset] = (uint8_t)f.value;
    if (f.width == 2) fvv_put_u16(&bad[f.offset], (uint16_t)f.value);
    if (f.width == 4) fvv_put_u32(&bad[f.offset], (uint32_t)f.value);
    if (f.width == 8) fvv_put_f64(&bad[f.offset], f.value);
    fvv_diagnostic d;
    CHECK(decode_exact(bad, bad.size(), &d) == FVV_ERROR_INVALID);
    CHECK(d.status == FVV_ERROR_INVALID);
    CHECK(d.issue == f.issue);
    CHECK(d.chunk_type == FVV_CHUNK_CAMERA);
    CHECK(strlen(d.message) > 10);
  }

  fvv_camera c = camera;
  uint8_t out[300];
  size_t size = 1;
  fvv_diagnostic d;
  c.fx = nan_value;
  CHECK(fvv_camera_encode(&c, out, sizeof out, &size, &d) == FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_CAMERA_INTRINSICS);
  CHECK(d.offset == FVV_CAMR_FX);
  CHECK(size == 0);
  CHECK(std::string(d.message) == "fx is nan, expected a finite number above 0");
}

TEST_CASE("coefficients that a lens model does not use are 0") {
  fvv_diagnostic d;
  fvv_camera c = camera_with(FVV_LENS_FISHEYE, {0.01});
  c.distortion[4] = 1e-9;
  CHECK(fvv_camera_validate(&c, &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_CAMERA_PAYLOAD);
  CHECK(d.offset == FVV_CAMR_DISTORTION + 32);
  c = camera_with(FVV_LENS_NONE, {});
  c.distortion[0] = 1e-9;
  CHECK(fvv_camera_validate(&c, &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_CAMERA_PAYLOAD);
}

TEST_CASE("a rotation within 1e-4 is kept as it is, a mirror is refused") {
  fvv_camera c = named("", 0);
  c.rotation[0] *= 1 + 4e-5;
  c.rotation[5] += 2e-5;
  REQUIRE(fvv_camera_validate(&c, nullptr) == FVV_OK);
  const bytes p = encoded(c);
  fvv_camera back = {};
  REQUIRE(fvv_camera_decode(&back, p.data(), p.size(), nullptr, nullptr) == FVV_OK);
  CHECK(memcmp(back.rotation, c.rotation, sizeof c.rotation) == 0);

  c = named("", 0);
  for (int i = 0; i < 3; i++) c.rotation[i] *= 1 + 6e-5; // a row too long: its square is off by 1.2e-4
  fvv_diagnostic d;
  CHECK(fvv_camera_validate(&c, &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_CAMERA_ROTATION);

  c = named("", 0);
  for (int i = 0; i < 3; i++) c.rotation[i] = -c.rotation[i];
  CHECK(fvv_camera_validate(&c, &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_CAMERA_ROTATION);
  CHECK(std::string(d.message).find("mirrors") != std::string::npos);
}

TEST_CASE("limits hold for picture size and name") {
  const bytes p = encoded(named("side", 4));
  fvv_limits limits;
  fvv_limits_default(&limits);
  fvv_diagnostic d;
  limits.max_dimension = 1920;
  limits.max_text = 4;
  CHECK(decode_exact(p, p.size(), &d, &limits) == FVV_OK);
  limits.max_dimension = 1919;
  CHECK(decode_exact(p, p.size(), &d, &limits) == FVV_ERROR_LIMIT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
  limits.max_dimension = 1920;
  limits.max_text = 3;
  CHECK(decode_exact(p, p.size(), &d, &limits) == FVV_ERROR_LIMIT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
}

TEST_CASE("no prefix of a camera's record decodes") {
  const bytes p = encoded(named("side", 4));
  for (size_t size = 0; size < p.size(); size++) {
    fvv_diagnostic d;
    REQUIRE(decode_exact(p, size, &d) == FVV_ERROR_INVALID);
    REQUIRE(d.issue == FVV_ISSUE_CAMERA_PAYLOAD);
  }
}

TEST_CASE("any byte of a camera's record may be anything") {
  int accepted = 0, refused = 0;
  for (const auto &[name, camera] : lenses()) {
    const bytes p = encoded(camera);
    for (size_t i = 0; i < p.size(); i++)
      for (int bit = 0; bit < 10; bit++) {
        bytes q = p;
        q[i] = bit < 8 ? (uint8_t)(q[i] ^ 1 << bit) : bit == 8 ? 0 : 0xff;
        fvv_diagnostic d;
        const fvv_status status = decode_exact(q, q.size(), &d);
        REQUIRE((status == FVV_OK || status == FVV_ERROR_INVALID || status == FVV_ERROR_LIMIT));
        if (status != FVV_OK) REQUIRE(d.issue != 0);
        (status == FVV_OK ? accepted : refused)++;
      }
  }
  CHECK(accepted > 1000);
  CHECK(refused > 1000);
}

TEST_CASE("a camera that readers with default limits refuse is not encoded") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  const std::string name(size_t(limits.max_text) + 1, 'n');
  size_t size = 0;
  fvv_diagnostic d = {};
  const fvv_camera longest = named(name.data(), limits.max_text), longer = named(name.data(), name.size());
  fvv_camera back = {};
  const bytes good = encoded(longest);
  CHECK(fvv_camera_decode(&back, good.data(), good.size(), nullptr, &d) == FVV_OK);
  CHECK(fvv_camera_encode(&longer, nullptr, 0, &size, &d) == FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
  CHECK(std::string(d.message) == "1048577 bytes of a camera name, readers accept at most 1048576");

  fvv_camera wide = named("w", 1);
  wide.width = limits.max_dimension + 1;
  CHECK(fvv_camera_encode(&wide, nullptr, 0, &size, &d) == FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
}
