// The order in which Draco decodes vertices, with what was visited in bytes and everything else in registers.
// A specialization of Draco's own template: it visits the same vertices in the same order.
#ifndef FVV_WASM_DRACO_TRAVERSAL_H
#define FVV_WASM_DRACO_TRAVERSAL_H

#include "draco/compression/mesh/traverser/depth_first_traverser.h"
#include "draco/compression/mesh/traverser/mesh_attribute_indices_encoding_observer.h"
#include "draco/compression/mesh/traverser/mesh_traversal_sequencer.h"
#include "draco/mesh/corner_table.h"
#include "draco_tables.h"

namespace fvv_draco {

using Observer = draco::MeshAttributeIndicesEncodingObserver<draco::CornerTable>;
using Traverser = draco::DepthFirstTraverser<draco::CornerTable, Observer>;

// False: a corner has no vertex.
inline bool visit_vertices(const draco::CornerTable &table, Observer observer) {
  const uint32_t count = uint32_t(table.num_corners()), vertices = uint32_t(table.num_vertices());
  const uint32_t *const vertex_at = vertices_of(table), *const opposite = opposites_of(table);
  const uint32_t *const left_most = left_most_of(table);
  std::vector<uint8_t> seen_faces(count / 3), seen_vertices(vertices);
  uint8_t *const seen_face = seen_faces.data(), *const seen_vertex = seen_vertices.data();
  std::vector<uint32_t> stack;
  // Whether it is the first visit of the vertex.
  const auto visit = [&](uint32_t corner, uint32_t vertex) {
    if (seen_vertex[vertex]) return false;
    seen_vertex[vertex] = 1;
    observer.OnNewVertexVisited(draco::VertexIndex(vertex), draco::CornerIndex(corner));
    return true;
  };
  const auto visited = [&](uint32_t corner) { return corner == none || seen_face[corner / 3]; };
  for (uint32_t first = 0; first < count; first += 3) {
    if (seen_face[first / 3]) continue;
    for (uint32_t corner = first + 1; corner < first + 3; corner++) {
      if (vertex_at[corner] >= vertices) return false;
      visit(corner, vertex_at[corner]);
    }
    stack.push_back(first);
    while (!stack.empty()) {
      uint32_t corner = stack.back();
      stack.pop_back();
      while (!visited(corner)) {
        seen_face[corner / 3] = 1;
        const uint32_t vertex = vertex_at[corner];
        if (vertex >= vertices) return false;
        const uint32_t right = opposite[next_corner(corner)];
        if (visit(corner, vertex) && swing_left(opposite, left_most[vertex]) != none) {
          corner = right;
          continue;
        }
        const uint32_t left = opposite[previous_corner(corner)];
        if (!visited(right)) {
          if (!visited(left)) stack.push_back(left);
          corner = right;
        } else {
          corner = left;
        }
      }
    }
  }
  return true;
}

} // namespace fvv_draco

// Only encoders set an order of corners.
template <> inline bool draco::MeshTraversalSequencer<fvv_draco::Traverser>::GenerateSequenceInternal() {
  if (corner_order_) return false;
  const draco::CornerTable &table = *traverser_.corner_table();
  out_point_ids()->reserve(size_t(table.num_vertices()));
  return fvv_draco::visit_vertices(table, traverser_.traversal_observer());
}

// By the vertices in their order, each of which is one point: libfvv's check lets through no seams. Draco
// goes over all corners of all faces.
template <>
inline bool draco::MeshTraversalSequencer<fvv_draco::Traverser>::UpdatePointToAttributeIndexMapping(
    PointAttribute *attribute) {
  const std::vector<CornerIndex> &corners = encoding_data_->encoded_attribute_value_index_to_corner_map;
  const uint32_t points = mesh_->num_points();
  attribute->SetExplicitMapping(points);
  for (uint32_t i = 0; i < corners.size(); i++) {
    const uint32_t corner = corners[i].value();
    const PointIndex point = mesh_->face(FaceIndex(corner / 3))[corner % 3];
    if (point >= points || i >= points) return false;
    attribute->SetPointMapEntry(point, AttributeValueIndex(i));
  }
  return true;
}

#endif
