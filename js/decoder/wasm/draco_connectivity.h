// The connectivity of valence edgebreaker, from the symbols that libfvv's check has decoded: valences and
// contexts need not be found again, and what the loop reads stays in registers. It makes the same faces in
// the same order as Draco's own template, and fails where that does.
#ifndef FVV_WASM_DRACO_CONNECTIVITY_H
#define FVV_WASM_DRACO_CONNECTIVITY_H

// In place of Draco's header.
#define DRACO_COMPRESSION_MESH_MESH_EDGEBREAKER_TRAVERSAL_VALENCE_DECODER_H_

#include <cstring>
#include <memory>
#include <unordered_map>
#include <vector>

#include "draco/compression/mesh/mesh_edgebreaker_decoder_impl.h"
#include "draco/compression/mesh/mesh_edgebreaker_traversal_decoder.h"
#include "draco/core/varint_decoding.h"
#include "draco_checked.h"
#include "draco_tables.h"

namespace draco {

class MeshEdgebreakerTraversalValenceDecoder : public MeshEdgebreakerTraversalDecoder {
public:
  // rest: what follows the symbols.
  bool Start(DecoderBuffer *rest) {
    if (!DecodeStartFaces() || !DecodeAttributeSeams()) return false;
    *rest = *buffer();
    const fvvcodec_checked &checked = fvvcodec_last_check;
    const char *const end = reinterpret_cast<const char *>(checked.data) + checked.symbols.end;
    const int64_t size = end - rest->data_head();
    if (size < 0 || size > rest->remaining_size()) return false;
    rest->Advance(size);
    return true;
  }
};

} // namespace draco

namespace fvv_draco {

enum Symbol { symbol_c, symbol_s, symbol_l, symbol_r, symbol_e };

// Faces are put onto active edges, which are named by the corners opposite to them: an edge that a face
// leaves active is opposite to its first corner. Draco's source has drawings of each case.
struct FaceBuilder {
  uint32_t *const vertex_at, *const opposite, *const left_most;

  FaceBuilder(draco::CornerTable *table)
      : vertex_at(const_cast<uint32_t *>(vertices_of(*table))),
        opposite(const_cast<uint32_t *>(opposites_of(*table))),
        left_most(const_cast<uint32_t *>(left_most_of(*table))) {}

  bool is_open(uint32_t corner) const { return opposite[corner] == none; }
  void join(uint32_t a, uint32_t b) const {
    opposite[a] = b;
    opposite[b] = a;
  }
  void map(uint32_t corner, uint32_t a, uint32_t b, uint32_t c) const {
    vertex_at[corner] = a;
    vertex_at[corner + 1] = b;
    vertex_at[corner + 2] = c;
  }
  // The corner across from the edge after the one at a, around the vertex x between the two.
  uint32_t across(uint32_t x) const { return left_most[x] == none ? none : next_corner(left_most[x]); }

  bool put_c(uint32_t a, uint32_t corner) const {
    const uint32_t x = vertex_at[a + 1], b = across(x);
    if (b == none || a == b || !is_open(a) || !is_open(b)) return false;
    const uint32_t after = vertex_at[next_corner(b)], before = vertex_at[a + 2];
    if (x == before || x == after) return false;
    join(a, corner + 1);
    join(b, corner + 2);
    map(corner, x, after, before);
    left_most[before] = corner + 2;
    return true;
  }
  bool put_l(uint32_t a, uint32_t corner, uint32_t tip) const {
    if (!is_open(a)) return false;
    const uint32_t right = vertex_at[a + 2];
    join(a, corner + 1);
    map(corner, vertex_at[a + 1], tip, right);
    left_most[tip] = corner + 1;
    left_most[right] = corner + 2;
    return true;
  }
  bool put_r(uint32_t a, uint32_t corner, uint32_t tip) const {
    if (!is_open(a)) return false;
    const uint32_t right = vertex_at[a + 2];
    join(a, corner + 2);
    map(corner, right, vertex_at[a + 1], tip);
    left_most[tip] = corner + 2;
    left_most[right] = corner;
    return true;
  }
  // merged: receives the vertex that is no longer used.
  bool put_s(uint32_t a, uint32_t b, uint32_t corner, uint32_t *merged) const {
    if (a == b || !is_open(a) || !is_open(b)) return false;
    const uint32_t p = vertex_at[previous_corner(a)], before = vertex_at[b + 2], n = vertex_at[b + 1];
    join(a, corner + 2);
    join(b, corner + 1);
    map(corner, p, vertex_at[next_corner(a)], before);
    left_most[before] = corner + 2;
    left_most[p] = left_most[n];
    for (uint32_t c = b + 1; c != none;) {
      vertex_at[c] = p;
      c = swing_left(opposite, c);
      if (c == b + 1) return false;
    }
    left_most[n] = none;
    *merged = n;
    return true;
  }
  void put_e(uint32_t corner, uint32_t tip) const {
    map(corner, tip, tip + 1, tip + 2);
    for (uint32_t k = 0; k < 3; k++) left_most[tip + k] = corner + k;
  }
  // The face with which an encoder began a component inside the surface.
  bool put_interior(uint32_t a, uint32_t corner) const {
    const uint32_t n = vertex_at[a + 1], b = across(n);
    const uint32_t x = b == none ? none : vertex_at[next_corner(b)], c = x == none ? none : across(x);
    if (c == none || a == b || a == c || b == c || !is_open(a) || !is_open(b) || !is_open(c)) return false;
    const uint32_t p = vertex_at[next_corner(c)];
    join(corner, a);
    join(corner + 1, b);
    join(corner + 2, c);
    map(corner, x, p, n);
    return true;
  }
  // Gives all corners of one vertex to another one.
  bool rename(uint32_t from, uint32_t to) const {
    const uint32_t start = left_most[from];
    uint32_t c = start;
    do {
      if (vertex_at[c] != from) return false;
      vertex_at[c] = to;
      c = swing_left(opposite, c);
    } while (c != none && c != start);
    if (c == none)
      for (c = swing_right(opposite, start); c != none; c = swing_right(opposite, c)) {
        if (vertex_at[c] != from) return false;
        vertex_at[c] = to;
      }
    left_most[to] = start;
    left_most[from] = none;
    return true;
  }
  // Fills the numbers that are no longer used with the last vertices. Returns how many vertices there are, or
  // -1.
  int fill_gaps(const std::vector<uint32_t> &gaps, uint32_t count) const {
    for (const uint32_t gap : gaps) {
      while (count && left_most[count - 1] == none) count--;
      if (!count) return -1;
      if (count - 1 < gap) continue;
      if (!rename(count - 1, gap)) return -1;
      count--;
    }
    return int(count);
  }
};

} // namespace fvv_draco

// Without seams vertices are points, and faces are what the corner table has.
template <>
inline bool
draco::MeshEdgebreakerDecoderImpl<draco::MeshEdgebreakerTraversalValenceDecoder>::AssignPointsToCorners(
    int vertices) {
  const uint32_t faces = uint32_t(corner_table_->num_faces());
  if (!attribute_data_.empty() || !faces) return false;
  decoder_->mesh()->SetNumFaces(faces);
  void *const to = const_cast<Mesh::Face *>(&decoder_->mesh()->face(FaceIndex(0)));
  std::memcpy(to, fvv_draco::vertices_of(*corner_table_), faces * sizeof(Mesh::Face));
  decoder_->point_cloud()->set_num_points(uint32_t(vertices));
  return true;
}

// libfvv's check lets through no seams, so that only positions have connectivity.
template <>
__attribute__((noinline)) inline int
draco::MeshEdgebreakerDecoderImpl<draco::MeshEdgebreakerTraversalValenceDecoder>::DecodeConnectivity(
    int symbol_count) {
  using namespace fvv_draco;
  const fvv_draco_symbols &checked = fvvcodec_last_check.symbols;
  const uint32_t count = uint32_t(symbol_count), most = uint32_t(is_vert_hole_.size());
  if (!attribute_data_.empty() || count != checked.count || !most) return -1;
  corner_table_->SetNumVertices(int(most));
  const FaceBuilder builder(corner_table_.get());
  const uint8_t *const symbols = checked.values;
  // Each E adds an edge, and no other symbol does.
  const std::unique_ptr<uint32_t[]> active(new uint32_t[size_t(count) + 1]);
  std::unordered_map<uint32_t, uint32_t> glued; // edges that topology splits keep, by symbol
  std::vector<uint32_t> gaps;
  uint32_t height = 0, made = 0, merged;
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t corner = 3 * i;
    const unsigned symbol = symbols[i];
    if (symbol == symbol_e) {
      if (most - made < 3) return -1;
      builder.put_e(corner, made);
      made += 3;
      height++;
    } else if (!height) {
      return -1;
    } else if (symbol == symbol_c) {
      if (!builder.put_c(active[height - 1], corner)) return -1;
    } else if (symbol == symbol_s) {
      const uint32_t b = active[--height];
      if (!glued.empty() && glued.count(i)) active[height++] = glued[i];
      if (!height || !builder.put_s(active[height - 1], b, corner, &merged)) return -1;
      gaps.push_back(merged);
    } else {
      if (made == most) return -1;
      const uint32_t a = active[height - 1], tip = made++;
      if (symbol == symbol_r ? !builder.put_r(a, corner, tip) : !builder.put_l(a, corner, tip)) return -1;
    }
    active[height - 1] = corner;
    if (symbol == symbol_c || symbol == symbol_s) continue;
    EdgeFaceName side;
    int split;
    while (IsTopologySplit(int(count - 1 - i), &side, &split)) {
      if (split < 0) return -1;
      glued[count - 1 - uint32_t(split)] = side == RIGHT_FACE_EDGE ? corner + 1 : corner + 2;
    }
  }
  corner_table_->SetNumVertices(int(made));
  uint32_t faces = count;
  while (height) {
    if (!traversal_decoder_.DecodeStartFaceConfiguration()) {
      height--;
    } else if (faces == uint32_t(corner_table_->num_faces()) ||
               !builder.put_interior(active[--height], 3 * faces++)) {
      return -1;
    }
  }
  return faces == uint32_t(corner_table_->num_faces()) ? builder.fill_gaps(gaps, made) : -1;
}

#endif
