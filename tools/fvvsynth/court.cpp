#include "fvvsynth/court.h"

#include "fvvsynth/random.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

namespace {

using render::Rgb;

double line(double distance) {
  return 1 - smoothstep(0.024, 0.028, std::abs(distance));
}

// Maple boards along x.
Rgb wood(double x, double z, uint32_t key) {
  constexpr double width = 0.095, board_length = 1.6;
  const int32_t row = int32_t(std::floor(z / width));
  const double shifted = x + 5 * cell_value(row, 0, 0, key);
  const int32_t board = int32_t(std::floor(shifted / board_length));
  const double tone = cell_value(row, board, 1, key);
  const double grain = turbulence({x * 2.2, z * 38, double(row)}, key + 1);
  const double joint = std::min(z / width - row, 1 - (z / width - row)) * width;
  const double end = shifted - board * board_length;
  const double gap = smoothstep(0.0, 0.004, std::min(joint, std::min(end, board_length - end)));
  const Rgb base = mix(Rgb{0.50, 0.29, 0.13}, Rgb{0.60, 0.38, 0.19}, tone);
  return base * ((0.78 + 0.34 * grain) * (0.6 + 0.4 * gap));
}

// Paint: a lane with its circle to one side, a side line, a half-way circle.
Rgb floor_colour(double x, double z, uint32_t key) {
  Rgb colour = wood(x, z, key);
  const Rgb white{0.80, 0.79, 0.76}, lane{0.10, 0.17, 0.36};
  const double to_spot = std::sqrt((x - 1.6) * (x - 1.6) + z * z),
               to_middle = std::sqrt((x + 3.4) * (x + 3.4) + z * z);
  const bool in_lane = x > 1.6 && std::abs(z) < 1.8;
  if (in_lane) colour = mix(colour, lane * (0.8 + 0.4 * colour.x), 0.85);
  if (to_middle < 1.2) colour = mix(colour, Rgb{0.42, 0.07, 0.06} * (0.8 + 0.4 * colour.x), 0.85);
  double painted = std::max(line(to_spot - 1.8), std::max(line(to_middle - 1.8), line(to_middle - 1.2)));
  if (x > 1.57) painted = std::max(painted, line(std::abs(z) - 1.8));
  if (std::abs(z) < 1.83) painted = std::max(painted, line(x - 1.6));
  painted = std::max(painted, std::max(line(x + 3.4), line(std::abs(z) - 3.6)));
  return mix(colour, white * (0.85 + 0.3 * colour.x), painted);
}

Rgb seen(Vec3 eye, Vec3 direction, uint32_t key) {
  const double rise = direction.y / std::sqrt(direction.x * direction.x + direction.z * direction.z + 1e-12);
  const Rgb low{0.30, 0.31, 0.34}, high{0.055, 0.065, 0.09};
  const Rgb wall = mix(low, high, smoothstep(-0.30, 0.55, rise));
  if (direction.y > -1e-6) return wall;
  const Vec3 at = eye + direction * (-eye.y / direction.y);
  const double distance = std::sqrt(at.x * at.x + at.z * at.z);
  const double far_off = smoothstep(5.5, 9.0, distance);
  if (far_off >= 1) return wall;
  const double lamp = 1.05 - 0.45 * smoothstep(0.5, 7, distance);
  return mix(floor_colour(at.x, at.z, key) * lamp, wall, far_off);
}

} // namespace

std::vector<Rgb> draw_court(const render::Projection &camera, uint32_t key) {
  std::vector<Rgb> picture;
  picture.reserve(size_t(camera.width()) * camera.height());
  const Vec3 eye = camera.centre();
  const int samples = camera.width() < 960 ? 5 : 3;
  for (uint32_t y = 0; y < camera.height(); y++)
    for (uint32_t x = 0; x < camera.width(); x++) {
      Rgb sum;
      for (int j = 0; j < samples; j++)
        for (int i = 0; i < samples; i++)
          sum += seen(eye,
                      camera.to_world_direction(camera.ray(x + (i + 0.5) / samples, y + (j + 0.5) / samples)),
                      key);
      picture.push_back(sum * (1.0 / (samples * samples)));
    }
  return picture;
}

} // namespace fvv::synth
