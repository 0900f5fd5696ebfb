// capture/gltf/animation.h: channels of an animation (glTF 2.0 clause 3.11 and appendix C): keyframes of one
// property of one node, and its value at any time. Knows numbers and times; what they move is the scene's
// matter.
#pragma once

#include "capture/gltf/accessor.h"

namespace fvv::capture::gltf {

enum class Path { translation, rotation, scale, weights };
enum class Interpolation { step, linear, cubic_spline };

struct Channel {
  uint32_t node;
  Path path;
  Interpolation interpolation;
  size_t width;               // numbers of a value
  std::vector<double> times;  // seconds, increasing
  std::vector<double> values; // width per time; cubic_spline: in-tangent, value, out-tangent
  std::string place;          // for messages

  // width numbers; before the first time and behind the last one those of the nearest. Rotations come with
  // length 1; FileError when one has no direction.
  std::vector<double> at(double time) const;
};

// sampler: an item of samplers. width 0: a channel of weights whose node has no morph targets.
Channel read_channel(Container &container, const JsonValue &channel, const JsonValue &samplers, Path path,
                     size_t width);

} // namespace fvv::capture::gltf
