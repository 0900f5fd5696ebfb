// The search for the visibility weights of one camera (fvv.md, clause 17) that come closest to the result of
// rays.
#pragma once

#include "fvv_render/visibility_fit.h"
#include "viewer.h"

#include <array>

namespace fvv::render {

// Threshold accepting (Dueck and Scheuer 1990): the way to a better sum often leads through a worse one.
// improve(worse) tries every change, takes those by which the sum grows by less than worse, and returns
// whether it took any. worse falls from tolerance to 0.
template <class Improve> void accept_by_threshold(double tolerance, Improve improve) {
  constexpr int tolerant_passes = 8, strict_passes = 4;
  constexpr double least_gain = 1e-9; // or rounding could cause an endless loop
  for (int pass = 0; pass < tolerant_passes; pass++)
    improve(tolerance * (tolerant_passes - pass) / tolerant_passes);
  for (int pass = 0; pass < strict_passes && improve(-least_gain); pass++) continue;
}

// Barycentric coordinates, in twelfths, of the middles of the sixteen equal parts of a triangle: the corners'
// parts, then the middle of all, then the others.
constexpr int weight_place_count = 16;
constexpr int twelfths[weight_place_count][3] = {
    {10, 1, 1}, {1, 10, 1}, {1, 1, 10}, {4, 4, 4}, {8, 2, 2}, {2, 8, 2}, {2, 2, 8}, {7, 4, 1},
    {7, 1, 4},  {4, 7, 1},  {1, 7, 4},  {4, 1, 7}, {1, 4, 7}, {5, 5, 2}, {5, 2, 5}, {2, 5, 5}};
constexpr uint16_t all_weight_places = 0xFFFF;

// Of the selected faces: bit i of free is set when nothing is in front of place i. The middle decides for all
// of a face unless the middle of one near it differs; then the corners' parts do, with the middle, where they
// agree.
struct WeightPlaces {
  std::vector<uint8_t> judged; // each face: selected, and in the picture
  std::vector<uint16_t> free;  // each face
  std::vector<uint8_t> mixed;  // each vertex: an outline passes through the faces around it

  // around and first: of each vertex the faces that use it.
  WeightPlaces(Viewer &viewer, const Mesh &mesh, const std::vector<uint8_t> &selected,
               const std::vector<uint32_t> &first, const std::vector<uint32_t> &around);
};

// Common to all cameras: which vertices are beside one another, and in which order they are coded.
struct WeightNeighbours {
  WeightNeighbours(const Mesh &mesh, const std::vector<uint32_t> &first, const std::vector<uint32_t> &around);
  std::vector<uint32_t> first, beside; // of each vertex the other corners of the faces that use it
  std::vector<uint32_t> rank;          // of each vertex, in the breadth first order
};

class WeightSearch {
public:
  // All are borrowed. weighs: of each face the places that count. facing: vertices. former: NULL, or
  // FVV_VERTEX_... of each vertex the time before.
  WeightSearch(const Mesh &mesh, const WeightNeighbours &neighbours, const std::vector<uint32_t> &first,
               const std::vector<uint32_t> &around, const std::vector<double> &area,
               const WeightPlaces &places, const std::vector<uint16_t> &weighs,
               const std::vector<uint8_t> &facing, const uint8_t *former, const FitSettings &settings);

  // FVV_VERTEX_... of each vertex.
  std::vector<uint8_t> run();

private:
  static constexpr int levels = 3, classes = 7;
  using Counts = std::array<uint16_t, 2>; // of hidden and of seen

  static std::vector<uint16_t> shown_by_states();
  static int side_of(uint8_t state) { return state % 2 == 0; } // of one that faces: 1 seen
  template <class Body> void each_beside(uint32_t v, Body body) const;
  void begin();
  void learn();
  bool improve(double worse);
  bool attempt(uint32_t v, uint8_t state, double worse);
  void set(uint32_t v, uint8_t state);
  double wrong(uint32_t face) const;
  double wrong_around(uint32_t v) const;
  double side_bits(uint32_t v) const;
  double level_bits(uint32_t v) const;
  double price(uint32_t v, bool of_side) const;
  uint32_t others(uint32_t v) const; // class of those of the other side around it

  const Mesh &mesh;
  const WeightNeighbours &neighbours;
  const std::vector<uint32_t> &first, &around;
  const std::vector<double> &area;
  const WeightPlaces &places;
  const std::vector<uint16_t> &weighs;
  const std::vector<uint8_t> &facing;
  const uint8_t *former;
  const FitSettings &settings;
  const std::vector<uint16_t> shown; // places that three corners' states show
  std::vector<uint8_t> states, rim;
  std::vector<Counts> all, before; // around each vertex, and of these before it in coding order
  std::vector<uint32_t> doubtful;
  double bits_of_side[2][classes][classes][2] = {};
  double bits_of_level[classes][levels] = {};
};

} // namespace fvv::render
