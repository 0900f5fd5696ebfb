// Pictures as real cameras take them: noise, exposure, motion blur and labels against what is promised.
#include "fvv_catch.h"

#include "fvvsynth/filming.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

using namespace fvv::synth;
using fvv::render::LightField;
using fvv::render::Picture;
using fvv::render::SampleBuffer;

namespace {

Settings studio(uint32_t width, uint32_t height) {
  Settings settings;
  settings.width = width;
  settings.height = height;
  return settings;
}

double linear(uint8_t value) {
  return value / 255.0 * (value / 255.0);
}

// What the digits of a label cross, each at the middle of a cell's edge or bar: top, middle, bottom, upper
// left, upper right, lower left, lower right. A 7 passes near some.
constexpr std::array<const char *, 10> crossed = {"1011111", "1111000", "1110110", "1110101", "0101101",
                                                  "1111001", "1111011", "1?10?00", "1111111", "1111101"};

std::string read_label(const Picture &picture, size_t characters) {
  const LabelPlace place = label_place(picture);
  std::string text;
  for (size_t i = 0; i < characters; i++) {
    const auto white = [&](double column, double row) { // -1 ... 1, -2 ... 2 from below
      const double x = place.left + (double(i) + 0.5) * place.cell_width + column * 0.25 * place.height,
                   y = place.top + (0.5 - row * 0.25) * place.height;
      return picture.rgb[3 * (size_t(y) * picture.width + size_t(x))] > 120 ? '1' : '0';
    };
    const std::string found = {white(0, 2), white(0, 0),   white(0, -2), white(-1, 1),
                               white(1, 1), white(-1, -1), white(1, -1)};
    const auto digit = std::find_if(crossed.begin(), crossed.end(), [&](const std::string &expected) {
      return std::equal(found.begin(), found.end(), expected.begin(),
                        [](char a, char b) { return a == b || b == '?'; });
    });
    text += digit != crossed.end() ? char('0' + (digit - crossed.begin())) : found == "0000000" ? ' ' : '?';
  }
  return text;
}

} // namespace

TEST_CASE("the variance of noise is a fraction of the signal and a constant, in linear light") {
  constexpr size_t count = 120000;
  for (const double strength : {1.0, 2.0})
    for (const double level : {0.05, 0.2, 0.6}) {
      const LightField flat(count, float(level));
      const std::vector<uint8_t> shot = develop(flat, {1, 1, 1}, strength, 7);
      double sum = 0, squares = 0, neighbours = 0;
      const double expected_mean = std::sqrt(level) * 255;
      for (size_t i = 0; i < count; i++) {
        const double off = shot[i] - expected_mean;
        sum += off;
        squares += off * off;
        neighbours += i ? off * (shot[i - 1] - expected_mean) : 0;
      }
      // 8,000 electrons at white, 5 of reading; a small change of light changes the display value by 255 / (2
      // sqrt(level)) times as much; rounding adds 1/12.
      const double electrons = level * 8000 + 25, slope = 255 / (2 * std::sqrt(level)) / 8000;
      const double expected = strength * strength * electrons * slope * slope + 1 / 12.0;
      INFO("strength " << strength << " level " << level);
      CHECK(squares / count == Approx(expected).epsilon(0.05));
      CHECK(std::abs(sum / count) < 0.15 * strength);
      CHECK(std::abs(neighbours / squares) < 0.015); // pixels and channels are independent
      CHECK(shot != develop(flat, {1, 1, 1}, strength, 8));
    }
  const LightField grey(300, 0.25f);
  CHECK(develop(grey, {1, 1, 1}, 0, 7) == std::vector<uint8_t>(300, 128));
}

TEST_CASE("noise is another one in every frame and camera") {
  const Scene scene(studio(48, 28));
  SampleBuffer buffer(1, 1, 3);
  const Realism noisy{2, 0, 0, false};
  const auto difference = [&](size_t frame, size_t camera) {
    const Picture perfect = scene.picture(camera, scene.at(frame_time({25, 1}, frame)), buffer);
    const Picture taken = Filming(scene, noisy, {25, 1}, frame).shoot(camera, buffer);
    std::vector<int> result;
    for (size_t i = 0; i < 3000; i++) result.push_back(taken.rgb[i] - perfect.rgb[i]);
    return result;
  };
  const auto one = difference(3, 0);
  CHECK(one == difference(3, 0));
  CHECK(one != difference(4, 0));
  CHECK(one != difference(3, 1));
}

TEST_CASE("cameras differ in exposure and white balance by as much as they may, and stay as they are") {
  const Scene scene(studio(96, 54));
  SampleBuffer buffer(1, 1, 3);
  double darkest = 9, brightest = -9;
  for (size_t camera = 0; camera < scene.cameras().size(); camera++) {
    double stops[3] = {};
    for (const size_t frame : {0u, 5u}) {
      const Picture perfect = scene.picture(camera, scene.at(frame_time({25, 1}, frame)), buffer);
      const Picture taken = Filming(scene, {0, 0.6, 0, false}, {25, 1}, frame).shoot(camera, buffer);
      CHECK(taken.mask == perfect.mask);
      for (size_t c = 0; c < 3; c++) {
        double before = 0, after = 0;
        for (size_t i = c; i < taken.rgb.size(); i += 3)
          if (taken.rgb[i] < 250 && perfect.rgb[i] < 250) {
            before += linear(perfect.rgb[i]);
            after += linear(taken.rgb[i]);
          }
        const double found = std::log2(after / before);
        if (frame == 0) stops[c] = found;
        CHECK(found == Approx(stops[c]).margin(0.01));
      }
    }
    CHECK(std::abs(stops[1]) < 0.61);
    CHECK(std::abs(stops[0] - stops[1]) < 0.21);
    CHECK(std::abs(stops[2] - stops[1]) < 0.21);
    darkest = std::min(darkest, stops[1]);
    brightest = std::max(brightest, stops[1]);
  }
  CHECK(brightest - darkest > 0.5);
}

TEST_CASE("motion blur is the mean over the time that the shutter is open, and still things stay sharp",
          "[slow]") {
  const Scene scene(studio(240, 136));
  SampleBuffer buffer(1, 1, 3);
  const double time = 1.12; // the ball is passed
  for (const size_t camera : {0u, 2u}) {
    const Filming filming(scene, {0, 0, 1, false}, {25, 1}, 28);
    CHECK(filming.moment().seconds == Approx(time));
    const Picture sharp = scene.picture(camera, scene.at(time), buffer),
                  blurred = filming.shoot(camera, buffer);
    CHECK(blurred.mask == sharp.mask);
    CHECK(blurred.depth == sharp.depth);
    // Every moment in full.
    constexpr int moments = 9;
    std::vector<double> mean(sharp.rgb.size());
    for (int i = 0; i < moments; i++) {
      const LightField light =
          scene.light(camera, scene.at(time + 0.04 * ((i + 0.5) / moments - 0.5)), buffer).light;
      for (size_t k = 0; k < mean.size(); k++) mean[k] += double(light[k]) / moments;
    }
    double off = 0, moved = 0; // squares of display values
    size_t kept = 0;
    for (size_t k = 0; k < mean.size(); k++) {
      const int expected = fvv::render::to_display(mean[k]), found = blurred.rgb[k], still = sharp.rgb[k];
      off += (found - expected) * (found - expected);
      moved += (found - still) * (found - still);
      kept += std::abs(found - still) <= 1;
    }
    INFO("camera " << camera << " off " << off / double(mean.size()) << " moved "
                   << moved / double(mean.size()) << " kept " << kept);
    // One sample of nine gives each moment's colour: cloth is a little noisier, the rest the same.
    CHECK(off < (scene.moves(camera) ? 0.08 : 0.6) * moved);
    CHECK(off < 6.0 * double(mean.size()));
    if (!scene.moves(camera))
      CHECK(double(kept) > 0.9 * double(mean.size()));
    else
      CHECK(double(kept) < 0.9 * double(mean.size()));
  }
}

TEST_CASE("camera and frame numbers can be read in every picture") {
  CHECK(label_text(3, 12) == "03 0012");
  for (const uint32_t height : {180u, 270u, 540u, 1080u})
    for (const auto &[camera, frame] : {std::pair<uint16_t, size_t>{3, 124}, {56, 789}, {7, 12345}}) {
      Picture picture;
      picture.width = height * 16 / 9;
      picture.height = height;
      picture.rgb.assign(size_t(picture.width) * height * 3, 200);
      const std::vector<uint8_t> before = picture.rgb;
      draw_label(picture, camera, frame);
      const std::string text = label_text(camera, frame);
      CHECK(read_label(picture, text.size()) == text);
      size_t changed = 0;
      for (size_t i = 0; i < before.size(); i++) changed += before[i] != picture.rgb[i];
      CHECK(double(changed) < 0.07 * double(before.size()));
    }
  const Scene scene(studio(480, 270));
  SampleBuffer buffer(1, 1, 3);
  for (const size_t camera : {0u, 6u, 12u}) {
    const Picture picture = Filming(scene, {1, 0.3, 0, true}, {25, 1}, 40).shoot(camera, buffer);
    CHECK(read_label(picture, 7) == label_text(uint16_t(camera), 40));
  }
}

TEST_CASE("a clap in each second is a flash of one frame and a click at its time") {
  for (const FrameRate rate : {FrameRate{25, 1}, FrameRate{30000, 1001}, FrameRate{50, 1}, FrameRate{4, 1}}) {
    std::vector<size_t> frames;
    for (size_t frame = 0; frame_time(rate, frame) < 3; frame++)
      if (has_clap(rate, frame)) frames.push_back(frame);
    REQUIRE(frames.size() == 3);
    for (size_t k = 0; k < 3; k++)
      CHECK(frames[k] == size_t(std::floor((double(k) + 0.5) * rate.numerator / rate.denominator + 1e-9)));
    const std::vector<size_t> samples = clap_samples(rate, frames.back() + 1);
    REQUIRE(samples.size() == 3);
    const std::vector<int16_t> sound = clap_sound(rate, frames.back() + 2);
    CHECK(sound.size() == size_t(std::llround(frame_time(rate, frames.back() + 2) * sound_rate)));
    for (size_t k = 0; k < 3; k++) {
      CHECK(samples[k] == size_t(std::llround(frame_time(rate, frames[k]) * sound_rate)));
      CHECK(std::abs(sound[samples[k] - 1]) < 40);
      CHECK(sound[samples[k]] > 26000);
    }
  }
  const Scene scene(studio(64, 36));
  SampleBuffer buffer(1, 1, 3);
  Realism realism;
  realism.claps = true;
  const FrameRate rate;
  double light[2][2]; // with and without claps, of frames 11 and 12
  for (const bool claps : {false, true})
    for (const size_t frame : {11u, 12u}) {
      realism.claps = claps;
      const Picture picture = Filming(scene, realism, rate, frame).shoot(0, buffer);
      double sum = 0;
      for (const uint8_t value : picture.rgb) sum += linear(value);
      light[claps][frame - 11] = sum;
    }
  CHECK(light[true][0] == light[false][0]);
  CHECK(light[true][1] > 1.8 * light[false][1]);
  const auto ball = ball_sound(scene.action(), rate, 100);
  CHECK(ball.size() == 4 * sound_rate);
  // Each player dribbles and passes once in each half of the cycle.
  size_t thumps = 0, last = 0;
  for (size_t i = 0; i < ball.size(); i++)
    if (std::abs(ball[i]) > 20000) {
      thumps += !last || i - last > sound_rate / 10;
      last = i;
    }
  CHECK(thumps == 4);
}
