// Pictures of a scene as real cameras take them: motion blur, exposure differences, noise, a label. Knows the
// scene and its times; knows no files.
#pragma once

#include "fvvsynth/scene.h"

namespace fvv::synth {

struct FrameRate { // frames per second, in lowest terms
  uint32_t numerator = 25, denominator = 1;
};

// What is asked for besides perfect pictures; each 0: not at all.
struct Realism {
  double noise = 0;    // strength, see sensor.h
  double exposure = 0; // stops by which cameras differ from the mean, at most
  double shutter = 0;  // how long it is open, as a share of a frame
  bool labels = false;
};
constexpr double default_noise = 1, default_exposure = 0.3, default_shutter = 0.5;

// One frame, seen by any camera. Several frames may be filmed at the same time, one by one thread each.
class Filming {
public:
  // Motion blur is the mean of so many moments, at equal distances over the time that the shutter is open.
  // The middle one is the frame's own, to which masks, depth, meshes and calibration belong. As many as there
  // are samples in a pixel: each gives the colour of one of them.
  static constexpr int blur_moments = 9;

  Filming(const Scene &scene, const Realism &realism, FrameRate rate, size_t frame);
  const Moment &moment() const { return moments[moments.size() / 2]; }
  // buffer: working memory for samples.
  render::Picture shoot(size_t camera, render::SampleBuffer &buffer) const;
  // The same as linear light, without a label.
  render::LitPicture shoot_linear(size_t camera, render::SampleBuffer &buffer) const;

private:
  render::LitPicture gather(size_t camera, render::SampleBuffer &buffer) const;
  uint64_t noise_key(size_t camera) const;
  render::Rgb gains(size_t camera) const;

  const Scene &scene;
  Realism wanted;
  size_t number;
  std::vector<Moment> moments;
};

// Seconds from the beginning to a frame.
double frame_time(FrameRate rate, size_t frame);

} // namespace fvv::synth
