#include "fvvsynth/studio.h"

#include "fvvsynth/paint.h"
#include "fvvsynth/random.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::synth {

namespace {

constexpr double overhead_height = 4; // cameras above hang from the ceiling

Props furnished(const std::vector<fvv_camera> &cameras, std::vector<size_t> &tripods) {
  Props props;
  size_t number = 0;
  for (const fvv_camera &camera : cameras) {
    double centre[3];
    fvv_camera_centre(&camera, centre);
    const bool stands = centre[1] < overhead_height;
    tripods.push_back(stands ? number++ : SIZE_MAX);
    if (stands)
      props.add_camera({centre[0], centre[1], centre[2]},
                       {camera.rotation[6], camera.rotation[7], camera.rotation[8]});
  }
  return props;
}

Texture make_ground(uint32_t key, double texel, const std::vector<Spot> &spots, uint32_t threads) {
  const auto row = [&](double t) {
    const double z = t - room_width / 2;
    std::vector<Spot> near;
    for (const Spot &spot : spots)
      if (std::abs(spot.z - z) < 2 * spot.radius) near.push_back(spot);
    return [=](double s) {
      const double x = s - room_length / 2;
      double shade = 1;
      for (const Spot &spot : near) {
        const double distance = std::sqrt((x - spot.x) * (x - spot.x) + (z - spot.z) * (z - spot.z));
        shade *= 1 - spot.depth * (1 - smoothstep(0, 2 * spot.radius, distance));
      }
      return floor_colour(x, z, key) * shade;
    };
  };
  return {room_length, room_width, texel, row, threads};
}

Texture make_wall(int wall, uint32_t key, double texel, uint32_t threads) {
  const auto row = [=](double t) { return [=](double s) { return wall_colour(wall, s, t, key); }; };
  return {wall < 2 ? room_width : room_length, room_height, texel, row, threads};
}

} // namespace

Studio::Studio(uint32_t key, double texel, const std::vector<fvv_camera> &cameras, const render::Light &lamps,
               uint32_t threads)
    : light(lamps), props(furnished(cameras, tripods)),
      ground(make_ground(key, texel, props.spots(), threads)), walls{make_wall(0, key, 2 * texel, threads),
                                                                     make_wall(1, key, 2 * texel, threads),
                                                                     make_wall(2, key, 2 * texel, threads),
                                                                     make_wall(3, key, 2 * texel, threads)} {}

// The wall or ceiling that a ray meets. Its footprint grows with the distance by footprint_per_metre and is
// at least blur.
Rgb Studio::wall(Vec3 from, Vec3 direction, double footprint_per_metre, double blur) const {
  const auto reach = [](double at, double way, double side) {
    return way == 0 ? std::numeric_limits<double>::infinity() : ((way > 0 ? side : -side) - at) / way;
  };
  const double to_x = reach(from.x, direction.x, room_length / 2),
               to_z = reach(from.z, direction.z, room_width / 2);
  const double t = std::min(to_x, to_z);
  const Vec3 at = from + direction * t;
  if (at.y > room_height) return {0.012, 0.012, 0.014};
  const double footprint = std::max(blur, t * length(direction) * footprint_per_metre);
  if (to_x < to_z) {
    const bool positive = direction.x > 0; // written as seen from inside, left to right
    return walls[positive ? 0 : 1].at(room_width / 2 + (positive ? at.z : -at.z), at.y, footprint);
  }
  const bool positive = direction.z > 0;
  return walls[positive ? 2 : 3].at(room_length / 2 + (positive ? -at.x : at.x), at.y, footprint);
}

// pixel: metres that a sample covers at 1 m.
Rgb Studio::at(Vec3 eye, Vec3 direction, double pixel) const {
  const double t = direction.y < 0 ? -eye.y / direction.y : std::numeric_limits<double>::infinity();
  const Vec3 at = eye + direction * t;
  if (!(std::abs(at.x) < room_length / 2 && std::abs(at.z) < room_width / 2))
    return wall(eye, direction, pixel, 0);
  const double size = length(direction), slope = -direction.y / size;
  // A pixel covers much of the floor along the view and little across: between the two, as far as 2 x 2
  // samples keep the rest from aliasing.
  const double across = t * size * pixel, along = across / slope;
  const Rgb boards = ground.at(at.x + room_length / 2, at.z + room_width / 2, std::max(across, along / 3));
  // Varnish mirrors the walls, blurred, the more the flatter the view (Schlick, "An inexpensive BRDF model
  // for physically-based rendering", 1994).
  const double flat = 1 - slope, mirrored = 0.03 + 0.55 * flat * flat * flat * flat * flat;
  const Rgb reflection = wall(at, {direction.x, -direction.y, direction.z}, 0.06, 0.10);
  return mix(boards, reflection, mirrored);
}

render::LightField Studio::seen(const render::Projection &camera, size_t own, render::SampleBuffer &buffer,
                                std::optional<uint32_t> part) const {
  constexpr uint32_t samples = 2;
  const Vec3 eye = camera.centre();
  render::LightField picture;
  picture.reserve(size_t(camera.width()) * camera.height() * 3);
  const double middle_x = camera.width() / 2.0, middle_y = camera.height() / 2.0;
  const double pixel =
      length(camera.ray(middle_x + 0.5, middle_y) - camera.ray(middle_x - 0.5, middle_y)) / samples;
  const auto from = [&](uint32_t x, uint32_t y, uint32_t place) {
    const double u = x + (place % samples + 0.5) / samples, v = y + (place / samples + 0.5) / samples;
    return at(eye, camera.to_world_direction(camera.ray(u, v)), pixel);
  };
  for (uint32_t y = 0; y < camera.height(); y++)
    for (uint32_t x = 0; x < camera.width(); x++) {
      Rgb colour;
      for (uint32_t place = 0; place < samples * samples; place++)
        colour += from(x, y, place) * (1.0 / (samples * samples));
      picture.insert(picture.end(), {float(colour.x), float(colour.y), float(colour.z)});
    }
  return props.draw(camera, own < tripods.size() ? tripods[own] : SIZE_MAX, light, std::move(picture), buffer,
                    part);
}

} // namespace fvv::synth
