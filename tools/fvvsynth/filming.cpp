#include "fvvsynth/filming.h"

#include "fvvsynth/label.h"
#include "fvvsynth/sensor.h"

#include <utility>

namespace fvv::synth {

double frame_time(FrameRate rate, size_t frame) {
  return double(frame) * rate.denominator / rate.numerator;
}

Filming::Filming(const Scene &filmed, const Realism &realism, FrameRate rate, size_t frame)
    : scene(filmed), wanted(realism), number(frame) {
  const int count = wanted.shutter > 0 ? blur_moments : 1;
  const double open = wanted.shutter * rate.denominator / rate.numerator;
  for (int i = 0; i < count; i++)
    moments.push_back(scene.at(frame_time(rate, frame) + open * (i - count / 2) / count));
}

render::LitPicture Filming::gather(size_t camera, render::SampleBuffer &buffer) const {
  render::LitPicture lit;
  if (moments.size() == 1) {
    lit = scene.light(camera, moment(), buffer);
  } else {
    render::LightField sum;
    for (uint32_t i = 0; i < moments.size(); i++) {
      // Samples in an order in which neither column nor row goes with the time.
      render::LitPicture one = scene.light(camera, moments[i], buffer, i * 4 % blur_moments);
      sum.resize(one.light.size());
      for (size_t k = 0; k < sum.size(); k++) sum[k] += one.light[k] * (1.0f / blur_moments);
      if (&moments[i] == &moment()) lit = std::move(one);
    }
    lit.light = std::move(sum);
  }
  return lit;
}

uint64_t Filming::noise_key(size_t camera) const {
  // A generator of its own for each picture, far from those of its neighbours.
  const uint64_t id = scene.cameras()[camera].id;
  return Random(scene.settings().seed ^ id << 40 ^ uint64_t(number) << 8 ^ 0x5e).next();
}

render::Rgb Filming::gains(size_t camera) const {
  return exposure_gains(scene.settings().seed, scene.cameras()[camera].id, wanted.exposure);
}

render::Picture Filming::shoot(size_t camera, render::SampleBuffer &buffer) const {
  render::LitPicture lit = gather(camera, buffer);
  render::Picture picture;
  picture.width = lit.width;
  picture.height = lit.height;
  picture.rgb = develop(lit.light, gains(camera), wanted.noise, noise_key(camera));
  picture.mask = std::move(lit.mask);
  picture.depth = std::move(lit.depth);
  if (wanted.labels) draw_label(picture, scene.cameras()[camera].id, number);
  return picture;
}

render::LitPicture Filming::shoot_linear(size_t camera, render::SampleBuffer &buffer) const {
  render::LitPicture lit = gather(camera, buffer);
  lit.light = develop_linear(lit.light, gains(camera), wanted.noise, noise_key(camera));
  return lit;
}

} // namespace fvv::synth
