// Delta frames: what comes back, how large it is, and what a partial frame is good for.
#include "fvv_catch.h"

#include <cstring>

#include "delta_shapes.h"
#include "memory.h"

TEST_CASE("delta frames come back within the error, equal in encoder and decoder") {
  for (const uint32_t error : {0u, 1u, 2u, 7u}) {
    const auto key = key_of(torus(60, 40));
    Sequence encoder(*key), decoder(*key);
    for (int t = 1; t <= 12; t++) {
      const auto wanted = moved(*key, t, 2);
      const auto payload = encoder.encode(wanted, error);
      REQUIRE(decoder.decode(payload) == FVV_OK);
      REQUIRE(decoder.positions() == encoder.positions());
      CHECK(distance(decoder.positions(), wanted) <= int32_t(error));
      CHECK(fvv_mesh_sequence_frame(decoder.handle) == uint32_t(t));
    }
    const fvv_mesh *mesh = fvv_mesh_sequence_mesh(decoder.handle);
    CHECK(!memcmp(mesh->faces, key->faces, 12 * size_t(key->face_count)));
    CHECK(mesh->texture == nullptr);
  }
}

TEST_CASE("smooth motion takes a small part of a key frame") {
  // 0.5 mm steps, error 2: a quantiser of 2 mm.
  const auto key = key_of(torus(120, 80), 0.0005);
  Sequence encoder(*key);
  size_t bytes = 0;
  for (int t = 1; t <= 10; t++) bytes += encoder.encode(moved(*key, t), 2).size();
  const double bits = 8.0 * double(bytes) / 10 / key->vertex_count;
  const double of_key =
      8.0 * double(encoded(*canonical(torus(120, 80), 0.0005), FVV_MESH_DRACO, 7).size()) / key->vertex_count;
  INFO(bits << " bits a vertex, key " << of_key);
  CHECK(bits < 2.6);
  CHECK(bits < of_key / 5);
}

TEST_CASE("a mesh that stands still takes a header") {
  const auto key = key_of(sphere(60, 40));
  Sequence encoder(*key), decoder(*key);
  const std::vector<int32_t> still(key->positions, key->positions + 3 * size_t(key->vertex_count));
  for (int t = 1; t <= 3; t++) {
    const auto payload = encoder.encode(still, 0);
    CHECK(payload.size() == 16 + 2 + 2 * fvv_mesh_sequence_level_count(encoder.handle));
    REQUIRE(decoder.decode(payload) == FVV_OK);
    CHECK(decoder.positions() == still);
  }
  // Skipped levels teach the model nothing on either side.
  const auto payload = encoder.encode(moved(*key, 1, 3), 1);
  REQUIRE(decoder.decode(payload) == FVV_OK);
  CHECK(decoder.positions() == encoder.positions());
}

TEST_CASE("500 frames do not drift") {
  const auto key = key_of(torus(30, 20));
  Sequence encoder(*key), decoder(*key);
  int32_t worst = 0;
  for (int t = 1; t <= 500; t++) {
    const auto wanted = moved(*key, t % 90, 1);
    REQUIRE(decoder.decode(encoder.encode(wanted, 2)) == FVV_OK);
    worst = std::max(worst, distance(decoder.positions(), wanted));
  }
  CHECK(worst == 2);
}

TEST_CASE("vertices of a seam move together and cost nothing") {
  const auto key = key_of(charts(24), 0.0005);
  REQUIRE(key->texture);
  Sequence encoder(*key), decoder(*key);
  const uint32_t levels = fvv_mesh_sequence_level_count(encoder.handle);
  // A cube of n squares a side has 6 n^2 + 2 points; the rest are twins.
  CHECK(fvv_mesh_sequence_level_size(encoder.handle, levels - 1) == key->vertex_count - (6 * 24 * 24 + 2));
  for (int t = 1; t <= 5; t++) {
    const auto wanted = moved(*key, t);
    const auto payload = encoder.encode(wanted, 0);
    CHECK(header_of(payload).levels.back()[1] == 0);
    REQUIRE(decoder.decode(payload) == FVV_OK);
    CHECK(decoder.positions() == wanted);
  }
  const fvv_mesh *mesh = fvv_mesh_sequence_mesh(decoder.handle);
  CHECK(mesh->texture_bits == key->texture_bits);
  CHECK(!memcmp(mesh->texture, key->texture, 8 * size_t(key->vertex_count)));
}

TEST_CASE("levels partition the vertices, each larger than all before it") {
  for (const auto &key : {key_of(torus(120, 80)), key_of(sphere(40, 30)), key_of(tetrahedron()),
                          key_of(grid(40)), key_of(charts(8))}) {
    Sequence sequence(*key);
    uint32_t sum = 0;
    const uint32_t levels = fvv_mesh_sequence_level_count(sequence.handle);
    for (uint32_t k = 0; k < levels; k++) {
      const uint32_t size = fvv_mesh_sequence_level_size(sequence.handle, k);
      CHECK(size > 0);
      if (k && !key->texture) CHECK(size > sum);
      sum += size;
    }
    CHECK(sum == key->vertex_count);
    CHECK(fvv_mesh_sequence_level_size(sequence.handle, levels) == 0);
    // What no pass took, and two passes at most.
    if (!key->texture) CHECK(fvv_mesh_sequence_level_size(sequence.handle, 0) < 80);
  }
}

TEST_CASE("a decoder of the first levels alone follows, coarser, and stays exact in them") {
  const auto key = key_of(torus(120, 80), 0.0005);
  Sequence encoder(*key);
  const uint32_t levels = fvv_mesh_sequence_level_count(encoder.handle);
  REQUIRE(levels >= 4);
  std::vector<std::vector<uint8_t>> payloads;
  std::vector<std::vector<int32_t>> frames;
  for (int t = 1; t <= 8; t++) {
    payloads.push_back(encoder.encode(moved(*key, t), 2));
    frames.push_back(encoder.positions());
  }
  double former = 1e9;
  for (uint32_t use = 0; use <= levels; use++) {
    Sequence decoder(*key);
    for (const auto &payload : payloads) REQUIRE(decoder.decode(payload, use) == FVV_OK);
    CHECK(fvv_mesh_sequence_exact_levels(decoder.handle) == use);
    const auto got = decoder.positions();
    double sum = 0;
    size_t exact = 0;
    for (size_t i = 0; i < got.size(); i++) sum += std::abs(got[i] - frames.back()[i]);
    for (size_t v = 0; v < got.size() / 3; v++)
      exact += !memcmp(&got[3 * v], &frames.back()[3 * v], 3 * sizeof got[0]);
    uint32_t within = 0;
    for (uint32_t k = 0; k < use; k++) within += fvv_mesh_sequence_level_size(decoder.handle, k);
    CHECK(exact >= within);
    CHECK(sum < former);
    former = sum;
  }
  CHECK(former == 0);
}

TEST_CASE("what is not decoded is not rounded to the lattice in each frame") {
  const auto key = key_of(torus(120, 80), 0.002);
  Sequence encoder(*key);
  const uint32_t levels = fvv_mesh_sequence_level_count(encoder.handle);
  Sequence decoder(*key);
  double mean = 0;
  for (int t = 1; t <= 60; t++) {
    const auto wanted = moved(*key, t % 2 ? t : t / 2);
    REQUIRE(decoder.decode(encoder.encode(wanted, 0), levels - 1) == FVV_OK);
    const auto got = decoder.positions();
    mean = 0;
    for (size_t i = 0; i < got.size(); i++) mean += std::abs(got[i] - wanted[i]) / double(got.size());
  }
  INFO(mean);
  CHECK(mean < 1);
}

TEST_CASE("a frame of fewer levels is no reference for more") {
  const auto key = key_of(torus(60, 40));
  Sequence encoder(*key), decoder(*key);
  const auto first = encoder.encode(moved(*key, 1), 1), second = encoder.encode(moved(*key, 2), 1);
  REQUIRE(decoder.decode(first, 1) == FVV_OK);
  fvv_diagnostic diagnostic = {};
  CHECK(decoder.decode(second, 2, &diagnostic) == FVV_ERROR_STATE);
  CHECK(decoder.decode(second, UINT32_MAX, &diagnostic) == FVV_ERROR_STATE);
  CHECK(decoder.decode(second, 1, &diagnostic) == FVV_OK);
  fvv_bytes payload = {};
  CHECK(fvv_mesh_sequence_encode(decoder.handle, moved(*key, 3).data(), nullptr, &payload, &diagnostic) ==
        FVV_ERROR_STATE);
  fvv_bytes_free(&payload);
}

TEST_CASE("motion to the edge of the lattice and back is exact") {
  Shape far = torus(30, 20);
  const auto key = key_of(far, 0.001);
  Sequence encoder(*key), decoder(*key);
  for (const int32_t shift : {FVV_LATTICE_MAX - 3000, -(FVV_LATTICE_MAX - 3000), 0}) {
    std::vector<int32_t> wanted(key->positions, key->positions + 3 * size_t(key->vertex_count));
    for (int32_t &x : wanted) x += shift;
    for (size_t i = 0; i < 300; i++) wanted[i] = i % 2 ? FVV_LATTICE_MAX : -FVV_LATTICE_MAX;
    REQUIRE(decoder.decode(encoder.encode(wanted, 0)) == FVV_OK);
    CHECK(decoder.positions() == wanted);
    REQUIRE(decoder.decode(encoder.encode(wanted, 1000)) == FVV_OK);
    CHECK(decoder.positions() == encoder.positions());
  }
}

TEST_CASE("what an encoder cannot take leaves the sequence as it was") {
  const auto key = key_of(torus(30, 20));
  Sequence encoder(*key), decoder(*key);
  auto outside = moved(*key, 1);
  outside[7] = FVV_LATTICE_MAX + 1;
  fvv_bytes payload = {};
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_mesh_sequence_encode(encoder.handle, outside.data(), nullptr, &payload, &diagnostic) ==
        FVV_ERROR_INPUT);
  CHECK(std::string(diagnostic.message) == "vertex 2: y index 268435457 is outside +-2^28");
  fvv_mesh_delta_options options;
  fvv_mesh_delta_options_default(&options);
  options.max_error = 32768;
  CHECK(fvv_mesh_sequence_encode(encoder.handle, outside.data(), &options, &payload, &diagnostic) ==
        FVV_ERROR_ARGUMENT);
  fvv_bytes_free(&payload);
  REQUIRE(decoder.decode(encoder.encode(moved(*key, 1), 1)) == FVV_OK);
  CHECK(decoder.positions() == encoder.positions());
}

TEST_CASE("a sequence without memory is an error and leaks nothing") {
  const auto key = key_of(torus(20, 12));
  const fvv_allocator allocator = memory::allocator();
  const auto wanted = moved(*key, 1);
  const size_t before = memory::state.live;
  bool done = false;
  for (int64_t n = 0; !done; n++) {
    fvv_mesh_sequence *sequence = nullptr;
    fvv_bytes payload = {};
    fvv_diagnostic diagnostic = {};
    payload.allocator = allocator;
    memory::reset(n);
    fvv_status status = fvv_mesh_sequence_open(key.get(), &allocator, &sequence, &diagnostic);
    CHECK((status == FVV_OK) == (sequence != nullptr));
    if (status == FVV_OK)
      status = fvv_mesh_sequence_encode(sequence, wanted.data(), nullptr, &payload, &diagnostic);
    memory::reset();
    done = status == FVV_OK;
    if (!done) CHECK(status == FVV_ERROR_MEMORY);
    fvv_bytes_free(&payload);
    fvv_mesh_sequence_close(sequence);
    REQUIRE(memory::state.live == before);
    REQUIRE(n < 1000);
  }
}

TEST_CASE("delta payloads are the same bytes on every machine") {
  // Positions without floating point; the CRCs were taken when the format was made.
  const auto key = key_of(grid(24, 0), 0.001);
  Sequence encoder(*key);
  uint32_t crc = 0;
  for (int t = 1; t <= 4; t++) {
    std::vector<int32_t> wanted;
    for (uint32_t v = 0; v < key->vertex_count; v++) {
      const int32_t *p = key->positions + 3 * size_t(v);
      wanted.push_back(p[0] + t * (p[1] / 16));
      wanted.push_back(p[1] - t * (p[0] / 16));
      wanted.push_back(p[2] + (p[0] * p[1] / 500 * t) % 23);
    }
    const auto payload = encoder.encode(wanted, 1);
    crc = fvv_crc32c(crc, payload.data(), payload.size());
  }
  CHECK(crc == 0x4959e8d8u);
}
