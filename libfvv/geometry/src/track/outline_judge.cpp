#include "geometry/src/track/outline_judge.h"
#include "fvv_geometry/pieces.h"
#include "fvv_geometry/silhouette.h"

#include <algorithm>
#include <cmath>

namespace fvv::track {

namespace {

// Of a point on a hull from the outline that made it, pixels. Where limbs are a few pixels wide, every
// surface is within a pixel of some outline.
constexpr double on_outline = 0.25;

// Of the outline's length, in pixels of the mask: as many more than of the key frame may be far from it.
constexpr double most_far = 0.05;

std::vector<geometry::MaskDifference> differences(const geometry::Mesh &mesh,
                                                  const std::vector<MaskView> &masks, double tolerance) {
  const geometry::ViewedSurface surface(mesh.positions, mesh.faces);
  std::vector<geometry::MaskDifference> out;
  for (const MaskView &view : masks)
    out.push_back(geometry::difference(surface.cover(view.camera), view.inside, view.camera.width,
                                       view.camera.height, decimate::max_over_rms * tolerance / view.scale));
  return out;
}

} // namespace

OutlineJudge::OutlineJudge(const std::vector<MaskView> &of, const geometry::Mesh &own, double pixels)
    : masks(of), tolerance(pixels), of_own(differences(own, of, pixels)) {}

bool OutlineJudge::accepts(const geometry::Mesh &tracked) const {
  const std::vector<geometry::MaskDifference> found = differences(tracked, masks, tolerance);
  bool seen = false;
  for (size_t i = 0; i < masks.size(); i++) {
    const geometry::MaskDifference &own = of_own[i], &here = found[i];
    const double area = tolerance / masks[i].scale * own.length, far = most_far * own.length;
    seen = seen || own.length > 0;
    if (here.missed > own.missed + area || here.extra > own.extra + area || here.far > own.far + far)
      return false;
  }
  return seen;
}

double fraction_on_outlines(const geometry::Mesh &mesh, const std::vector<MaskView> &masks) {
  std::vector<hull::Silhouette> silhouettes;
  for (const MaskView &view : masks) silhouettes.emplace_back(view.camera, view.inside);
  std::vector<bool> on(mesh.vertex_count());
  for (size_t v = 0; v < on.size(); v++)
    on[v] = std::any_of(silhouettes.begin(), silhouettes.end(), [&](const hull::Silhouette &silhouette) {
      const hull::Silhouette::View view = silhouette.view(&mesh.positions[3 * v]);
      return view.seen && std::abs(view.pixels) <= on_outline;
    });
  double all = 0, part = 0;
  for (size_t f = 0; f < mesh.face_count(); f++) {
    const double third = decimate::face_area(mesh, f) / 3;
    all += 3 * third;
    for (size_t k = 0; k < 3; k++) part += on[mesh.faces[3 * f + k]] ? third : 0;
  }
  return all > 0 ? part / all : 0;
}

} // namespace fvv::track
