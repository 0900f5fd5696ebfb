// Visibility chunks of a hostile mesh, one after the other, so that each has the states of the one before.
#include "meshes.h"

#include "fvv/visibility.h"

#include <algorithm>

FVV_FUZZ_TARGET(visibility, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const fuzz::Mesh mesh(input.part());
  if (!mesh.there) return;
  fvv_visibility_order *order = nullptr;
  const fvv_status opened = fvv_visibility_order_open(&mesh.mesh, nullptr, &order, nullptr);
  fuzz::expect_status(opened);
  if (opened != FVV_OK) return;
  const size_t vertices = mesh.mesh.vertex_count;
  const int32_t centre[3] = {input.number<int16_t>(), input.number<int16_t>(), -input.number<int16_t>()};
  std::vector<uint8_t> former, states(vertices), weights(vertices);
  for (int chunk = 0; chunk < 4 && input.left(); chunk++) {
    const fuzz::Bytes payload = input.part();
    fvv_visibility_header header;
    std::vector<fvv_visibility_stream> streams(64);
    const fvv_status peeked = fvv_visibility_peek(payload.data(), payload.size(), nullptr, &header,
                                                  streams.data(), streams.size(), nullptr);
    fuzz::expect_status(peeked);
    if (peeked != FVV_OK || header.vertex_count != vertices) break;
    for (size_t i = 0; i < std::min<size_t>(header.camera_count, 4); i++) {
      const fuzz::Bytes bytes(payload.begin() + ptrdiff_t(streams[i].offset),
                              payload.begin() + ptrdiff_t(streams[i].offset + streams[i].size));
      const bool has_former = header.number && !former.empty();
      if (header.number && !has_former) continue;
      const fvv_status status =
          fvv_visibility_decode(order, &mesh.mesh, &header, bytes.data(), bytes.size(), centre,
                                has_former ? former.data() : nullptr, states.data(), nullptr);
      fuzz::expect_status(status);
      if (status != FVV_OK) continue;
      for (const uint8_t state : states)
        fuzz::expect(state <= FVV_VERTEX_SEEN_NEARER, "states are in their range");
      fvv_visibility_weights(states.data(), vertices, weights.data());
      former = states;
    }
  }
  fvv_visibility_order_close(order);
}
