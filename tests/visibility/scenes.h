// Meshes, camera centres and states that the tests of visibility share.
#pragma once

#include "fvv/visibility.h"
#include "fvv_catch.h"
#include "mesh/shapes.h"

#include <array>
#include <cstdlib>
#include <vector>

using Centre = std::array<int32_t, 3>;
using States = std::vector<uint8_t>;

struct Order {
  fvv_visibility_order *order = nullptr;
  explicit Order(const fvv_mesh &mesh, const fvv_allocator *allocator = nullptr) {
    fvv_diagnostic d = {};
    status = fvv_visibility_order_open(&mesh, allocator, &order, &d);
  }
  Order(const Order &) = delete;
  ~Order() { fvv_visibility_order_close(order); }
  fvv_status status;
};

inline States facing(const fvv_mesh &mesh, const Centre &centre,
                     uint8_t threshold = FVV_VISIBILITY_THRESHOLD) {
  States out(mesh.vertex_count);
  fvv_visibility_facing(&mesh, centre.data(), threshold, out.data());
  return out;
}

// Seen is what lies on one side of a plane that moves with t: an outline across the surface, as shadows have.
// Weights are of all levels on both sides.
inline States seen_beside(const fvv_mesh &mesh, int32_t t) {
  States out(mesh.vertex_count);
  for (size_t v = 0; v < out.size(); v++) {
    const int32_t *p = mesh.lattice + 3 * v;
    const int32_t beyond = p[0] + 2 * p[1] + p[2] - t;
    out[v] = uint8_t((beyond < 0 ? FVV_VERTEX_SEEN : FVV_VERTEX_HIDDEN) + 2 * (std::abs(beyond) / 50 % 3));
  }
  return out;
}

// What decoders get. A weight without one of the other side in its faces is all or nothing.
inline States states_of(const fvv_mesh &mesh, const States &facing, const States &seen) {
  States out(facing.size());
  for (size_t v = 0; v < out.size(); v++)
    if (facing[v]) out[v] = 2 - seen[v] % 2;
  const States sides(out);
  for (size_t corner = 0; corner < 3 * size_t(mesh.face_count); corner++)
    for (size_t other = corner / 3 * 3; other < corner / 3 * 3 + 3; other++) {
      const uint32_t v = mesh.faces[corner], w = mesh.faces[other];
      if (sides[v] && sides[w] && sides[v] != sides[w]) out[v] = seen[v];
    }
  return out;
}

inline fvv_visibility_header header_of(uint32_t number = 0) {
  return {FVV_VISIBILITY_THRESHOLD, 1, 0, number, 0};
}

// Around the shapes, which are some metres large at 1 mm a step.
inline const std::vector<Centre> centres = {{9000, 500, 300}, {-4000, 6000, 2000}, {100, -200, 12000}};

// The payload of what the cameras 3, 10, 17 ... see beside planes that move with t.
inline std::vector<uint8_t> payload_of(const Order &order, const fvv_mesh &mesh, int32_t t,
                                       uint32_t number = 0, std::vector<States> *states = nullptr) {
  std::vector<States> seen, former(centres.size());
  std::vector<fvv_visibility_view> views;
  for (size_t c = 0; c < centres.size(); c++) seen.push_back(seen_beside(mesh, t + 300 * int32_t(c)));
  for (size_t c = 0; c < centres.size(); c++) {
    const Centre &at = centres[c];
    if (states && number) former[c] = (*states)[c];
    if (states) states->resize(centres.size());
    if (states) (*states)[c].resize(mesh.vertex_count);
    views.push_back({uint16_t(3 + 7 * c),
                     {at[0], at[1], at[2]},
                     seen[c].data(),
                     former[c].empty() ? nullptr : former[c].data(),
                     states ? (*states)[c].data() : nullptr});
  }
  Bytes payload;
  fvv_diagnostic d = {};
  const fvv_visibility_header header = header_of(number);
  REQUIRE(fvv_visibility_encode(order.order, &mesh, &header, views.data(), views.size(), &payload, &d) ==
          FVV_OK);
  return payload.copy();
}

struct Parsed {
  fvv_visibility_header header = {};
  std::vector<fvv_visibility_stream> streams;
  fvv_diagnostic diagnostic = {};
  fvv_status status;
  explicit Parsed(const std::vector<uint8_t> &payload, const fvv_limits *limits = nullptr) : streams(64) {
    // A block that is exactly as long as the payload.
    const std::vector<uint8_t> exact(payload);
    status = fvv_visibility_peek(exact.data(), exact.size(), limits, &header, streams.data(), streams.size(),
                                 &diagnostic);
    if (status == FVV_OK) streams.resize(header.camera_count);
  }
};
