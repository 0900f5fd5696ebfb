// Hostile bytes, each rule of a payload by its number, and failing memory.
#include "mesh/memory.h"
#include "visibility/scenes.h"

namespace {

fvv_status decode_all(const Order &order, const fvv_mesh &mesh, const std::vector<uint8_t> &payload,
                      fvv_diagnostic *diagnostic = nullptr) {
  const Parsed parsed(payload);
  if (parsed.status != FVV_OK) {
    if (diagnostic) *diagnostic = parsed.diagnostic;
    return parsed.status;
  }
  States states(mesh.vertex_count), former(states.size(), 77);
  fvv_status status = FVV_OK;
  for (size_t c = 0; c < parsed.streams.size() && status == FVV_OK; c++) {
    const fvv_visibility_stream &s = parsed.streams[c];
    REQUIRE(s.offset + s.size <= payload.size());
    const std::vector<uint8_t> bytes(payload.begin() + std::ptrdiff_t(s.offset),
                                     payload.begin() + std::ptrdiff_t(s.offset + s.size));
    status =
        fvv_visibility_decode(order.order, &mesh, &parsed.header, bytes.data(), bytes.size(),
                              centres[c % centres.size()].data(), former.data(), states.data(), diagnostic);
  }
  return status;
}

} // namespace

TEST_CASE("6001 to 6007: each rule of a visibility payload has its number") {
  const auto mesh = canonical(torus(20, 12));
  const Order order(*mesh);
  const auto good = payload_of(order, *mesh, 100);
  REQUIRE(decode_all(order, *mesh, good) == FVV_OK);
  const auto issue = [&](std::vector<uint8_t> bad) {
    fvv_diagnostic d = {};
    CHECK(decode_all(order, *mesh, bad, &d) == FVV_ERROR_INVALID);
    return d.issue;
  };
  const auto with = [&](size_t at, uint8_t value) {
    auto bad = good;
    bad[at] = value;
    return bad;
  };
  CHECK(issue({good.begin(), good.begin() + 15}) == FVV_ISSUE_VISIBILITY_PAYLOAD);
  CHECK(issue({}) == FVV_ISSUE_VISIBILITY_PAYLOAD);
  CHECK(issue(with(0, 1)) == FVV_ISSUE_VISIBILITY_PAYLOAD);
  CHECK(issue(with(18, 0)) == FVV_ISSUE_VISIBILITY_CAMERA);
  // The second camera beyond 65534, in three bytes, and as much off the end.
  std::vector<uint8_t> far(good.data(), good.data() + 18);
  for (const uint8_t byte : {0xFC, 0xFF, 0x03}) far.push_back(byte);
  far.insert(far.end(), good.data() + 19, good.data() + good.size());
  CHECK(issue(far) == FVV_ISSUE_VISIBILITY_CAMERA);
  CHECK(issue(with(12, 0)) == FVV_ISSUE_VISIBILITY_SIZE);
  CHECK(issue(with(15, 255)) == FVV_ISSUE_VISIBILITY_SIZE);
  auto longer = good;
  longer.push_back(0);
  CHECK(decode_all(order, *mesh, longer) == FVV_OK); // of a later version
  CHECK(issue({good.begin(), good.end() - 1}) == FVV_ISSUE_VISIBILITY_SIZE);
  CHECK(issue(with(4, uint8_t(good[4] + 1))) == FVV_ISSUE_VISIBILITY_MESH);
  // One byte of the first camera's stream is given to the second.
  REQUIRE(good[17] < 127);
  auto moved = good;
  moved[17]--;
  moved[19]++;
  CHECK(issue(moved) == FVV_ISSUE_VISIBILITY_STREAM);
}

TEST_CASE("counts beyond the limits are refused, and a table for which there is no room") {
  const auto mesh = canonical(torus(20, 12));
  const Order order(*mesh);
  const auto payload = payload_of(order, *mesh, 100);
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_cameras = uint32_t(centres.size());
  limits.max_vertices = mesh->vertex_count;
  CHECK(Parsed(payload, &limits).status == FVV_OK);
  limits.max_cameras--;
  CHECK(Parsed(payload, &limits).status == FVV_ERROR_LIMIT);
  limits.max_cameras++;
  limits.max_vertices--;
  CHECK(Parsed(payload, &limits).diagnostic.issue == FVV_ISSUE_LIMIT);
  fvv_visibility_header header;
  fvv_visibility_stream one;
  CHECK(fvv_visibility_peek(payload.data(), payload.size(), nullptr, &header, &one, 1, nullptr) ==
        FVV_ERROR_BUFFER_TOO_SMALL);
  CHECK(header.camera_count == centres.size());
  CHECK(fvv_visibility_peek(payload.data(), payload.size(), nullptr, &header, nullptr, 0, nullptr) == FVV_OK);
}

TEST_CASE("no change of a payload reads or writes outside") {
  const auto mesh = canonical(torus(20, 12));
  const Order order(*mesh);
  // After a frame with invalid states, too.
  std::vector<States> states(centres.size(), States(mesh->vertex_count, 77));
  const auto good = payload_of(order, *mesh, 100, GENERATE(0u, 1u), &states);
  size_t refused = 0, all = 0;
  uint32_t state = 1;
  for (int round = 0; round < 3000; round++) {
    auto bad = good;
    const auto random = [&] { return (state = state * 1664525 + 1013904223) >> 8; };
    for (uint32_t n = random() % 3 + 1; n; n--) bad[random() % bad.size()] = uint8_t(random());
    if (round % 3 == 0) bad.resize(random() % bad.size());
    refused += decode_all(order, *mesh, bad) != FVV_OK;
    all++;
  }
  CHECK(refused > all / 2);
}

TEST_CASE("every allocation on the way to weights may fail") {
  const auto mesh = canonical(torus(20, 12));
  const fvv_allocator allocator = memory::allocator();
  const States seen = seen_beside(*mesh, 100);
  const fvv_visibility_view view = {1, {9000, 0, 0}, seen.data(), nullptr, nullptr};
  const fvv_visibility_header header = header_of();
  fvv_status status = FVV_ERROR_MEMORY;
  for (int64_t n = 0; status != FVV_OK; n++) {
    REQUIRE(n < 200);
    const size_t live = memory::state.live;
    fvv_bytes payload = {nullptr, 0, 0, allocator};
    fvv_visibility_order *order = nullptr;
    memory::reset(n);
    status = fvv_visibility_order_open(mesh.get(), &allocator, &order, nullptr);
    const bool consistent = (status == FVV_OK) == (order != nullptr);
    if (status == FVV_OK)
      status = fvv_visibility_encode(order, mesh.get(), &header, &view, 1, &payload, nullptr);
    fvv_bytes_free(&payload);
    fvv_visibility_order_close(order);
    memory::reset();
    CHECK(consistent);
    CHECK((status == FVV_OK || status == FVV_ERROR_MEMORY));
    CHECK(memory::state.live == live);
  }
}
