// TEXR: what a block says of texturing, the defaults without, and each rule by its number.
#include "stream_fixture.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

namespace {

constexpr fvv_texturing wanted = {0.125, 0.4, 1.5, 5, {10, 20, 255}};

Chunk texturing_chunk() {
  return {FVV_CHUNK_TEXTURING, 0, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_texturing_encode(&wanted, out, n, size, nullptr);
          })};
}

fvv_diagnostic problem_of(const Bytes &payload) {
  fvv_texturing out;
  fvv_diagnostic d = {};
  const fvv_status status = fvv_texturing_decode(&out, payload.data(), payload.size(), &d);
  CHECK(status == (d.issue ? FVV_ERROR_INVALID : FVV_OK));
  return d;
}

Stream vector_stream(bool has_chunk) {
  Stream out = good_stream(2);
  out.repeat = true;
  if (has_chunk) out.configuration.push_back(texturing_chunk());
  return out;
}

const char *path_of(bool has_chunk, bool text) {
  if (text) return has_chunk ? FVV_TEXTURING_VECTORS "/explicit.txt" : FVV_TEXTURING_VECTORS "/default.txt";
  return has_chunk ? FVV_TEXTURING_VECTORS "/explicit.fvv" : FVV_TEXTURING_VECTORS "/default.fvv";
}

Bytes contents(const char *path) {
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file.good());
  return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

TEST_CASE("texturing is what the block says, and the defaults without") {
  for (const bool sent : {false, true}) {
    Stream source = good_stream(1);
    if (sent) source.configuration.push_back(texturing_chunk());
    Opened opened(write(source));
    const fvv_configuration *c = nullptr;
    REQUIRE(fvv_stream_configuration(opened.stream, 0, &c, nullptr) == FVV_OK);
    CHECK(bool(c->has_texturing) == sent);
    const fvv_texturing &t = c->texturing;
    CHECK(t.threshold == (sent ? 0.125 : 0.25));
    CHECK(t.depth_bias == (sent ? 0.4 : 0.2));
    CHECK(t.depth_slope == (sent ? 1.5 : 0.5));
    CHECK(t.best == (sent ? 5 : 3));
    CHECK(t.unseen[0] == (sent ? 10 : 128));
    CHECK(t.unseen[2] == (sent ? 255 : 128));
  }
}

TEST_CASE("6101, 6102: texturing out of range, of another size, or twice") {
  const Bytes good = texturing_chunk().payload;
  REQUIRE(good.size() == 32);
  REQUIRE(problem_of(good).issue == 0);
  const auto with = [&](size_t at, double value) {
    Bytes bad = good;
    std::memcpy(&bad[at], &value, sizeof value);
    return problem_of(bad);
  };
  for (const double value : {-0.01, 1.01, double(NAN), double(INFINITY)}) {
    CHECK(with(0, value).issue == FVV_ISSUE_TEXTURING_RANGE);
    CHECK(with(0, value).offset == 0);
  }
  CHECK(with(0, 0).issue == 0);
  CHECK(with(0, 1).issue == 0);
  for (const size_t at : {8u, 16u}) {
    for (const double value : {-0.01, double(NAN), double(INFINITY)}) {
      CHECK(with(at, value).issue == FVV_ISSUE_TEXTURING_RANGE);
      CHECK(with(at, value).offset == at);
    }
    CHECK(with(at, 0).issue == 0);
  }
  Bytes bad = good;
  bad[24] = 0;
  CHECK(problem_of(bad).issue == FVV_ISSUE_TEXTURING_RANGE);
  for (size_t at = 28; at < 32; at++) {
    bad = good;
    bad[at] = 1;
    CHECK(problem_of(bad).issue == FVV_ISSUE_TEXTURING_PAYLOAD);
  }
  for (size_t size = 0; size < 32; size++) // in a block of exactly that size
    CHECK(problem_of(Bytes(good.begin(), good.begin() + std::ptrdiff_t(size))).issue ==
          FVV_ISSUE_TEXTURING_PAYLOAD);
  bad = good;
  bad.push_back(0);
  CHECK(problem_of(bad).issue == FVV_ISSUE_TEXTURING_PAYLOAD);

  Stream twice = good_stream(1);
  for (int i = 0; i < 2; i++) twice.configuration.push_back(texturing_chunk());
  Opened opened(write(twice));
  const fvv_configuration *c = nullptr;
  fvv_diagnostic d = {};
  CHECK(fvv_stream_configuration(opened.stream, 0, &c, &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_TEXTURING_PAYLOAD);

  fvv_texturing none = wanted;
  none.best = 0;
  size_t written = 0;
  uint8_t out[32];
  CHECK(fvv_texturing_encode(&none, out, sizeof out, &written, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_texturing_encode(&wanted, out, 31, &written, nullptr) == FVV_ERROR_BUFFER_TOO_SMALL);
}

TEST_CASE("libfvv reads of the vectors what the plain reader of the specification reads") {
  for (const bool has_chunk : {false, true}) {
    const Bytes bytes = contents(path_of(has_chunk, false)), text = contents(path_of(has_chunk, true));
    Opened opened(bytes);
    std::ostringstream ours;
    for (size_t g = 0; g < 2; g++) {
      const fvv_configuration *c = nullptr;
      REQUIRE(fvv_stream_configuration(opened.stream, g, &c, nullptr) == FVV_OK);
      const fvv_texturing &t = c->texturing;
      ours << g << ' ' << t.threshold << ' ' << t.depth_bias << ' ' << t.depth_slope << ' ' << int(t.best);
      for (const uint8_t channel : t.unseen) ours << ' ' << int(channel);
      ours << '\n';
    }
    CHECK(ours.str() == std::string(text.begin(), text.end()));
  }
}

TEST_CASE("write the texturing vectors", "[.][make]") {
  for (const bool has_chunk : {false, true})
    write_vector(path_of(has_chunk, false), write(vector_stream(has_chunk)));
}
