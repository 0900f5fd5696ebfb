// The round trip: any camera alone, after other frames.
#include "visibility/scenes.h"

#include <algorithm>

namespace {

std::vector<Shape> shapes() {
  return {torus(40, 24, 0.2), sphere(30, 20),    grid(20),          fin(),
          bow_tie(),          ragged(30, 20, 7), sponge(6, 0.4, 3), tetrahedron()};
}

States decoded(const Order &order, const fvv_mesh &mesh, const std::vector<uint8_t> &payload, size_t camera,
               const uint8_t *former = nullptr) {
  const Parsed parsed(payload);
  REQUIRE(parsed.status == FVV_OK);
  const fvv_visibility_stream &stream = parsed.streams[camera];
  // The camera's bytes alone, on a block of their own.
  const std::vector<uint8_t> bytes(payload.begin() + std::ptrdiff_t(stream.offset),
                                   payload.begin() + std::ptrdiff_t(stream.offset + stream.size));
  States out(mesh.vertex_count, 9);
  fvv_diagnostic d = {};
  REQUIRE(fvv_visibility_decode(order.order, &mesh, &parsed.header, bytes.data(), bytes.size(),
                                centres[camera].data(), former, out.data(), &d) == FVV_OK);
  return out;
}

} // namespace

TEST_CASE("what cameras see comes back, for surfaces of all kinds") {
  for (const Shape &shape : shapes()) {
    const auto mesh = canonical(shape);
    const Order order(*mesh);
    REQUIRE(order.status == FVV_OK);
    std::vector<States> states;
    const auto payload = payload_of(order, *mesh, 100, 0, &states);
    const Parsed parsed(payload);
    REQUIRE(parsed.streams.size() == centres.size());
    CHECK(parsed.header.vertex_count == mesh->vertex_count);
    CHECK(parsed.header.mesh_track == 1);
    // Backwards: no camera needs another.
    for (size_t c = centres.size(); c-- > 0;) {
      CHECK(parsed.streams[c].camera == 3 + 7 * c);
      const States wanted =
          states_of(*mesh, facing(*mesh, centres[c]), seen_beside(*mesh, 100 + 300 * int32_t(c)));
      CHECK(states[c] == wanted);
      CHECK(decoded(order, *mesh, payload, c) == wanted);
    }
    CHECK(payload_of(order, *mesh, 100) == payload);
  }
}

TEST_CASE("a frame after another uses its visibility as context") {
  const auto mesh = canonical(torus(80, 60, 0.2));
  const Order order(*mesh);
  std::vector<States> states, former;
  const auto key = payload_of(order, *mesh, 100, 0, &states);
  for (uint32_t number = 1; number < 4; number++) {
    former = states;
    const int32_t t = 100 + 10 * int32_t(number);
    const auto alone = payload_of(order, *mesh, t);
    const auto payload = payload_of(order, *mesh, t, number, &states);
    CHECK(payload.size() * 10 < alone.size() * 9);
    for (size_t c = 0; c < centres.size(); c++) {
      CHECK(decoded(order, *mesh, payload, c, former[c].data()) == states[c]);
      CHECK(decoded(order, *mesh, alone, c) == states[c]);
      // In place.
      States same = former[c];
      const Parsed parsed(payload);
      CHECK(fvv_visibility_decode(order.order, &*mesh, &parsed.header,
                                  payload.data() + parsed.streams[c].offset, parsed.streams[c].size,
                                  centres[c].data(), same.data(), same.data(), nullptr) == FVV_OK);
      CHECK(same == states[c]);
    }
  }
}

TEST_CASE("a camera that sees nothing takes no bytes, an outline few") {
  const auto mesh = canonical(torus(80, 60));
  const Order order(*mesh);
  const auto dark = payload_of(order, *mesh, -100000);
  const Parsed nothing(dark);
  for (size_t c = 0; c < centres.size(); c++) CHECK(nothing.streams[c].size == 0);
  CHECK(dark.size() == 16 + 2 * centres.size());
  const States all = decoded(order, *mesh, dark, 0);
  CHECK(std::count(all.begin(), all.end(), FVV_VERTEX_SEEN) == 0);
  CHECK(std::count(all.begin(), all.end(), FVV_VERTEX_HIDDEN) > 1000);
  // One bit for each vertex and camera would be 1,800 bytes.
  CHECK(payload_of(order, *mesh, 100).size() < 500);
}

TEST_CASE("every vertex is coded once, next to one that is known where there is one") {
  const auto mesh = canonical(sponge(6, 0.4, 3));
  // Seen by chance: were a vertex left out or coded twice, the bits would not fit.
  States seen(mesh->vertex_count);
  uint32_t state = 7;
  for (uint8_t &s : seen) s = uint8_t(1 + ((state = state * 1664525 + 1013904223) >> 8) % 6);
  const Order order(*mesh);
  fvv_visibility_view view = {5, {9000, 500, 300}, seen.data(), nullptr, nullptr};
  const fvv_visibility_header header = header_of();
  Bytes payload;
  REQUIRE(fvv_visibility_encode(order.order, &*mesh, &header, &view, 1, &payload, nullptr) == FVV_OK);
  const Parsed parsed(payload.copy());
  States got(seen.size());
  REQUIRE(fvv_visibility_decode(order.order, &*mesh, &parsed.header, payload.data + parsed.streams[0].offset,
                                parsed.streams[0].size, centres[0].data(), nullptr, got.data(),
                                nullptr) == FVV_OK);
  CHECK(got == states_of(*mesh, facing(*mesh, centres[0]), seen));
}

TEST_CASE("cameras that do not rise are refused, as is a mesh of other counts") {
  const auto mesh = canonical(torus(10, 8)), other = canonical(torus(10, 9));
  const Order order(*mesh);
  const States seen(mesh->vertex_count, FVV_VERTEX_HIDDEN);
  fvv_visibility_view views[2] = {{5, {9000, 0, 0}, seen.data(), nullptr, nullptr},
                                  {5, {9000, 0, 0}, seen.data(), nullptr, nullptr}};
  const fvv_visibility_header header = header_of();
  Bytes payload;
  fvv_diagnostic d = {};
  CHECK(fvv_visibility_encode(order.order, &*mesh, &header, views, 2, &payload, &d) == FVV_ERROR_ARGUMENT);
  CHECK(d.issue == FVV_ISSUE_VISIBILITY_CAMERA);
  CHECK(fvv_visibility_encode(order.order, &*mesh, &header, views, 0, &payload, &d) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_visibility_encode(order.order, &*other, &header, views, 1, &payload, &d) == FVV_ERROR_ARGUMENT);
}

TEST_CASE("more cameras than readers with default limits take are not encoded") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  const auto mesh = canonical(torus(10, 8));
  const Order order(*mesh);
  const States seen(mesh->vertex_count, FVV_VERTEX_HIDDEN);
  std::vector<fvv_visibility_view> views;
  for (uint16_t id = 0; id <= limits.max_cameras; id++)
    views.push_back({id, {9000, 0, 0}, seen.data(), nullptr, nullptr});
  const fvv_visibility_header header = header_of();
  Bytes payload;
  fvv_diagnostic d = {};
  CHECK(fvv_visibility_encode(order.order, &*mesh, &header, views.data(), views.size() - 1, &payload, &d) ==
        FVV_OK);
  CHECK(fvv_visibility_encode(order.order, &*mesh, &header, views.data(), views.size(), &payload, &d) ==
        FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
}
