#include "fvvsynth/environment.h"

#include "fvv_media/image.h"
#include "fvv_scene/environment.h"
#include "fvvsynth/paint.h"

#include <algorithm>

namespace fvv::synth {

namespace {

constexpr uint32_t floor_columns = 768, wall_columns = 640;
constexpr int quality = 80;
constexpr double lux = 1000; // of all lamps together, about

// A painted rectangle of width x height metres into rows of a picture; t grows with the rows, or against
// them.
void paint(const Texture &texture, double width, double height, bool upwards, uint32_t top, uint32_t rows,
           media::Image &picture) {
  const double across = width / picture.width, along = height / rows;
  for (uint32_t y = 0; y < rows; y++)
    for (uint32_t x = 0; x < picture.width; x++) {
      const double t = (y + 0.5) * along;
      const Rgb light = texture.at((x + 0.5) * across, upwards ? height - t : t, std::max(across, along));
      uint8_t *pixel = &picture.pixels[3 * (size_t(top + y) * picture.width + x)];
      pixel[0] = render::to_display(light.x);
      pixel[1] = render::to_display(light.y);
      pixel[2] = render::to_display(light.z);
    }
}

std::string jpeg(const media::Image &picture) {
  const std::vector<uint8_t> bytes = media::encode_jpeg(picture, quality, media::Subsampling::yuv420);
  return {bytes.begin(), bytes.end()};
}

// Corners counter-clockwise as seen, the first at the top left of its rectangle of the picture.
void add_quad(geometry::Mesh &mesh, const Vec3 (&corners)[4], double top, double bottom) {
  const uint32_t base = uint32_t(mesh.vertex_count());
  const double uv[4][2] = {{0, top}, {0, bottom}, {1, bottom}, {1, top}};
  for (size_t i = 0; i < 4; i++) {
    mesh.positions.insert(mesh.positions.end(), {corners[i].x, corners[i].y, corners[i].z});
    mesh.texture.insert(mesh.texture.end(), {uv[i][0], uv[i][1]});
  }
  mesh.faces.insert(mesh.faces.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
}

constexpr double x = room_length / 2, z = room_width / 2, h = room_height;

scene::EnvironmentPart shown_as_it_is(size_t picture) {
  scene::EnvironmentPart part;
  part.picture = picture;
  part.unlit = part.clamped = true;
  return part;
}

void add_floor(uint32_t key, uint32_t threads, scene::Environment &out) {
  const auto row = [key](double t) { return [=](double s) { return floor_colour(s - x, t - z, key); }; };
  const double texel = room_length / floor_columns / 2;
  media::Image picture =
      media::make_image<uint8_t>(floor_columns, uint32_t(floor_columns * room_width / room_length), 3, 0);
  paint({room_length, room_width, texel, row, threads}, room_length, room_width, false, 0, picture.height,
        picture);
  scene::EnvironmentPart part = shown_as_it_is(out.pictures.size());
  add_quad(part.mesh, {{-x, 0, -z}, {-x, 0, z}, {x, 0, z}, {x, 0, -z}}, 0, 1);
  out.pictures.push_back(jpeg(picture));
  out.parts.push_back(std::move(part));
}

// One picture of four strips. A wall is written as seen from inside, left to right.
void add_walls(uint32_t key, uint32_t threads, scene::Environment &out) {
  constexpr uint32_t rows = 272;
  const Vec3 left[4] = {{x, 0, -z}, {-x, 0, z}, {x, 0, z}, {-x, 0, -z}},
             right[4] = {{x, 0, z}, {-x, 0, -z}, {-x, 0, z}, {x, 0, -z}};
  const Vec3 up{0, h, 0};
  media::Image picture = media::make_image<uint8_t>(wall_columns, 4 * rows, 3, 0);
  scene::EnvironmentPart part = shown_as_it_is(out.pictures.size());
  for (int wall = 0; wall < 4; wall++) {
    const double width = wall < 2 ? room_width : room_length;
    const auto row = [=](double t) { return [=](double s) { return wall_colour(wall, s, t, key); }; };
    const uint32_t top = rows * uint32_t(wall);
    paint({width, h, h / rows / 2, row, threads}, width, h, true, top, rows, picture);
    // Half a pixel inside, so that strips do not run into each other.
    add_quad(part.mesh, {left[wall] + up, left[wall], right[wall], right[wall] + up},
             (top + 0.5) / (4.0 * rows), (top + rows - 0.5) / (4.0 * rows));
  }
  out.pictures.push_back(jpeg(picture));
  out.parts.push_back(std::move(part));
}

} // namespace

std::string environment_glb(const Scene &scene, uint32_t threads) {
  scene::Environment out;
  add_floor(scene.paint_key(), threads, out);
  add_walls(scene.paint_key(), threads, out);
  for (const Lamp &lamp : studio_lamps()) {
    fvv_light light = {};
    light.type = FVV_LIGHT_DIRECTIONAL;
    light.flags = FVV_LIGHT_CASTS_SHADOWS;
    const Vec3 direction = -lamp.towards;
    light.direction[0] = direction.x;
    light.direction[1] = direction.y;
    light.direction[2] = direction.z;
    for (double &part : light.colour) part = 1;
    light.intensity = lux * lamp.share;
    out.lights.push_back(light);
  }
  return scene::format_environment(out, {{0, 0, 0}, 0.001}, "background.glb");
}

} // namespace fvv::synth
