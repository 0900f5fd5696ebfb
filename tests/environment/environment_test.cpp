// Environments and lights: the round trip, and the number of each broken rule of clause 18.
#include "environment_fixture.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace {

// Offsets in the payload of Environment, from clause 18.
constexpr size_t part = 48, picture = 48 + 2 * 48, light = picture + 2 * 16, data = light + 3 * 112;

struct Decoded {
  const Bytes bytes; // a block of exactly this size lets a sanitizer see any read beyond it
  fvv_environment environment;
  fvv_diagnostic diagnostic = {};
  fvv_status status;
  explicit Decoded(const Bytes &payload, const fvv_limits *limits = nullptr,
                   const fvv_allocator *allocator = nullptr)
      : bytes(payload), status(fvv_environment_decode(bytes.data(), bytes.size(), limits, allocator,
                                                      &environment, &diagnostic)) {}
  Decoded(const Decoded &) = delete;
  ~Decoded() { fvv_environment_free(&environment); }
};

template <class Value> Bytes with(Bytes payload, size_t offset, Value value) {
  std::memcpy(payload.data() + offset, &value, sizeof value);
  return payload;
}

void check_refused(const Bytes &payload, uint32_t issue, fvv_status status = FVV_ERROR_INVALID) {
  const Decoded decoded(payload);
  CHECK(decoded.status == status);
  CHECK(decoded.diagnostic.issue == issue);
  CHECK(decoded.diagnostic.chunk_type == FVV_CHUNK_ENVIRONMENT);
  CHECK(decoded.diagnostic.offset <= payload.size());
  CHECK(!decoded.environment.parts);
}

} // namespace

TEST_CASE("an environment comes back as it was described") {
  Environment environment;
  const fvv_environment in = environment.view();
  const Bytes payload = environment.payload();
  const Decoded decoded(payload);
  REQUIRE(decoded.status == FVV_OK);
  const fvv_environment &out = decoded.environment;
  CHECK(!std::memcmp(out.lattice_origin, in.lattice_origin, sizeof out.lattice_origin));
  CHECK(out.lattice_step == 0.25);
  REQUIRE(out.part_count == 2);
  REQUIRE(out.picture_count == 2);
  REQUIRE(out.light_count == 3);
  for (size_t i = 0; i < 2; i++) {
    CHECK(Bytes(out.parts[i].mesh, out.parts[i].mesh + out.parts[i].mesh_size) == environment.meshes[i]);
    CHECK(out.parts[i].picture == in.parts[i].picture);
    CHECK(!std::memcmp(out.parts[i].colour, in.parts[i].colour, sizeof in.parts[i].colour));
    CHECK(out.parts[i].flags == in.parts[i].flags);
    CHECK(!std::memcmp(out.parts[i].texture_origin, in.parts[i].texture_origin, 2 * sizeof(double)));
    CHECK(!std::memcmp(out.parts[i].texture_size, in.parts[i].texture_size, 2 * sizeof(double)));
    CHECK(Bytes(out.pictures[i].data, out.pictures[i].data + out.pictures[i].size) == environment.files[i]);
    CHECK(out.pictures[i].width == in.pictures[i].width);
    CHECK(out.pictures[i].height == in.pictures[i].height);
    CHECK(out.pictures[i].codec == in.pictures[i].codec);
  }
  for (size_t i = 0; i < 3; i++) {
    CHECK(out.lights[i].type == in.lights[i].type);
    CHECK(out.lights[i].flags == in.lights[i].flags);
    for (const auto member : {&fvv_light::position, &fvv_light::direction, &fvv_light::colour})
      CHECK(!std::memcmp(out.lights[i].*member, in.lights[i].*member, 3 * sizeof(double)));
    for (const auto member :
         {&fvv_light::intensity, &fvv_light::range, &fvv_light::inner_cone, &fvv_light::outer_cone})
      CHECK(out.lights[i].*member == in.lights[i].*member);
  }
  fvv_mesh mesh;
  REQUIRE(fvv_environment_mesh(&out, 1, nullptr, nullptr, &mesh, nullptr) == FVV_OK);
  CHECK(mesh.vertex_count == 4);
  CHECK(mesh.lattice[2] == 40);
  fvv_mesh_free(&mesh);
  CHECK(fvv_environment_mesh(&out, 2, nullptr, nullptr, &mesh, nullptr) == FVV_ERROR_ARGUMENT);
}

TEST_CASE("an environment of lights alone and one of a bare mesh are environments") {
  Environment lights;
  lights.parts.clear();
  lights.pictures.clear();
  CHECK(Decoded(lights.payload()).environment.light_count == 3);
  Environment bare;
  bare.lights.clear();
  bare.pictures.clear();
  bare.parts.erase(bare.parts.begin());
  bare.meshes.erase(bare.meshes.begin());
  CHECK(Decoded(bare.payload()).environment.part_count == 1);
}

TEST_CASE("the encoder refuses what a reader would, with its number") {
  fvv_diagnostic diagnostic;
  Bytes out;
  Environment nothing;
  nothing.parts.clear();
  nothing.pictures.clear();
  nothing.lights.clear();
  CHECK(nothing.encode(out, &diagnostic) == FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == FVV_ISSUE_ENVIRONMENT_PAYLOAD);
  CHECK(out.empty());
  Environment bare;
  bare.parts[1].picture = 0;
  CHECK(bare.encode(out, &diagnostic) == FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == FVV_ISSUE_ENVIRONMENT_PART);
  CHECK(diagnostic.status == FVV_ERROR_INPUT);
}

TEST_CASE("every prefix of an environment fails, and what follows its end is ignored") {
  const Bytes payload = Environment().payload();
  for (size_t n = 0; n < payload.size(); n++) {
    const Decoded decoded(Bytes(payload.begin(), payload.begin() + std::ptrdiff_t(n)));
    REQUIRE(decoded.status == FVV_ERROR_INVALID);
    REQUIRE(decoded.diagnostic.issue != 0);
  }
  Bytes longer = payload;
  longer.push_back(0);
  CHECK(Decoded(longer).status == FVV_OK);
}

TEST_CASE("each rule of environments has a faulty payload") {
  const Bytes good = Environment().payload();
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const size_t reserved : {size_t(44), part + 15, picture + 1, picture + 3, light + 2, light + 7})
    check_refused(with(good, reserved, uint8_t(1)), FVV_ISSUE_ENVIRONMENT_PAYLOAD);
  check_refused(with(good, part + 14, uint8_t(8)), FVV_ISSUE_ENVIRONMENT_PAYLOAD);
  check_refused(with(good, light + 1, uint8_t(2)), FVV_ISSUE_ENVIRONMENT_PAYLOAD);
  for (const size_t count : {32, 36, 40})
    check_refused(with(good, count, ~0u), FVV_ISSUE_LIMIT, FVV_ERROR_LIMIT);
  for (const size_t size : {part, part + 48, picture + 12, picture + 28}) {
    check_refused(with(good, size, 0u), FVV_ISSUE_ENVIRONMENT_PAYLOAD);
    check_refused(with(good, size, ~0u), FVV_ISSUE_ENVIRONMENT_PAYLOAD);
  }
  for (const double bad : {nan, inf, 1e308})
    check_refused(with(good, 24, bad), FVV_ISSUE_ENVIRONMENT_LATTICE);
  for (const double bad : {0.0, -1.0}) check_refused(with(good, 24, bad), FVV_ISSUE_ENVIRONMENT_LATTICE);
  check_refused(with(good, 8, inf), FVV_ISSUE_ENVIRONMENT_LATTICE);
  check_refused(with(good, part + 4, 2u), FVV_ISSUE_ENVIRONMENT_PART);
  check_refused(with(good, part + 48 + 4, 0u), FVV_ISSUE_ENVIRONMENT_PART); // has no texture coordinates
  check_refused(with(good, part + 24, nan), FVV_ISSUE_ENVIRONMENT_PART);
  for (const double bad : {nan, 0.0, -1.0, inf})
    check_refused(with(good, part + 40, bad), FVV_ISSUE_ENVIRONMENT_PART);
  check_refused(with(good, data, uint8_t(FVV_MESH_DELTA)), FVV_ISSUE_ENVIRONMENT_PART);
  check_refused(with(good, data, uint8_t(99)), FVV_ISSUE_MESH_PROFILE, FVV_ERROR_UNSUPPORTED);
  for (const size_t size : {picture + 4, picture + 8, picture + 20, picture + 24})
    check_refused(with(good, size, 4u), FVV_ISSUE_ENVIRONMENT_PICTURE);
  check_refused(with(good, picture, uint8_t(1)), FVV_ISSUE_ENVIRONMENT_PICTURE);
  check_refused(with(good, picture + 16, uint8_t(0)), FVV_ISSUE_ENVIRONMENT_PICTURE);
  check_refused(with(good, picture, uint8_t(2)), FVV_ISSUE_ENVIRONMENT_CODEC, FVV_ERROR_UNSUPPORTED);
  check_refused(with(good, good.size() - 1, uint8_t(0)), FVV_ISSUE_ENVIRONMENT_PICTURE); // IEND
}

TEST_CASE("each rule of lights has a faulty light") {
  const Bytes good = Environment().payload();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const size_t sun = light, point = light + 112, spot = light + 224;
  check_refused(with(good, sun, uint8_t(3)), FVV_ISSUE_ENVIRONMENT_LIGHT);
  check_refused(with(good, sun + 8, 1.0), FVV_ISSUE_ENVIRONMENT_LIGHT); // a sun has no place
  check_refused(with(good, sun + 40, -0.61), FVV_ISSUE_ENVIRONMENT_LIGHT);
  check_refused(with(good, sun + 40, nan), FVV_ISSUE_ENVIRONMENT_LIGHT);
  check_refused(with(good, sun + 88, 1.0), FVV_ISSUE_ENVIRONMENT_LIGHT);
  check_refused(with(good, point + 32, 1.0), FVV_ISSUE_ENVIRONMENT_LIGHT);
  check_refused(with(good, point + 16, nan), FVV_ISSUE_ENVIRONMENT_LIGHT);
  for (const double bad : {nan, -0.1, 1.1})
    check_refused(with(good, point + 64, bad), FVV_ISSUE_ENVIRONMENT_LIGHT);
  for (const double bad : {nan, -1.0})
    check_refused(with(good, point + 80, bad), FVV_ISSUE_ENVIRONMENT_LIGHT);
  for (const double bad : {nan, -1.0})
    check_refused(with(good, point + 88, bad), FVV_ISSUE_ENVIRONMENT_LIGHT);
  check_refused(with(good, point + 96, 0.1), FVV_ISSUE_ENVIRONMENT_LIGHT);
  for (const double bad : {nan, -0.1, 0.75})
    check_refused(with(good, spot + 96, bad), FVV_ISSUE_ENVIRONMENT_LIGHT);
  for (const double bad : {nan, 0.25, 1.58})
    check_refused(with(good, spot + 104, bad), FVV_ISSUE_ENVIRONMENT_LIGHT);
  CHECK(Decoded(with(good, sun + 40, -0.60005)).status == FVV_OK);
}

TEST_CASE("a changed byte of an environment is refused or harmless") {
  const Bytes good = Environment().payload();
  size_t decoded_count = 0;
  for (size_t at = 0; at < good.size(); at++)
    for (const int change : {1, 0x80, 0xff}) {
      Bytes bad = good;
      bad[at] = uint8_t(bad[at] ^ change);
      const Decoded decoded(bad);
      if (decoded.status != FVV_OK) {
        REQUIRE(decoded.diagnostic.issue != 0);
        continue;
      }
      decoded_count++;
      for (size_t part_number = 0; part_number < decoded.environment.part_count; part_number++) {
        fvv_mesh mesh;
        fvv_diagnostic diagnostic;
        const fvv_status status =
            fvv_environment_mesh(&decoded.environment, part_number, nullptr, nullptr, &mesh, &diagnostic);
        REQUIRE((status == FVV_OK || diagnostic.issue != 0));
        fvv_mesh_free(&mesh);
      }
    }
  CHECK(decoded_count > good.size() / 2); // numbers of any value, and what only decoding shows
}

TEST_CASE("limits of environments hold before memory is allocated") {
  const Bytes payload = Environment().payload();
  const auto refused = [&](auto member, auto value) {
    fvv_limits limits;
    fvv_limits_default(&limits);
    limits.*member = value;
    const Decoded decoded(payload, &limits);
    return decoded.status == FVV_ERROR_LIMIT && decoded.diagnostic.issue == FVV_ISSUE_LIMIT;
  };
  CHECK(refused(&fvv_limits::max_environment, 2u));
  CHECK_FALSE(refused(&fvv_limits::max_environment, 3u));
  CHECK(refused(&fvv_limits::max_vertices, 7u)); // of both parts
  CHECK(refused(&fvv_limits::max_faces, 3u));
  CHECK_FALSE(refused(&fvv_limits::max_vertices, 8u));
  CHECK(refused(&fvv_limits::max_dimension, 31u));
  CHECK_FALSE(refused(&fvv_limits::max_dimension, 32u));
}

TEST_CASE("limits of pixels count all pictures of an environment") {
  Environment environment;
  environment.pictures.push_back({FVV_PICTURE_PNG, 32, 16, nullptr, 0});
  environment.files.push_back(png_file(32, 16));
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_dimension = 32;
  CHECK(Decoded(environment.payload(), &limits).status == FVV_ERROR_LIMIT); // 15 more than 32 * 32
  environment.pictures[1] = {FVV_PICTURE_PNG, 1, 0, nullptr, 0};
  Bytes out;
  fvv_diagnostic diagnostic;
  CHECK(environment.encode(out, &diagnostic) == FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == FVV_ISSUE_ENVIRONMENT_PICTURE);
}

TEST_CASE("an environment without memory leaks nothing") {
  struct Memory {
    int left, live = 0;
    static void *resize(void *user, void *pointer, size_t old_size, size_t new_size) {
      auto *self = static_cast<Memory *>(user);
      if (new_size && self->left-- <= 0) return nullptr;
      self->live += int(new_size) - int(old_size);
      if (new_size) return std::realloc(pointer, new_size);
      std::free(pointer);
      return nullptr;
    }
  };
  const Bytes payload = Environment().payload();
  for (int n = 0; n < 4; n++) {
    Memory memory = {n};
    const fvv_allocator allocator = {Memory::resize, &memory};
    { CHECK(Decoded(payload, nullptr, &allocator).status == (n < 3 ? FVV_ERROR_MEMORY : FVV_OK)); }
    CHECK(memory.live == 0);
  }
}

TEST_CASE("codec and size of a picture file are read") {
  for (const Bytes &file : {jpeg_file(32, 16), png_file(32, 16)}) {
    fvv_environment_picture picture = {99, 0, 0, file.data(), file.size()};
    REQUIRE(fvv_environment_picture_inspect(&picture, nullptr) == FVV_OK);
    CHECK(picture.codec == (file[0] == 0xff ? FVV_PICTURE_JPEG : FVV_PICTURE_PNG));
    CHECK(picture.width == 32);
    CHECK(picture.height == 16);
    for (size_t n = 0; n < file.size(); n++) {
      const Bytes part_of(file.begin(), file.begin() + std::ptrdiff_t(n));
      fvv_environment_picture cut = {0, 0, 0, part_of.data(), part_of.size()};
      fvv_diagnostic diagnostic;
      CHECK(fvv_environment_picture_inspect(&cut, &diagnostic) == FVV_ERROR_INPUT);
      CHECK(diagnostic.issue == FVV_ISSUE_ENVIRONMENT_PICTURE);
    }
  }
}

TEST_CASE("an environment that readers with default limits refuse is not encoded") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  Environment environment;
  environment.lights.resize(limits.max_environment, environment.lights[0]);
  Bytes payload;
  fvv_diagnostic d = {};
  CHECK(environment.encode(payload, &d) == FVV_OK);
  CHECK(Decoded(payload).status == FVV_OK);
  environment.lights.push_back(environment.lights[0]);
  CHECK(environment.encode(payload, &d) == FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
  CHECK(payload.empty());
}
