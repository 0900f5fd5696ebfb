// Which faces of a mesh share an edge, and the borders of a part of its faces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fvv::track {

using Triangles = std::vector<std::array<uint32_t, 3>>;

// Vertices along the edge of a part of a mesh.
struct Border {
  std::vector<uint32_t> vertices;
  bool closed = true; // false: it begins and ends at a border of the mesh itself
  uint32_t face = 0;  // one that is in and lies at it
};

// Half-edge 3 f + k goes from corner k of face f to the next one.
class HalfEdges {
public:
  // faces is borrowed.
  explicit HalfEdges(const Triangles &faces);

  // The borders between the faces that are in and the others; faces that are in lie left of them. A vertex
  // that two borders touch is in both.
  std::vector<Border> borders(const std::vector<uint8_t> &in) const;

  // A number for each face, which those that are in have in common as far as edges connect them, and so have
  // the others.
  std::vector<uint32_t> parts(const std::vector<uint8_t> &in) const;

  // The other faces, where those of them that are connected by edges are fewer than least, become in.
  void fill(std::vector<uint8_t> &in, size_t least) const;

private:
  static constexpr uint32_t none = UINT32_MAX;

  uint32_t begin(uint32_t half_edge) const { return faces[half_edge / 3][half_edge % 3]; }
  static uint32_t next(uint32_t half_edge) { return half_edge / 3 * 3 + (half_edge % 3 + 1) % 3; }
  bool is_border(uint32_t half_edge, const std::vector<uint8_t> &in) const {
    return in[half_edge / 3] && others[half_edge] != none && !in[others[half_edge] / 3];
  }

  // The border half-edge that follows one; none where the border ends.
  uint32_t after(uint32_t half_edge, const std::vector<uint8_t> &in) const;

  const Triangles &faces;
  // The half-edge in the other direction of each; none at a border, and where more than two faces share an
  // edge or two have it in the same direction.
  std::vector<uint32_t> others;
};

} // namespace fvv::track
