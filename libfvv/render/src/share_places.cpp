#include "share_places.h"

namespace fvv::render {

namespace {

constexpr int probes = 3; // the corners' parts; the middle is known by then

} // namespace

SharePlaces::SharePlaces(Viewer &viewer, const Mesh &mesh, const std::vector<uint8_t> &asked,
                         const std::vector<uint32_t> &first, const std::vector<uint32_t> &around)
    : judged(mesh.face_count), free(mesh.face_count), mixed(mesh.vertex_count) {
  const auto look = [&](uint32_t f, int from, int to) {
    for (int p = from; p < to; p++) {
      const auto &[a, b, c] = twelfths[p];
      const bool seen = viewer.free(viewer.at(mesh.faces + size_t(3) * f, a, b, c), f);
      free[f] = uint16_t((free[f] & ~(1u << p)) | unsigned(seen) << p);
    }
  };
  std::vector<uint8_t> sides(mesh.vertex_count); // bit 0: of a hidden place around it; bit 1: of a seen one
  const auto side_of = [&](uint32_t f) { return uint8_t(free[f] == all_share_places ? 2 : free[f] ? 3 : 1); };
  std::vector<uint32_t> queue; // vertices that an outline passes by
  const auto note = [&](uint32_t f) {
    for (int k = 0; k < 3; k++) {
      const uint32_t v = mesh.faces[size_t(3) * f + size_t(k)];
      const uint8_t before = sides[v];
      sides[v] |= side_of(f);
      if (before != 3 && sides[v] == 3) queue.push_back(v);
    }
  };
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + size_t(3) * f;
    if (!asked[f] || !viewer.face_in_picture(face)) continue;
    judged[f] = 1;
    free[f] = viewer.free(viewer.at(face, 4, 4, 4), f) ? all_share_places : 0;
    note(f);
  }
  // Outlines are followed from face to face; queue grows meanwhile.
  std::vector<uint8_t> looked(mesh.face_count);
  for (size_t i = 0; i < queue.size(); i++)
    for (uint32_t k = first[queue[i]]; k < first[queue[i] + 1]; k++) {
      const uint32_t f = around[k];
      if (!judged[f] || looked[f]) continue;
      looked[f] = 1;
      look(f, 0, probes);
      if (side_of(f) != 3) continue;
      look(f, probes + 1, share_place_count);
      note(f);
    }
  for (const uint32_t v : queue) mixed[v] = 1;
}

} // namespace fvv::render
