// Meshes that the tests of libfvv/src/mesh share, still and moving, and ways to compare them.
#ifndef FVV_TESTS_MESH_SHAPES_H
#define FVV_TESTS_MESH_SHAPES_H

#include "fvv/mesh.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct Shape {
  std::vector<double> positions; // metres
  std::vector<uint32_t> faces;
  std::vector<double> texture; // u v of each vertex, or empty
  std::vector<double> normals; // x y z of each vertex, or empty

  fvv_mesh_source source() const {
    return {positions.data(),
            faces.data(),
            positions.size() / 3,
            faces.size() / 3,
            texture.empty() ? nullptr : texture.data(),
            normals.empty() ? nullptr : normals.data()};
  }
  void point(double x, double y, double z) {
    for (const double coordinate : {x, y, z}) positions.push_back(coordinate);
  }
  void face(uint32_t a, uint32_t b, uint32_t c) {
    for (const uint32_t index : {a, b, c}) faces.push_back(index);
  }
};

Shape tetrahedron(double size = 1);
// A closed surface of genus 1 with bumps; 2 * u * v faces. jitter moves vertices along the surface.
Shape torus(uint32_t u, uint32_t v, double jitter = 0);
// Closed, genus 0; 2 * u * (v - 1) faces.
Shape sphere(uint32_t u, uint32_t v);
// n x n vertices 10 mm apart; height 0 makes it flat.
Shape grid(uint32_t n, double height = 0.05);
Shape two_components();
// A torus with holes of all sizes: every share-th face is missing, picked at random.
Shape ragged(uint32_t u, uint32_t v, uint32_t share);
// A ring of holes between two vertices of that number of faces each: edgebreaker joins pieces around them
// over and over.
Shape holed_hubs(uint32_t faces);
// The surface of unit cubes that fill each cell of an n x n x n block with the given probability: handles,
// cavities and edges of four faces by the hundred.
Shape sponge(uint32_t n, double filled, uint32_t seed);
// Three triangles on one edge.
Shape fin();
// Two tetrahedra that share a vertex.
Shape bow_tie();

// The closed surface of a cube of edge 1 with an atlas of six charts side by side, n x n squares each:
// vertices are doubled along all edges and tripled at the corners. n * n * 12 faces.
Shape charts(uint32_t n);
// The same cube without an atlas; every side has vertices and normals of its own.
Shape hard_cube(uint32_t n);

// Frees itself.
struct Mesh : fvv_mesh {
  Mesh() : fvv_mesh() {}
  Mesh(const Mesh &) = delete;
  ~Mesh() { fvv_mesh_free(this); }
};
struct Bytes : fvv_bytes {
  Bytes() : fvv_bytes() {}
  Bytes(const Bytes &) = delete;
  ~Bytes() { fvv_bytes_free(this); }
  std::vector<uint8_t> copy() const { return {data, data + size}; }
};

// Canonicalises with a step in metres from origin 0; a failure is a failed REQUIRE.
std::unique_ptr<Mesh> canonical(const Shape &shape, double step = 0.001, fvv_mesh_report *report = nullptr,
                                uint32_t normal_bits = 0);
std::vector<uint8_t> encoded(const fvv_mesh &mesh, uint8_t profile, int level);
// What a loop over profiles and levels means: -2 is fast, -1 raw, 0 to 10 a level of Draco.
uint8_t profile_of(int level);
// Of a block on the heap that is exactly as long as the bytes, so that a sanitizer sees every read beyond.
fvv_status decode(const std::vector<uint8_t> &payload, fvv_mesh *mesh, fvv_diagnostic *diagnostic,
                  const fvv_allocator *allocator = nullptr);

// The triangles by position, texture and normal indices (0 without), each from its least corner on, sorted.
using Triangle = std::array<int32_t, 21>;
std::vector<Triangle> triangles(const fvv_mesh &mesh);

// ---- Moving meshes for the tests of delta frames.

// The mesh as a decoder gets it from a Draco payload.
std::unique_ptr<Mesh> key_of(const Shape &shape, double step = 0.001);

// Positions of frame t: the mesh bends and twists about the y axis, walks, and every vertex trembles by up to
// that number of steps.
std::vector<int32_t> moved(const fvv_mesh &key, int t, int tremble = 0);

struct Sequence {
  fvv_mesh_sequence *handle = nullptr;
  explicit Sequence(const fvv_mesh &key, const fvv_allocator *allocator = nullptr);
  Sequence(const Sequence &) = delete;
  ~Sequence() { fvv_mesh_sequence_close(handle); }
  // A failure is a failed REQUIRE.
  std::vector<uint8_t> encode(const std::vector<int32_t> &positions, uint32_t max_error);
  std::vector<uint8_t> encode(const std::vector<int32_t> &positions, const fvv_mesh_patch &patch,
                              uint32_t max_error);
  // From a block on the heap that is exactly as long as the bytes.
  fvv_status decode(const std::vector<uint8_t> &payload, fvv_diagnostic *diagnostic = nullptr);
  std::vector<int32_t> positions() const;
};

// The header of a delta payload.
struct DeltaHeader {
  uint64_t number = 0;
  std::vector<std::array<uint64_t, 2>> levels; // step, bytes
  size_t data = 0;                             // offset
};
DeltaHeader header_of(const std::vector<uint8_t> &payload);
// The payload with another header.
std::vector<uint8_t> with_header(const std::vector<uint8_t> &payload, const DeltaHeader &header);

// Some faces of a key mesh as a patch for a patched frame: a mesh of its own, at other positions.
struct CutOut {
  std::vector<uint8_t> absent;  // of each face of the key mesh
  std::vector<uint32_t> border; // of each vertex of the patch: that of the key mesh
  std::vector<int32_t> lattice;
  std::vector<uint32_t> faces, texture, normals;
  uint8_t texture_bits = 0, normal_bits = 0;
  // Borrows from this object.
  fvv_mesh mesh();
  fvv_mesh_patch patch(const fvv_mesh &mesh, uint8_t profile = FVV_MESH_DRACO) const;
};
// count faces from first on. positions: x 3 for each vertex of the key mesh.
CutOut cut_out(const fvv_mesh &key, const std::vector<int32_t> &positions, uint32_t first, uint32_t count);

// Largest difference on one axis.
int32_t distance(const std::vector<int32_t> &a, const std::vector<int32_t> &b);

#endif
