// Visibility bits and weights chosen for the least error against rays after the interpolation that players do
// (fvv.md, clause 17.4), and for few bytes.
#pragma once

#include "fvv/visibility.h"
#include "fvv_render/ray_visibility.h"

#include <memory>

namespace fvv::render {

class Viewer;
struct WeightNeighbours;

// Prices count in faces of mean area that a player would show wrongly or hide wrongly.
struct FitSettings {
  double cosine = 0.25;   // places with less weight are ignored
  double edge = 0.02;     // of two touching elements with different bits, for each place that both touch
  double bit = 0.0275;    // of a bit of the stream, with weights, in place of edge
  double change = 0;      // of a bit that is not the former one; a quarter where a weight stays on its side
  double tolerance = 0.2; // of the search: changes that are worse by up to this are accepted at first
  double weight_tolerance = 0.05; // the same with weights, whose steps are smaller
};

// Of one mesh, for any number of cameras.
class VisibilityFit {
public:
  // Borrows mesh and rays, which is of mesh. domain: FVV_VISIBILITY_...
  VisibilityFit(const Mesh &mesh, const RayCaster &rays, uint8_t domain, const FitSettings &settings);
  ~VisibilityFit();

  // For each face or vertex 1 if its bit is to be set; with weights FVV_ELEMENT_... of each vertex. Begins
  // with the result of rays for most of each element, and changes bits as long as that reduces the sum of
  // errors and prices. selected: from fvv_visibility_facing. former: NULL, or for each element
  // FVV_ELEMENT_... of the time before, FVV_ELEMENT_BACKFACING where there is none. The same on every machine
  // for any order of cameras.
  std::vector<uint8_t> seen(const fvv_camera &camera, const std::vector<uint8_t> &selected,
                            const uint8_t *former) const;

private:
  class Search;
  // Faces that may be used for a camera though they are not selected: those that face it by less, but enough
  // by the normals of their vertices.
  std::vector<uint8_t> faces_to_judge(const Viewer &viewer, const std::vector<uint8_t> &selected) const;
  // count places of barycentric coordinates, at most sixteen.
  uint16_t places_that_weigh(Viewer &viewer, uint32_t face, const int (*at)[3], int count) const;
  std::vector<uint8_t> weights(Viewer &viewer, const std::vector<uint8_t> &selected,
                               const uint8_t *former) const;

  const Mesh mesh;
  const RayCaster &rays;
  const bool faces; // have bits
  const FitSettings settings;
  std::vector<Vec3> normals;                          // of vertices
  std::vector<double> area;                           // of faces, in those of mean area
  std::vector<uint32_t> first, around;                // of each vertex the faces that use it
  std::unique_ptr<const WeightNeighbours> neighbours; // of weights
};

} // namespace fvv::render
