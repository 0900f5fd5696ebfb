// What a target camera sees at each sample of its picture: rasterised without a lens, by rays with one.
#pragma once

#include "fvv_render/triangle_tree.h"

#include <limits>
#include <optional>

namespace fvv::render {

struct Hit {
  uint32_t face = no_face;
  std::array<double, 3> barycentric = {};
  double depth = std::numeric_limits<double>::infinity();
};

class Surface {
public:
  // Borrows mesh and rays; rays: of the mesh, NULL for a target without a lens.
  Surface(const fvv_camera &target, const Mesh &drawn, const RayCaster *caster, uint32_t samples);
  Hit at(uint32_t x, uint32_t y, uint32_t sample) const;

private:
  const Projection projection;
  const Mesh &mesh;
  const RayCaster *rays;
  uint32_t n;
  double nearest = 0; // to the camera, for rays
  std::optional<SampleBuffer> buffer;
};

} // namespace fvv::render
