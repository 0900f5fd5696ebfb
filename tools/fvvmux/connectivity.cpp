#include "fvvmux/connectivity.h"

#include <numeric>

namespace fvv::mux {

namespace {

constexpr uint32_t none = UINT32_MAX;

// Vertices by the corners that they take in both; those without a face take what is left, in order.
std::optional<std::vector<uint32_t>> by_corners(const capture::Mesh &a, const capture::Mesh &b) {
  std::vector<uint32_t> there(a.vertex_count(), none), back(b.vertex_count(), none);
  for (size_t i = 0; i < a.faces.size(); i++) {
    const uint32_t from = a.faces[i], to = b.faces[i];
    if (from >= there.size() || to >= back.size()) return {}; // the canonicaliser says what is wrong
    if (there[from] == none && back[to] == none) {
      there[from] = to;
      back[to] = from;
    }
    if (there[from] != to || back[to] != from) return {};
  }
  uint32_t next = 0;
  for (uint32_t &to : there) {
    if (to != none) continue;
    while (back[next] != none) next++;
    to = next++;
  }
  return there;
}

bool same_texture(const capture::Mesh &a, const capture::Mesh &b, const std::vector<uint32_t> &there) {
  if (a.texture.size() != b.texture.size()) return false;
  for (size_t i = 0; i < a.texture.size(); i++)
    if (a.texture[i] != b.texture[2 * size_t(there[i / 2]) + i % 2]) return false;
  return true;
}

} // namespace

std::optional<std::vector<uint32_t>> same_connectivity(const capture::Mesh &a, const capture::Mesh &b) {
  if (a.vertex_count() != b.vertex_count() || a.face_count() != b.face_count()) return {};
  std::optional<std::vector<uint32_t>> there;
  if (a.faces == b.faces) {
    there.emplace(a.vertex_count());
    std::iota(there->begin(), there->end(), 0);
  } else {
    there = by_corners(a, b);
  }
  if (there && !same_texture(a, b, *there)) there.reset();
  return there;
}

capture::Mesh reordered(const capture::Mesh &mesh, const std::vector<uint32_t> &order,
                        const capture::Mesh &like) {
  capture::Mesh out = like;
  for (size_t k = 0; k < out.positions.size(); k++)
    out.positions[k] = mesh.positions[3 * size_t(order[k / 3]) + k % 3];
  out.normals.resize(mesh.normals.size());
  for (size_t k = 0; k < out.normals.size(); k++)
    out.normals[k] = mesh.normals[3 * size_t(order[k / 3]) + k % 3];
  return out;
}

bool has_runs(const capture::Capture &capture) {
  const int64_t count = capture.frames.count;
  for (const int64_t first : {int64_t(0), count / 2 - 1, count - 2}) {
    if (first < 0 || first + 1 >= count) continue;
    const auto load = [&](int64_t i) { return capture::load_mesh(capture, capture.frames.number(i)); };
    if (same_connectivity(load(first), load(first + 1))) return true;
  }
  return false;
}

} // namespace fvv::mux
