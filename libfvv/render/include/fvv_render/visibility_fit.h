// Visibility weights chosen for the least error against rays after the interpolation that players do
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
  double cosine = 0.25;    // places with less weight are ignored
  double bit = 0.0275;     // of a bit of the stream
  double change = 0;       // of a weight that is not the former one; a quarter where it stays on its side
  double tolerance = 0.05; // of the search: changes that are worse by up to this are accepted at first
};

// Of one mesh, for any number of cameras.
class VisibilityFit {
public:
  // Borrows mesh and rays, which is of mesh.
  VisibilityFit(const Mesh &mesh, const RayCaster &rays, const FitSettings &settings);
  ~VisibilityFit();

  // FVV_VERTEX_... of each vertex. Begins with the result of rays for most of what is around it, and changes
  // states as long as that reduces the sum of errors and prices. selected: from fvv_visibility_facing.
  // former: NULL, or FVV_VERTEX_... of each vertex the time before. The same on every machine for any order
  // of cameras.
  std::vector<uint8_t> states(const fvv_camera &camera, const std::vector<uint8_t> &selected,
                              const uint8_t *former) const;

private:
  // Faces for which a camera may be used: those that face it, by enough with the normals of their vertices.
  std::vector<uint8_t> faces_to_judge(const Viewer &viewer) const;
  uint16_t places_that_weigh(Viewer &viewer, uint32_t face) const;

  const Mesh mesh;
  const RayCaster &rays;
  const FitSettings settings;
  std::vector<Vec3> normals;           // of vertices
  std::vector<double> area;            // of faces, in those of mean area
  std::vector<uint32_t> first, around; // of each vertex the faces that use it
  std::unique_ptr<const WeightNeighbours> neighbours;
};

} // namespace fvv::render
