// The arrays of Draco's corner table, which its functions load the addresses of again for each corner.
#ifndef FVV_WASM_DRACO_TABLES_H
#define FVV_WASM_DRACO_TABLES_H

#include <cstdint>

#include "draco/mesh/corner_table.h"

namespace fvv_draco {

constexpr uint32_t none = draco::kInvalidCornerIndex.value();

using Vertices = draco::IndexTypeVector<draco::CornerIndex, draco::VertexIndex>;
using Opposites = draco::IndexTypeVector<draco::CornerIndex, draco::CornerIndex>;
using LeftMost = draco::IndexTypeVector<draco::VertexIndex, draco::CornerIndex>;

const Vertices &expose_vertices(const draco::CornerTable &);
const Opposites &expose_opposites(const draco::CornerTable &);
const LeftMost &expose_left_most(const draco::CornerTable &);

// An explicit instantiation may name private members.
template <Vertices draco::CornerTable::*vertices, Opposites draco::CornerTable::*opposites,
          LeftMost draco::CornerTable::*left_most>
struct Exposed {
  friend const Vertices &expose_vertices(const draco::CornerTable &table) { return table.*vertices; }
  friend const Opposites &expose_opposites(const draco::CornerTable &table) { return table.*opposites; }
  friend const LeftMost &expose_left_most(const draco::CornerTable &table) { return table.*left_most; }
};
template struct Exposed<&draco::CornerTable::corner_to_vertex_map_, &draco::CornerTable::opposite_corners_,
                        &draco::CornerTable::vertex_corners_>;

// By corner: its vertex, and the opposite corner. By vertex: its leftmost corner.
inline const uint32_t *vertices_of(const draco::CornerTable &table) {
  return reinterpret_cast<const uint32_t *>(expose_vertices(table).data());
}
inline const uint32_t *opposites_of(const draco::CornerTable &table) {
  return reinterpret_cast<const uint32_t *>(expose_opposites(table).data());
}
inline const uint32_t *left_most_of(const draco::CornerTable &table) {
  return reinterpret_cast<const uint32_t *>(expose_left_most(table).data());
}

inline uint32_t next_corner(uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}
inline uint32_t previous_corner(uint32_t corner) {
  return corner % 3 ? corner - 1 : corner + 2;
}
inline uint32_t swing_left(const uint32_t *opposite, uint32_t corner) {
  const uint32_t across = opposite[next_corner(corner)];
  return across == none ? none : next_corner(across);
}
inline uint32_t swing_right(const uint32_t *opposite, uint32_t corner) {
  const uint32_t across = opposite[previous_corner(corner)];
  return across == none ? none : previous_corner(across);
}

} // namespace fvv_draco

#endif
