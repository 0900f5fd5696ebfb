// What a sensor makes of light: exposure, white balance, noise. Knows pictures; knows no scene.
#pragma once

#include "fvv_render/picture.h"

#include <cstdint>
#include <vector>

namespace fvv::synth {

// At strength 1 white is 8,000 electrons in each channel, and reading them errs by 5 electrons.
constexpr double white_electrons = 8000, read_electrons = 5;

// Factors of red, green and blue of one camera. Green is 2^e with e even over +-spread stops; red and blue
// are up to a third of spread stops more or less than green. A spread of 0: all 1.
render::Rgb exposure_gains(uint64_t seed, uint16_t camera, double spread);

// Variance of the noise at a level of linear light (1 is white), both in units of white.
double noise_variance(double level, double strength);

// Display values of light times gains, with noise: about normal (the sum of four uniform numbers),
// independent in every pixel and channel. key: unlike for each picture. strength 0: no noise.
std::vector<uint8_t> develop(const render::LightField &light, render::Rgb gains, double strength,
                             uint64_t key);

// The same as linear light, neither clipped nor rounded to 8 bits.
render::LightField develop_linear(const render::LightField &light, render::Rgb gains, double strength,
                                  uint64_t key);

} // namespace fvv::synth
