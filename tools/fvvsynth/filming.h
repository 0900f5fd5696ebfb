// Pictures of a scene as real cameras take them: motion blur, exposure differences, noise, a label.
#pragma once

#include "fvv_render/picture.h"
#include "fvvsynth/scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace fvv::synth {

// At strength 1 white is 8,000 electrons in each channel, and reading them errs by 5 electrons.
constexpr double white_electrons = 8000, read_electrons = 5;

// Factors of red, green and blue of one camera. Green is 2^e with e even over +-spread stops; red and blue
// are up to a third of spread stops more or less than green. A spread of 0: all 1.
render::Rgb exposure_gains(uint64_t seed, uint16_t camera, double spread);

// Variance of the noise at a level of linear light (1 is white), both in units of white.
double noise_variance(double level, double strength);

// The key of the noise of a picture, unlike for each take, camera and frame. take 0: the action.
uint64_t noise_key(uint64_t seed, uint16_t camera, size_t frame, uint64_t take = 0);

// Display values of light times gains, with noise: about normal (the sum of four uniform numbers),
// independent in every pixel and channel. key: unlike for each picture. strength 0: no noise.
std::vector<uint8_t> develop(const render::LightField &light, render::Rgb gains, double strength,
                             uint64_t key);

// The same as linear light, neither clipped nor rounded to 8 bits.
render::LightField develop_linear(const render::LightField &light, render::Rgb gains, double strength,
                                  uint64_t key);

// Camera and frame numbers in the top left corner of a picture. Their digits are those of the jerseys
// (look.h), drawn with soft edges at any size; the bitmap font of the calibration sheet could not draw the
// same. "03 0012": at least two digits for the camera and four for the frame.
std::string label_text(uint16_t camera, size_t frame);

// Where a label's text lies, in pixels: its characters are cells of cell_width x height, from left on.
struct LabelPlace {
  double left, top, cell_width, height;
};
LabelPlace label_place(const render::Picture &picture);

// Draws white digits on black, as far as the picture reaches.
void draw_label(render::Picture &picture, uint16_t camera, size_t frame);

struct FrameRate { // frames per second, in lowest terms
  uint32_t numerator = 25, denominator = 1;
};

// Deviations from perfect pictures; 0: none.
struct Realism {
  double noise = 0;    // strength, see sensor.h
  double exposure = 0; // stops by which cameras differ from the mean, at most
  double shutter = 0;  // how long it is open, as a fraction of a frame
  bool labels = false;
  bool claps = false; // the light flashes in frames with a clap
};
constexpr double default_noise = 1, default_exposure = 0.3, default_shutter = 0.5;

// One frame, seen by any camera. Several frames may be filmed at the same time, one by one thread each.
class Filming {
public:
  // Motion blur is the mean of this many moments, at equal distances over the time that the shutter is open.
  // The middle one is the frame's own, to which masks, depth, meshes and calibration belong. As many as there
  // are samples in a pixel: each gives the colour of one of them.
  static constexpr int blur_moments = 9;

  // delay: seconds by which the camera's clock is late, so that it films the frame that much later.
  Filming(const Scene &scene, const Realism &realism, FrameRate rate, size_t frame, double delay = 0);
  const Moment &moment() const { return moments[moments.size() / 2]; }
  // buffer: working memory for samples. flash: factor of all light.
  render::Picture shoot(size_t camera, render::SampleBuffer &buffer, double flash = 1) const;
  // The same as linear light, without a label.
  render::LitPicture shoot_linear(size_t camera, render::SampleBuffer &buffer) const;

private:
  render::LitPicture gather(size_t camera, render::SampleBuffer &buffer) const;
  render::Rgb gains(size_t camera) const;
  uint64_t key(size_t camera) const {
    return noise_key(scene.settings().seed, scene.cameras()[camera].id, number);
  }

  const Scene &scene;
  Realism wanted;
  FrameRate rate;
  size_t number;
  std::vector<Moment> moments;
};

constexpr double flash_gain = 2.5; // of a frame with a clap: times the light of other frames

// Seconds from the beginning to a frame.
double frame_time(FrameRate rate, size_t frame);

// Once a second there is a clap, at the time of one frame: the last one that is not after the middle of the
// second.
bool has_clap(FrameRate rate, size_t frame);

constexpr uint32_t sound_rate = 48000; // samples a second of the sounds below, which have one channel
// The samples at which the claps of these frames begin.
std::vector<size_t> clap_samples(FrameRate rate, size_t frames);
// A click of 8 ms at each of these samples, in faint noise.
std::vector<int16_t> clicks(const std::vector<size_t> &samples, size_t length);
// clicks() at the claps of these frames, as long as these.
std::vector<int16_t> clap_sound(FrameRate rate, size_t frames);
// A thump whenever the ball meets the floor, as heard at the ball. of_game: the net too.
std::vector<int16_t> ball_sound(const Action &action, FrameRate rate, size_t frames,
                                const Game *of_game = nullptr);
// Shoes: steps, some of which squeak.
std::vector<int16_t> shoe_sound(const Game &game, FrameRate rate, size_t frames);

} // namespace fvv::synth
