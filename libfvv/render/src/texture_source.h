// One camera as source of texture: whether it can show a point of the surface, where, and in which colour.
// Knows one camera; knows nothing of the others, or of weights.
#pragma once

#include "fvv_render/view.h"

namespace fvv::render {

struct SurfacePoint {
  uint32_t face = no_face;
  Vec3 position, face_normal; // the normal of any length
  std::array<uint32_t, 3> vertices = {};
  std::array<double, 3> barycentric = {};
};

class TextureSource {
public:
  // Borrows view's pixels and visibility, and rays.
  TextureSource(const SourceView &view, const Mesh &mesh, const RayCaster &rays, const ViewOptions &options);

  Vec3 centre() const { return place; }
  // at: the position in the source's pixels.
  bool shows(const SurfacePoint &point, double at[2]) const;
  // Bilinear, display values, 1 for white; beyond the centres of the outermost pixels theirs.
  Vec3 colour(const double at[2]) const;

private:
  const SourceView view;
  const RayCaster &rays;
  const double margin;
  Visibility visibility;
  Vec3 place;
  std::optional<DepthMap> map;
};

} // namespace fvv::render
