// The cameras around the scene.
#pragma once

#include "fvv/calibration.h"
#include "fvvsynth/random.h"

#include <optional>
#include <string>
#include <vector>

namespace fvv::synth {

enum class RigKind { small, studio, arc };

struct Rig {
  std::vector<fvv_camera> cameras;
  std::vector<std::string> names;    // one for each; the cameras do not point to them
  std::optional<size_t> moving = {}; // the camera that pans, tilts and zooms
};

// camera turned about its own centre to look at target, with zoom times its focal lengths. The principal
// point and the lens stay.
fvv_camera turned(const fvv_camera &camera, Vec3 target, double zoom);

// count cameras cam0, cam1, ... on an oval about 5.3 m from its centre, 1.5 to 3 m high, turned to the
// action, each a little different in focal length and principal point, without distortion; a pixel covers
// about 14 mm in pictures 480 wide.
Rig make_small_rig(Random &random, uint32_t count, uint32_t width, uint32_t height);

// count alike cameras view0, view1, ... one degree apart on an arc 4.5 m from the middle and 1.7 m high,
// turned to it: a viewer who walks around the action, to compare drawn pictures with. Does not use up
// randomness.
Rig make_arc_rig(uint32_t count, uint32_t width, uint32_t height);

// How cameras are turned and zoomed to what is filmed.
struct Framing {
  double above = 0;      // metres by which they look higher
  double zoom = 1;       // times the focal lengths
  double head_above = 0; // metres by which head0 and head1 look higher than that
  double overhead_height = 7;
};

// 13 cameras: oval0 ... oval9 on an oval at 2.5 m height, head0 and head1 at 1.7 m, and overhead, which sees
// outlines only and is not meant for texture. Focal lengths differ by up to 1.6 times; most pictures have the
// given size, some 2/3 or 4/3 of it; seven lenses distort (radtan, k1 from -0.2 to 0.1, tangential
// terms). A pixel covers about 7 mm in pictures 960 wide. oval2 moves later; here it has its
// shortest focal length, for which its lens is valid up to the corners.
Rig make_studio_rig(Random &random, uint32_t width, uint32_t height, Framing framing = {});
constexpr const char *overhead = "overhead";
constexpr uint32_t studio_max_side = 3072; // 4/3 of it is the largest picture

} // namespace fvv::synth
