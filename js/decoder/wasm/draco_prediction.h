// Draco's slowest step in wasm, the prediction by several parallelograms, with the number of components known
// to the compiler. A specialization of Draco's own template: it does the same arithmetic in the same order.
#ifndef FVV_WASM_DRACO_PREDICTION_H
#define FVV_WASM_DRACO_PREDICTION_H

#include "draco/compression/attributes/prediction_schemes/mesh_prediction_scheme_constrained_multi_parallelogram_decoder.h"
#include "draco/compression/attributes/prediction_schemes/mesh_prediction_scheme_data.h"
#include "draco/compression/attributes/prediction_schemes/prediction_scheme_wrap_decoding_transform.h"
#include "draco/mesh/corner_table.h"

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

// Places of the values of the parallelograms around a vertex whose other corners come before it.
struct Parallelogram {
  int32_t opposite, next, previous;
};

inline int find_parallelograms(const draco::CornerTable &table, const int32_t *entries, int32_t place,
                               draco::CornerIndex start, Parallelogram *found) {
  int count = 0;
  bool left = true;
  for (draco::CornerIndex corner = start; corner != draco::kInvalidCornerIndex;) {
    const draco::CornerIndex opposite = table.Opposite(corner);
    if (opposite != draco::kInvalidCornerIndex) {
      const Parallelogram p = {entries[table.ConfidentVertex(opposite).value()],
                               entries[table.ConfidentVertex(table.Next(opposite)).value()],
                               entries[table.ConfidentVertex(table.Previous(opposite)).value()]};
      if ((p.opposite < place) & (p.next < place) & (p.previous < place)) {
        found[count++] = p;
        if (count == most_parallelograms) break;
      }
    }
    corner = left ? table.SwingLeft(corner) : table.SwingRight(corner);
    if (corner == start) break;
    if (corner == draco::kInvalidCornerIndex && left) {
      left = false;
      corner = table.SwingRight(start);
    }
  }
  return count;
}

template <int components>
bool decode(const Range &range, const MeshData &mesh, const std::vector<bool> *creases,
            const int32_t *corrections, int32_t *values) {
  const std::vector<draco::CornerIndex> &corners = *mesh.data_to_corner_map();
  const int32_t *const entries = mesh.vertex_to_data_map()->data();
  size_t at[most_parallelograms] = {};
  for (int c = 0; c < components; c++) values[c] = range.restore(0, corrections[c]);
  const int32_t count = int32_t(corners.size());
  for (int32_t place = 1; place < count; place++) {
    Parallelogram found[most_parallelograms];
    const int sides = find_parallelograms(*mesh.corner_table(), entries, place, corners[place], found);
    uint32_t sum[components] = {};
    int used = 0;
    for (int i = 0; i < sides; i++) {
      const std::vector<bool> &flags = creases[sides - 1];
      if (flags.size() <= at[sides - 1]) return false;
      if (flags[at[sides - 1]++]) continue;
      used++;
      for (int c = 0; c < components; c++)
        sum[c] += uint32_t(values[found[i].next * components + c]) +
                  uint32_t(values[found[i].previous * components + c]) -
                  uint32_t(values[found[i].opposite * components + c]);
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

#endif
