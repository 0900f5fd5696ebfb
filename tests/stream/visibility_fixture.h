// A mesh with visibility, for streams.
#pragma once

#include "mesh_of.h"
#include "stream_fixture.h"

// A wavy sheet that is folded over itself, a fan about one vertex, and three faces on one edge.
struct Sheet {
  std::vector<int32_t> positions;
  std::vector<uint32_t> faces;
  static constexpr int32_t side = 14;
  explicit Sheet(int group, int t) {
    for (int32_t v = 0; v < side * side; v++) {
      const int32_t x = v % side, y = v / side;
      positions.insert(positions.end(),
                       {20 * x + 3 * t, 25 * y - 100, group + (x * x * 3 + 17 * y * (x + t)) % 60});
    }
    for (uint32_t y = 0; y + 1 < side; y++)
      for (uint32_t x = 0; x + 1 < side; x++) {
        const uint32_t a = y * side + x;
        for (const uint32_t i : {a, a + 1, a + side, a + 1, a + side + 1, a + side}) faces.push_back(i);
      }
    const uint32_t hub = uint32_t(positions.size() / 3);
    positions.insert(positions.end(), {-200, 0, 30});
    for (int32_t i = 0; i < 9; i++) positions.insert(positions.end(), {-300 + 31 * i, 40 * i % 170, 4 * i});
    for (uint32_t i = 0; i < 8; i++) faces.insert(faces.end(), {hub, hub + i + 1, hub + i + 2});
    faces.insert(faces.end(), {0, side, hub, side, 0, hub + 1});
  }
  fvv_mesh mesh() { return mesh_of(positions, faces); }
};

// A pinhole that looks along z from the origin.
inline fvv_camera upright_camera(uint16_t id) {
  fvv_camera camera = {};
  camera.id = id;
  camera.width = 32;
  camera.height = 16;
  camera.fx = camera.fy = 20;
  camera.cx = 16;
  camera.cy = 8;
  camera.r_max = 2;
  for (const int i : {0, 4, 8}) camera.rotation[i] = 1;
  return camera;
}

// Beside a line, which moves with t; one element in eight is otherwise.
inline bool is_seen(const fvv_mesh &mesh, uint8_t domain, size_t element, size_t camera, int t) {
  const uint32_t vertex = domain == FVV_VISIBILITY_FACES ? mesh.faces[3 * element] : uint32_t(element);
  const int32_t *p = mesh.positions + 3 * size_t(vertex);
  const bool beside = p[0] + p[1] * int32_t(camera) > 90 + 5 * t;
  return beside != ((element * 2654435761u >> 7) % 8 == camera);
}

inline Bytes bytes_of(const fvv_bytes &bytes) {
  return {bytes.data, bytes.data + bytes.size};
}

// The payload of VISI.
inline Bytes encoded(const fvv_mesh &mesh, const fvv_visibility_header &header,
                     const std::vector<fvv_visibility_view> &views) {
  fvv_visibility_order *order = nullptr;
  fvv_bytes payload = {};
  REQUIRE(fvv_visibility_order_open(&mesh, header.domain, nullptr, &order, nullptr) == FVV_OK);
  REQUIRE(fvv_visibility_encode(order, &mesh, &header, views.data(), views.size(), &payload, nullptr) ==
          FVV_OK);
  const Bytes out = bytes_of(payload);
  fvv_visibility_order_close(order);
  fvv_bytes_free(&payload);
  return out;
}
