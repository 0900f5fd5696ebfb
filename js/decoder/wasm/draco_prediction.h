// Draco's slowest step in wasm, the prediction by several parallelograms, with the number of components known
// to the compiler. A specialization of Draco's own template: it does the same arithmetic in the same order.
#ifndef FVV_WASM_DRACO_PREDICTION_H
#define FVV_WASM_DRACO_PREDICTION_H

#include <memory>

#include "draco/compression/attributes/prediction_schemes/mesh_prediction_scheme_constrained_multi_parallelogram_decoder.h"
#include "draco/compression/attributes/prediction_schemes/mesh_prediction_scheme_data.h"
#include "draco/compression/attributes/prediction_schemes/prediction_scheme_wrap_decoding_transform.h"
#include "draco/compression/attributes/sequential_integer_attribute_decoder.h"
#include "draco/mesh/corner_table.h"
#include "draco_tables.h"

namespace fvv_draco {

using Transform = draco::PredictionSchemeWrapDecodingTransform<int32_t, int32_t>;
using MeshData = draco::MeshPredictionSchemeData<draco::CornerTable>;
using Decoder = draco::MeshPredictionSchemeConstrainedMultiParallelogramDecoder<int32_t, Transform, MeshData>;

constexpr int most_parallelograms = draco::constrained_multi_parallelogram::kMaxNumParallelograms;

// The range of values, which Draco keeps to its own classes.
struct Range : Transform {
  int32_t least, most, span;
  explicit Range(const Transform &transform)
      : least((transform.*(&Range::min_value))()), most((transform.*(&Range::max_value))()),
        span((transform.*(&Range::max_dif))()) {}
  int32_t restore(int32_t predicted, int32_t correction) const {
    const int32_t clamped = predicted > most ? most : predicted < least ? least : predicted;
    const int32_t value = int32_t(uint32_t(clamped) + uint32_t(correction));
    return value > most ? value - span : value < least ? value + span : value;
  }
};

// Divisors that the compiler knows: it multiplies and shifts.
inline int32_t divide(int32_t sum, int count) {
  return count == 1 ? sum : count == 2 ? sum / 2 : count == 3 ? sum / 3 : sum / 4;
}

// Of a corner: the next corner to the left around its vertex, or -1, and the places of the values of the
// parallelogram across from it; most_places without one.
struct Corner {
  int32_t left, opposite, next, previous;
};

constexpr int32_t no_place = INT32_MAX;

// All corners at once: around a vertex each step would wait for the one before it, and each corner is looked
// at once. False: a corner has no vertex.
inline bool gather_corners(const draco::CornerTable &table, const std::vector<int32_t> &entries,
                           Corner *corners) {
  const uint32_t count = uint32_t(table.num_corners()), vertices = uint32_t(entries.size());
  const uint32_t *const vertex_at = vertices_of(table), *const opposite_to = opposites_of(table);
  const int32_t *const place_of = entries.data();
  for (uint32_t c = 0; c < count; c++)
    if (vertex_at[c] >= vertices) return false;
  for (uint32_t face = 0; face < count; face += 3)
    for (uint32_t k = 0; k < 3; k++) {
      const uint32_t opposite = opposite_to[face + k];
      // The corner whose next one this is.
      Corner &before = corners[face + (k + 2) % 3];
      Corner &here = corners[face + k];
      if (opposite >= count) {
        before.left = -1;
        here.opposite = here.next = here.previous = no_place;
        continue;
      }
      const uint32_t rest = opposite % 3;
      const uint32_t next = opposite + (rest == 2 ? -2u : 1u), previous = opposite + (rest == 0 ? 2u : -1u);
      before.left = int32_t(next);
      here.opposite = place_of[vertex_at[opposite]];
      here.next = place_of[vertex_at[next]];
      here.previous = place_of[vertex_at[previous]];
    }
  return true;
}

inline int find_parallelograms(const draco::CornerTable &table, const Corner *corners, int32_t place,
                               draco::CornerIndex start, const Corner **found) {
  int count = 0;
  const auto look = [&](const Corner &c) {
    if ((c.opposite < place) & (c.next < place) & (c.previous < place)) found[count++] = &c;
    return count == most_parallelograms;
  };
  uint32_t corner = start.value();
  do {
    if (look(corners[corner])) return count;
    corner = uint32_t(corners[corner].left);
  } while (int32_t(corner) >= 0 && corner != start.value());
  // At a boundary: the faces on the other side of the first one.
  if (int32_t(corner) < 0)
    for (draco::CornerIndex c = table.SwingRight(start); c != draco::kInvalidCornerIndex;
         c = table.SwingRight(c))
      if (c == start || look(corners[c.value()])) break;
  return count;
}

template <int components>
bool decode(const Range &range, const MeshData &mesh, const std::vector<bool> *creases,
            const int32_t *corrections, int32_t *values) {
  const std::vector<draco::CornerIndex> &corners = *mesh.data_to_corner_map();
  const draco::CornerTable &table = *mesh.corner_table();
  const std::unique_ptr<Corner[]> around(new Corner[size_t(table.num_corners())]);
  if (!gather_corners(table, *mesh.vertex_to_data_map(), around.get())) return false;
  size_t at[most_parallelograms] = {};
  for (int c = 0; c < components; c++) values[c] = range.restore(0, corrections[c]);
  const int32_t count = int32_t(corners.size());
  for (int32_t place = 1; place < count; place++) {
    const Corner *found[most_parallelograms];
    const int sides = find_parallelograms(table, around.get(), place, corners[place], found);
    uint32_t sum[components] = {};
    int used = 0;
    for (int i = 0; i < sides; i++) {
      const std::vector<bool> &flags = creases[sides - 1];
      if (flags.size() <= at[sides - 1]) return false;
      if (flags[at[sides - 1]++]) continue;
      used++;
      for (int c = 0; c < components; c++)
        sum[c] += uint32_t(values[found[i]->next * components + c]) +
                  uint32_t(values[found[i]->previous * components + c]) -
                  uint32_t(values[found[i]->opposite * components + c]);
    }
    int32_t *const to = values + place * components;
    for (int c = 0; c < components; c++)
      to[c] = range.restore(used ? divide(int32_t(sum[c]), used) : to[c - components],
                            corrections[place * components + c]);
  }
  return true;
}

} // namespace fvv_draco

// libfvv's check lets through nothing but positions and pairs.
template <>
inline bool fvv_draco::Decoder::ComputeOriginalValues(const int32_t *corrections, int32_t *values, int,
                                                      int components, const draco::PointIndex *) {
  const fvv_draco::Range range(this->transform());
  if (components == 3)
    return fvv_draco::decode<3>(range, this->mesh_data(), is_crease_edge_, corrections, values);
  return components == 2 &&
         fvv_draco::decode<2>(range, this->mesh_data(), is_crease_edge_, corrections, values);
}

// Draco copies value by value, each with a call of the engine.
template <> inline void draco::SequentialIntegerAttributeDecoder::StoreTypedValues<int32_t>(uint32_t count) {
  attribute()->buffer()->Write(0, GetPortableAttributeData(),
                               size_t(count) * size_t(attribute()->num_components()) * sizeof(int32_t));
}

#endif
