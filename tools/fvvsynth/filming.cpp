#include "fvvsynth/filming.h"

#include "fvvsynth/look.h"
#include "fvvsynth/random.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

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

std::string label_text(uint16_t camera, size_t frame) {
  char text[40];
  std::snprintf(text, sizeof text, "%02u %04zu", unsigned(camera), frame);
  return text;
}

LabelPlace label_place(const render::Picture &picture) {
  const double height = std::max(10.0, picture.height / 22.0);
  return {0.7 * height, 0.7 * height, 0.74 * height, height};
}

void draw_label(render::Picture &picture, uint16_t camera, size_t frame) {
  const std::string text = label_text(camera, frame);
  const LabelPlace place = label_place(picture);
  constexpr double margin = 0.35, stroke = 0.075; // of the height
  const double right = place.left + place.cell_width * double(text.size()), edge = margin * place.height;
  const auto end = [](double at, uint32_t side) { return std::min(side, uint32_t(at) + 1); };
  for (uint32_t y = uint32_t(place.top - edge); y < end(place.top + place.height + edge, picture.height); y++)
    for (uint32_t x = uint32_t(place.left - edge); x < end(right + edge, picture.width); x++) {
      const double along = (x + 0.5 - place.left) / place.cell_width;
      const size_t cell = size_t(std::clamp(along, 0.0, double(text.size()) - 0.001));
      double distance = 1e9; // from the stroke, in pixels
      if (text[cell] != ' ')
        distance =
            (number_distance(text[cell] - '0', (along - double(cell) - 0.5) * place.cell_width / place.height,
                             0.5 - (y + 0.5 - place.top) / place.height) -
             stroke) *
            place.height;
      const double white = std::clamp(0.5 - distance, 0.0, 1.0);
      for (size_t i = 0; i < 3; i++)
        picture.rgb[3 * (size_t(y) * picture.width + x) + i] = uint8_t(235 * white + 16 * (1 - white) + 0.5);
    }
}

double frame_time(FrameRate rate, size_t frame) {
  return double(frame) * rate.denominator / rate.numerator;
}

// ---- sound -----------------------------------------------------------------------------------------------

namespace {

size_t sample_count(FrameRate rate, size_t frames) {
  return size_t(std::llround(frame_time(rate, frames) * sound_rate));
}

// Adds a decaying tone that begins with its peak.
void strike(std::vector<double> &sound, size_t first, double hertz, double decay, double length,
            double peak) {
  for (size_t i = 0; double(i) < length * sound_rate && first + i < sound.size(); i++) {
    const double t = double(i) / sound_rate;
    sound[first + i] += peak * std::exp(-decay * t) * std::cos(2 * 3.14159265358979323846 * hertz * t);
  }
}

std::vector<int16_t> samples_of(const std::vector<double> &sound) {
  std::vector<int16_t> out;
  for (const double value : sound) out.push_back(int16_t(std::lround(std::clamp(value, -1.0, 1.0) * 32767)));
  return out;
}

} // namespace

bool has_clap(FrameRate rate, size_t frame) {
  // Of seconds, before a frame: ceil(time + 1/2) - 1.
  const auto middles_before = [&](uint64_t number) {
    const uint64_t doubled = 2 * number * rate.denominator + rate.numerator,
                   second = 2 * uint64_t(rate.numerator);
    return (doubled + second - 1) / second - 1;
  };
  return middles_before(frame + 1) > middles_before(frame);
}

std::vector<size_t> clap_samples(FrameRate rate, size_t frames) {
  std::vector<size_t> out;
  for (size_t frame = 0; frame < frames; frame++)
    if (has_clap(rate, frame)) out.push_back(size_t(std::llround(frame_time(rate, frame) * sound_rate)));
  return out;
}

std::vector<int16_t> clicks(const std::vector<size_t> &samples, size_t length) {
  Random random(0xc1a9);
  std::vector<double> sound(length);
  for (double &sample : sound) sample = random.between(-1e-3, 1e-3);
  for (const size_t first : samples) strike(sound, first, 1500, 500, 0.008, 0.8);
  return samples_of(sound);
}

std::vector<int16_t> clap_sound(FrameRate rate, size_t frames) {
  return clicks(clap_samples(rate, frames), sample_count(rate, frames));
}

namespace {

// Adds noise that swells and fades over length seconds. brightness: from 0, dull, to 1.
void rustle(std::vector<double> &sound, size_t first, double length, double brightness, double peak,
            Random &random) {
  double dull = 0;
  for (size_t i = 0; double(i) < length * sound_rate && first + i < sound.size(); i++) {
    const double t = double(i) / (length * sound_rate), white = random.between(-1, 1);
    dull += (white - dull) * 0.25;
    sound[first + i] +=
        peak * 6.75 * t * (1 - t) * (1 - t) * (brightness * (white - dull) + (1 - brightness) * dull);
  }
}

// The samples of moments of a game that goes on until length.
template <class Put> void repeat(const Game &game, double moment, size_t length, const Put &put) {
  for (double time = moment; time * sound_rate < double(length); time += game.duration())
    put(size_t(std::llround(time * sound_rate)));
}

} // namespace

std::vector<int16_t> ball_sound(const Action &action, FrameRate rate, size_t frames, const Game *of_game) {
  std::vector<double> sound(sample_count(rate, frames));
  constexpr size_t step = sound_rate / 1000;
  const auto height = [&](size_t millisecond) { return action.ball_position(double(millisecond) / 1000).y; };
  for (size_t i = 1; i * step < sound.size(); i++)
    if (height(i) < ball_radius + 0.01 && height(i) <= height(i - 1) && height(i) < height(i + 1)) {
      strike(sound, i * step, 95, 22, 0.25, 0.5);
      strike(sound, i * step, 420, 60, 0.1, 0.25);
    }
  if (of_game) {
    Random random(0x4e7);
    repeat(*of_game, of_game->net_time(), sound.size(),
           [&](size_t first) { rustle(sound, first, 0.32, 0.8, 0.35, random); });
  }
  return samples_of(sound);
}

std::vector<int16_t> shoe_sound(const Game &game, FrameRate rate, size_t frames) {
  std::vector<double> sound(sample_count(rate, frames));
  Random random(0x5ee);
  for (const double landing : game.landings()) {
    const bool squeaks = random.below(5) < 2;
    const double hertz = random.between(1900, 2600), length = random.between(0.05, 0.09);
    repeat(game, landing, sound.size(), [&](size_t first) {
      rustle(sound, first, 0.06, 0.2, 0.10, random);
      strike(sound, first, 70, 45, 0.08, 0.10);
      // Rubber that slips and sticks: a tone with overtones whose pitch rises.
      for (size_t i = 0; squeaks && double(i) < length * sound_rate && first + i < sound.size(); i++) {
        const double t = double(i) / sound_rate, u = t / length, swell = 4 * u * (1 - u);
        const double phase = 2 * 3.14159265358979323846 * hertz * t * (1 + 0.12 * u);
        sound[first + i] +=
            0.05 * swell * (std::sin(phase) + 0.5 * std::sin(2 * phase) + 0.3 * std::sin(3 * phase));
      }
    });
  }
  return samples_of(sound);
}

Filming::Filming(const Scene &filmed, const Realism &realism, FrameRate frame_rate, size_t frame,
                 double delay)
    : scene(filmed), wanted(realism), rate(frame_rate), number(frame) {
  const int count = wanted.shutter > 0 ? blur_moments : 1;
  const double open = wanted.shutter * rate.denominator / rate.numerator;
  for (int i = 0; i < count; i++)
    moments.push_back(scene.at(frame_time(rate, frame) + delay + open * (i - count / 2) / count));
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

uint64_t noise_key(uint64_t seed, uint16_t camera, size_t frame, uint64_t take) {
  // A generator of its own for each picture, far from those of its neighbours.
  return Random(seed ^ take << 56 ^ uint64_t(camera) << 40 ^ uint64_t(frame) << 8 ^ 0x5e).next();
}

render::Rgb Filming::gains(size_t camera) const {
  const render::Rgb gains =
      exposure_gains(scene.settings().seed, scene.cameras()[camera].id, wanted.exposure);
  return gains * (wanted.claps && has_clap(rate, number) ? flash_gain : 1.0);
}

render::Picture Filming::shoot(size_t camera, render::SampleBuffer &buffer, double flash) const {
  render::LitPicture lit = gather(camera, buffer);
  render::Picture picture;
  picture.width = lit.width;
  picture.height = lit.height;
  picture.rgb = develop(lit.light, gains(camera) * flash, wanted.noise, key(camera));
  picture.mask = std::move(lit.mask);
  picture.depth = std::move(lit.depth);
  if (wanted.labels) draw_label(picture, scene.cameras()[camera].id, number);
  return picture;
}

render::LitPicture Filming::shoot_linear(size_t camera, render::SampleBuffer &buffer) const {
  render::LitPicture lit = gather(camera, buffer);
  lit.light = develop_linear(lit.light, gains(camera), wanted.noise, key(camera));
  return lit;
}

} // namespace fvv::synth
