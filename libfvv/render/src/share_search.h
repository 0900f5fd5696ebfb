// The search for the shares of one camera that lie nearest to what rays say for their bits (fvv.md, clause
// 17). Knows what contexts of clause 17.3 count, no payloads.
#pragma once

#include "share_places.h"

#include "fvv_render/visibility_fit.h"

#include <array>

namespace fvv::render {

// What all cameras share: which vertices lie beside one another, and in which order they are coded.
struct ShareNeighbours {
  ShareNeighbours(const Mesh &mesh, const std::vector<uint32_t> &first, const std::vector<uint32_t> &around);
  std::vector<uint32_t> first, beside; // of each vertex the other corners of the faces that use it
  std::vector<uint32_t> rank;          // of each vertex, in the breadth first order
};

class ShareSearch {
public:
  // All are borrowed. weighs: of each face the places that count. facing: vertices. former: NULL, or
  // FVV_ELEMENT_... of each vertex the time before.
  ShareSearch(const Mesh &mesh, const ShareNeighbours &neighbours, const std::vector<uint32_t> &first,
              const std::vector<uint32_t> &around, const std::vector<double> &area, const SharePlaces &places,
              const std::vector<uint16_t> &weighs, const std::vector<uint8_t> &facing, const uint8_t *former,
              const FitSettings &settings);

  // FVV_ELEMENT_... of each vertex.
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
  const ShareNeighbours &neighbours;
  const std::vector<uint32_t> &first, &around;
  const std::vector<double> &area;
  const SharePlaces &places;
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
