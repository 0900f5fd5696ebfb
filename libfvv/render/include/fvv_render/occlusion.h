// Whether anything of the mesh is between a point of its surface and a camera. Two ways to find out: a depth
// map for each camera, as players have it, and rays, which are the reference.
#pragma once

#include "fvv_render/triangle_tree.h"

#include <optional>

namespace fvv::render {

// How a depth map is drawn and compared. All lengths are in pixels of the given camera.
struct DepthTest {
  uint32_t samples = 3; // of the map, along a pixel's side: 1, 3, 5 or 7
  // A point is hidden when it lies behind the nearest sample of the map by more than the width of bias pixels
  // at that distance plus slope times the change of depth of its surface from one pixel to the next. The
  // sample is at most 0.24 pixels away when there are 3: half a pixel's slope leaves room for curvature.
  // Against rays, over points whose face and normal are turned to the camera, 0.11 to 0.14 % are hidden
  // wrongly and 0.17 to 0.37 % shown wrongly (480x270 and 1024x768).
  double bias = 0.2, slope = 0.5;
};

// The depth map of one camera. It is drawn without the lens, in a pinhole camera of the same pose that covers
// what the lens shows, so that edges are straight and faces are clipped as for any pinhole.
class DepthMap {
public:
  // camera is valid. Neither it nor mesh is referenced later.
  DepthMap(const fvv_camera &camera, const Mesh &mesh, const DepthTest &test);

  // Whether the lens shows so much that no plane can hold it (more than 76 degrees off the axis, a side of
  // more than 16384 pixels, 2^28 samples): then there is no map, and rays decide.
  bool too_wide() const { return !projection; }

  // A point of the surface, and the normal (of any length) of the face that it lies on. A point outside the
  // map, or nearer than near_plane() to the camera's plane, is hidden.
  bool hidden(Vec3 point, Vec3 face_normal) const;

private:
  void crop(const SampleBuffer &buffer);

  std::optional<Projection> projection;
  DepthTest test;
  double nearest;                      // to the camera that is drawn
  double breadth_x = 0, breadth_y = 0; // of a pixel at a distance of 1 in the centre of the lens
  size_t columns = 0, rows = 0;        // samples of the whole map
  size_t left = 0, top = 0, width = 0; // the part that was drawn, which is kept
  std::vector<float> depth;
};

// The part of a ray next to the surface in which hits are ignored: positions are rounded to float, and
// neighbours of the face meet it there.
constexpr double ray_start = 1e-5;
// Where a ray from a camera's centre to a point of a surface ends.
inline Vec3 before(Vec3 centre, Vec3 point) {
  return mix(point, centre, ray_start);
}

// The reference: whether the ray from the camera's centre to the point, which lies on that face, meets
// another face before it. rays is of the mesh.
bool hidden_by_rays(Vec3 centre, Vec3 point, uint32_t face, const RayCaster &rays);

} // namespace fvv::render
