// Colours of vertices: what comes back, each rule by its number, hostile bytes and failing memory.
#include "fvv/colours.h"

#include "fvv_catch.h"
#include "mesh/memory.h"
#include "mesh/shapes.h"

#include <cmath>
#include <cstring>

namespace {

using Colours = std::vector<uint8_t>;

// Smooth over space, all three different.
Colours painted(const fvv_mesh &mesh) {
  Colours out;
  for (uint32_t v = 0; v < mesh.vertex_count; v++)
    for (int c = 0; c < 3; c++)
      out.push_back(uint8_t(128 + 100 * std::sin(mesh.lattice[3 * v + (c + 1) % 3] * (c + 2) / 600.0)));
  return out;
}

std::vector<uint8_t> payload_of(const fvv_mesh &mesh, const Colours &colours, uint32_t cell_size = 60,
                                uint8_t step = 4, const uint8_t *weights = nullptr) {
  const fvv_colours_header header = {1, step, uint8_t(2 * step), 0, cell_size, 0};
  Bytes payload;
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_colours_encode(&mesh, &header, colours.data(), weights, nullptr, &payload, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  return payload.copy();
}

// From a block on the heap that is exactly as long as the bytes.
fvv_status decode_colours(const std::vector<uint8_t> &payload, const fvv_mesh &mesh, Colours &colours,
                          fvv_diagnostic *diagnostic = nullptr, const fvv_allocator *allocator = nullptr) {
  const std::unique_ptr<uint8_t[]> block(new uint8_t[payload.size() + !payload.size()]);
  std::copy(payload.begin(), payload.end(), block.get());
  colours.resize(3 * size_t(mesh.vertex_count));
  return fvv_colours_decode(block.get(), payload.size(), &mesh, nullptr, allocator, colours.data(),
                            diagnostic);
}

double psnr(const Colours &a, const Colours &b) {
  double squares = 0;
  for (size_t i = 0; i < a.size(); i++) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return 10 * std::log10(255 * 255 * double(a.size()) / squares);
}

} // namespace

TEST_CASE("colours come back, better from smaller cells and finer steps") {
  const auto mesh = canonical(torus(60, 40));
  const Colours wanted = painted(*mesh);
  Colours found;
  double last = 0;
  size_t bytes = 0;
  for (const uint32_t size : {400u, 200u, 100u}) {
    const std::vector<uint8_t> payload = payload_of(*mesh, wanted, size);
    REQUIRE(decode_colours(payload, *mesh, found) == FVV_OK);
    CHECK(psnr(wanted, found) > last + 2);
    CHECK(payload.size() > bytes);
    last = psnr(wanted, found);
    bytes = payload.size();
  }
  CHECK(last > 33);
  CHECK(payload_of(*mesh, wanted, 100, 24).size() < bytes * 2 / 3);
  CHECK(payload_of(*mesh, wanted, 100) == payload_of(*mesh, wanted, 100));
}

TEST_CASE("one colour stays what it is, in a few bytes") {
  const auto mesh = canonical(torus(60, 40));
  const uint8_t colour[3] = {200, 96, 32};
  Colours wanted, found;
  for (uint32_t v = 0; v < mesh->vertex_count; v++) wanted.insert(wanted.end(), colour, colour + 3);
  const std::vector<uint8_t> payload = payload_of(*mesh, wanted, 40, 1);
  REQUIRE(decode_colours(payload, *mesh, found) == FVV_OK);
  for (size_t i = 0; i < found.size(); i++) CHECK(std::abs(int(found[i]) - int(wanted[i])) <= 2);
  fvv_colours_header header;
  REQUIRE(fvv_colours_peek(payload.data(), payload.size(), nullptr, &header, nullptr) == FVV_OK);
  CHECK(header.cell_count > 500);
  CHECK(payload.size() < 100);
}

TEST_CASE("what has no weight does not count beside what has") {
  const auto mesh = canonical(torus(60, 40));
  Colours wanted(3 * size_t(mesh->vertex_count), 60), weights(mesh->vertex_count, 255), found;
  for (uint32_t v = 0; v < mesh->vertex_count; v += 2) {
    weights[v] = 0;
    std::fill_n(&wanted[3 * size_t(v)], 3, uint8_t(250));
  }
  REQUIRE(decode_colours(payload_of(*mesh, wanted, 300, 1, weights.data()), *mesh, found) == FVV_OK);
  for (const uint8_t value : found) CHECK(std::abs(int(value) - 60) <= 2);
  // Where nothing else is there it counts.
  std::fill(weights.begin(), weights.end(), uint8_t(0));
  std::fill(wanted.begin(), wanted.end(), uint8_t(250));
  REQUIRE(decode_colours(payload_of(*mesh, wanted, 300, 1, weights.data()), *mesh, found) == FVV_OK);
  for (const uint8_t value : found) CHECK(std::abs(int(value) - 250) <= 2);
}

TEST_CASE("6201 to 6204: each rule of a payload of colours has its number") {
  const auto mesh = canonical(torus(20, 12));
  const auto good = payload_of(*mesh, painted(*mesh));
  Colours colours;
  REQUIRE(decode_colours(good, *mesh, colours) == FVV_OK);
  const auto issue = [&](const std::vector<uint8_t> &bad, fvv_status wanted = FVV_ERROR_INVALID) {
    fvv_diagnostic d = {};
    CHECK(decode_colours(bad, *mesh, colours, &d) == wanted);
    return d.issue;
  };
  const auto with = [&](size_t at, std::vector<uint8_t> values) {
    auto bad = good;
    std::copy(values.begin(), values.end(), bad.begin() + std::ptrdiff_t(at));
    return bad;
  };
  CHECK(issue({}) == FVV_ISSUE_COLOURS_PAYLOAD);
  CHECK(issue({good.begin(), good.begin() + 15}) == FVV_ISSUE_COLOURS_PAYLOAD);
  for (const size_t step : {0, 1})
    for (const uint8_t value : {0, 65, 255}) CHECK(issue(with(step, {value})) == FVV_ISSUE_COLOURS_PAYLOAD);
  CHECK(issue(with(8, {0, 0, 0, 0})) == FVV_ISSUE_COLOURS_PAYLOAD);
  CHECK(issue(with(8, {1, 0, 0, 1})) == FVV_ISSUE_COLOURS_PAYLOAD);
  CHECK(issue(with(4, {uint8_t(good[4] + 1)})) == FVV_ISSUE_COLOURS_MESH);
  CHECK(issue(with(4, {255, 255, 255, 127}), FVV_ERROR_LIMIT) == FVV_ISSUE_LIMIT);
  CHECK(issue(with(12, {uint8_t(good[12] + 1)})) == FVV_ISSUE_COLOURS_CELLS);
  CHECK(issue(with(12, {0, 0, 0, 0})) == FVV_ISSUE_COLOURS_CELLS);
  CHECK(issue(with(12, {1, 0, 1, 0})) == FVV_ISSUE_COLOURS_CELLS);
  CHECK(issue(with(8, {1, 0, 0, 0})) == FVV_ISSUE_COLOURS_CELLS); // too many cells on an axis
  auto other = good;
  other.push_back(0);
  CHECK(issue(other) == FVV_ISSUE_COLOURS_STREAM);
  CHECK(issue({good.begin(), good.end() - 1}) == FVV_ISSUE_COLOURS_STREAM);
  // All ones: the greatest magnitudes.
  other.assign(good.begin(), good.begin() + 16);
  other.insert(other.end(), 400, 0);
  CHECK(issue(other) == FVV_ISSUE_COLOURS_STREAM);
}

TEST_CASE("a mesh with too many cells is refused, larger ones do") {
  const auto mesh = canonical(torus(60, 40), 0.0001);
  const Colours colours = painted(*mesh);
  Bytes payload;
  fvv_diagnostic diagnostic = {};
  fvv_colours_header header = {1, 4, 4, 0, 1, 0};
  CHECK(fvv_colours_encode(mesh.get(), &header, colours.data(), nullptr, nullptr, &payload, &diagnostic) ==
        FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == FVV_ISSUE_COLOURS_CELLS);
  header.cell_size = 1000;
  CHECK(fvv_colours_encode(mesh.get(), &header, colours.data(), nullptr, nullptr, &payload, &diagnostic) ==
        FVV_OK);
  header.luma_step = 65;
  CHECK(fvv_colours_encode(mesh.get(), &header, colours.data(), nullptr, nullptr, &payload, &diagnostic) ==
        FVV_ERROR_ARGUMENT);
}

TEST_CASE("the ends of the lattice have colours") {
  const int32_t far = (1 << 28) - 1;
  std::vector<int32_t> positions = {-far, -far, -far, far, -far, far, 0, far, -1, -1, 0, far};
  std::vector<uint32_t> faces = {0, 1, 2, 1, 2, 3};
  fvv_mesh mesh = {};
  mesh.lattice = positions.data();
  mesh.faces = faces.data();
  mesh.vertex_count = 4;
  mesh.face_count = 2;
  const Colours wanted = {0, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0, 255};
  Colours found;
  REQUIRE(decode_colours(payload_of(mesh, wanted, 1 << 24, 1), mesh, found) == FVV_OK);
  for (size_t i = 0; i < found.size(); i++) CHECK(std::abs(int(found[i]) - int(wanted[i])) <= 3);
}

TEST_CASE("every prefix of colours fails, and no change of them reads or writes outside") {
  const auto mesh = canonical(torus(20, 12));
  const auto good = payload_of(*mesh, painted(*mesh));
  Colours colours;
  for (size_t size = 0; size < good.size(); size++)
    CHECK(decode_colours({good.begin(), good.begin() + std::ptrdiff_t(size)}, *mesh, colours) != FVV_OK);
  size_t refused = 0;
  uint32_t state = 1;
  for (int round = 0; round < 3000; round++) {
    auto bad = good;
    const auto random = [&] { return (state = state * 1664525 + 1013904223) >> 8; };
    for (uint32_t n = random() % 3 + 1; n; n--) bad[random() % bad.size()] = uint8_t(random());
    refused += decode_colours(bad, *mesh, colours) != FVV_OK;
  }
  CHECK(refused > 1500);
}

TEST_CASE("every allocation on the way to colours may fail") {
  const auto mesh = canonical(torus(20, 12));
  const Colours wanted = painted(*mesh);
  const fvv_allocator allocator = memory::allocator();
  const fvv_colours_header header = {1, 4, 4, 0, 60, 0};
  Colours found(wanted.size());
  fvv_status status = FVV_ERROR_MEMORY;
  for (int64_t n = 0; status != FVV_OK; n++) {
    REQUIRE(n < 100);
    const size_t live = memory::state.live;
    fvv_bytes payload = {nullptr, 0, 0, allocator};
    memory::reset(n);
    status = fvv_colours_encode(mesh.get(), &header, wanted.data(), nullptr, &allocator, &payload, nullptr);
    if (status == FVV_OK)
      status = fvv_colours_decode(payload.data, payload.size, mesh.get(), nullptr, &allocator, found.data(),
                                  nullptr);
    fvv_bytes_free(&payload);
    memory::reset();
    CHECK((status == FVV_OK || status == FVV_ERROR_MEMORY));
    CHECK(memory::state.live == live);
  }
}
