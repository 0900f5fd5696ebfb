// A plain encoder of fast meshes, by the specification and without meshoptimizer: every delta as a byte,
// every index as a number. Tests change its parts to make invalid payloads.
#ifndef FVV_TESTS_MESH_FAST_PLAIN_H
#define FVV_TESTS_MESH_FAST_PLAIN_H

#include <cstdint>
#include <string>
#include <vector>

#include "fvv/mesh.h"

struct FastPlain {
  std::vector<uint8_t> vertices, codes, numbers, table = std::vector<uint8_t>(16);
  uint8_t vertex_codec = 0xa0, index_codec = 0xe1;

  explicit FastPlain(const fvv_mesh &mesh);
  std::vector<uint8_t> payload() const;

  static void put_number(std::vector<uint8_t> &out, uint32_t value);
  // A code for index after the last one.
  static uint32_t difference(uint32_t last, uint32_t index);

private:
  void put_vertices(const fvv_mesh &mesh);
  void put_faces(const fvv_mesh &mesh);
  std::vector<uint8_t> header;
};

#endif
