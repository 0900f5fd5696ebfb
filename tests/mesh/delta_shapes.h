// Moving meshes for the tests of delta frames.
#ifndef FVV_TESTS_MESH_DELTA_SHAPES_H
#define FVV_TESTS_MESH_DELTA_SHAPES_H

#include <memory>
#include <vector>

#include "shapes.h"

// The mesh as a decoder gets it from a Draco payload.
std::unique_ptr<Mesh> key_of(const Shape &shape, double step = 0.001);

// Positions of frame t: the mesh bends and twists about the y axis, walks, and every vertex trembles by up to
// so many steps.
std::vector<int32_t> moved(const fvv_mesh &key, int t, int tremble = 0);

struct Sequence {
  fvv_mesh_sequence *handle = nullptr;
  explicit Sequence(const fvv_mesh &key, const fvv_allocator *allocator = nullptr);
  Sequence(const Sequence &) = delete;
  ~Sequence() { fvv_mesh_sequence_close(handle); }
  // A failure is a failed REQUIRE.
  std::vector<uint8_t> encode(const std::vector<int32_t> &positions, uint32_t max_error);
  // From a block on the heap that is exactly as long as the bytes.
  fvv_status decode(const std::vector<uint8_t> &payload, uint32_t levels = UINT32_MAX,
                    fvv_diagnostic *diagnostic = nullptr);
  std::vector<int32_t> positions() const;
};

// What stands in front of the data of a delta payload.
struct DeltaHeader {
  uint64_t number = 0;
  std::vector<std::array<uint64_t, 2>> levels; // step, bytes
  size_t data = 0;                             // offset
};
DeltaHeader header_of(const std::vector<uint8_t> &payload);
// The payload with another header.
std::vector<uint8_t> with_header(const std::vector<uint8_t> &payload, const DeltaHeader &header);

// Largest difference on one axis.
int32_t distance(const std::vector<int32_t> &a, const std::vector<int32_t> &b);

#endif
