#include "fvvsynth/sensor.h"

#include "fvvsynth/random.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

render::Rgb exposure_gains(uint64_t seed, uint16_t camera, double spread) {
  Random random(seed * 0x9e3779b97f4a7c15u ^ (uint64_t(camera) + 1) << 32);
  const double stops = random.between(-spread, spread), red = random.between(-spread, spread) / 3,
               blue = random.between(-spread, spread) / 3;
  return {std::exp2(stops + red), std::exp2(stops), std::exp2(stops + blue)};
}

double noise_variance(double level, double strength) {
  const double read = read_electrons / white_electrons;
  return strength * strength * (std::max(0.0, level) / white_electrons + read * read);
}

namespace {

// put(i, level): of each value of light, in order.
template <class Put>
void expose(const render::LightField &light, render::Rgb gains, double strength, uint64_t key,
            const Put &put) {
  const double gain[3] = {gains.x, gains.y, gains.z};
  if (strength == 0) {
    for (size_t i = 0; i < light.size(); i++) put(i, double(light[i]) * gain[i % 3]);
    return;
  }
  Random random(key);
  // Four numbers of 16 bits have the mean 2 * 65535 and the variance (65536^2 - 1) / 3.
  constexpr double mean = 2 * 65535.0, deviation = 37837.22723720648;
  for (size_t i = 0; i < light.size(); i++) {
    const double level = double(light[i]) * gain[i % 3];
    const uint64_t bits = random.next();
    const uint64_t sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
    const double normal = (double(sum) - mean) * (1 / deviation);
    put(i, level + std::sqrt(noise_variance(level, strength)) * normal);
  }
}

} // namespace

std::vector<uint8_t> develop(const render::LightField &light, render::Rgb gains, double strength,
                             uint64_t key) {
  std::vector<uint8_t> out(light.size());
  expose(light, gains, strength, key, [&](size_t i, double level) { out[i] = render::to_display(level); });
  return out;
}

render::LightField develop_linear(const render::LightField &light, render::Rgb gains, double strength,
                                  uint64_t key) {
  render::LightField out(light.size());
  expose(light, gains, strength, key, [&](size_t i, double level) { out[i] = float(level); });
  return out;
}

} // namespace fvv::synth
