// The studio around the action: floor, walls, still things, and the shadows of the players on the floor. It
// is part of the pictures, not of the meshes.
#pragma once

#include "fvv/calibration.h"
#include "fvv_render/picture.h"
#include "fvvsynth/look.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace fvv::synth {

struct Lamp {
  render::Vec3 towards; // unit vector to the lamp
  double share;         // of the floor's light that comes from it
  double softness;      // half the width of the penumbra, metres
};

// The shadow of the players on the floor: a shadow map (Williams, "Casting curved shadows on curved
// surfaces", 1978) of the mesh in the light of a distant lamp, for the plane y = 0 alone.
class Shadow {
public:
  // cell: metres of a pixel of the map, which has its middle at (0, 0.8, 0) and 448 x 448 pixels. least: of
  // the light that is blocked; less is none.
  Shadow(const render::Mesh &mesh, const Lamp &lamp, double cell = 0.0125, float least = 0);
  // Darkens what camera sees of the floor. Objects on it are drawn afterwards.
  static void cast(const std::vector<Shadow> &shadows, const render::Projection &camera,
                   render::LightField &picture);

private:
  struct Rectangle { // of pixels, right and bottom excluded
    uint32_t left, top, right, bottom;
  };
  double covered(render::Vec3 on_floor) const;
  Rectangle shown(const render::Projection &camera) const;
  bool reaches(const std::array<render::Vec3, 4> &corners) const;

  Lamp light;
  double cell;
  render::Projection view;         // of the lamp
  std::vector<float> blocked;      // share of the light for each of its pixels
  double left, top, right, bottom; // where any is blocked
  std::vector<uint8_t> any;        // whether any is, for squares of the map
};

using render::Rgb;
using render::Vec3;

// A beam or a lamp below the ceiling: a box, half its sides, and the light that it sends out.
struct CeilingPart {
  Vec3 centre, half;
  Rgb colour;
};
std::vector<CeilingPart> ceiling_parts();

// A dark place on the floor, below a thing.
struct Spot {
  double x, z, radius, depth; // depth: share of the light that is missing in the middle
};

// Still things: the other cameras on their tripods, a hoop, lamps on a truss and on stands, benches, balls.
class Props {
public:
  explicit Props(bool ceiling);
  // A camera on a tripod with its lens at centre, looking along forward (unit vector).
  void add_camera(Vec3 centre, Vec3 forward);

  const std::vector<Spot> &spots() const { return stains; }
  // Draws all but camera number own (SIZE_MAX: all) over background. part as for render::illuminate.
  render::LightField draw(const render::Projection &camera, size_t own, const render::Light &light,
                          render::LightField background, render::SampleBuffer &buffer,
                          std::optional<uint32_t> part) const;

private:
  // axes: half the sides of the box.
  void box(Vec3 centre, Vec3 x, Vec3 y, Vec3 z, Rgb colour);
  void block(Vec3 centre, Vec3 half, Rgb colour) {
    box(centre, {half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}, colour);
  }
  // A closed cone from a to b with these radii; end: the colour of the cap at b.
  void tube(Vec3 a, Vec3 b, double radius_a, double radius_b, Rgb colour, Rgb end);
  void tube(Vec3 a, Vec3 b, double radius, Rgb colour) { tube(a, b, radius, radius, colour, colour); }
  void ball(Vec3 centre, double radius, Rgb colour);
  void hoop();
  void truss();
  void stand(Vec3 foot);
  void bench(Vec3 middle);

  uint32_t vertex(Vec3 at, Vec3 normal, Rgb colour);
  void quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d);

  std::vector<float> positions, normals, colours; // three per vertex
  std::vector<uint32_t> faces;
  std::vector<size_t> camera_ends; // in faces; the first camera begins at still_end
  size_t still_end = 0;
  std::vector<Spot> stains;
};

class Studio {
public:
  // texel: finest detail of the floor in metres; that of walls, which are farther away, is twice as large.
  // The cameras are seen on their tripods, except those above everything. ceiling: with beams and lamps, else
  // there is black.
  Studio(uint32_t key, double texel, const std::vector<fvv_camera> &cameras, const render::Light &light,
         bool ceiling, uint32_t threads);
  // What a camera sees of it, linear, each pixel from 2 x 2 places and of still things from those of buffer.
  // own: the number of this camera, whose tripod is not seen. part: of those things, as for
  // render::illuminate.
  render::LightField seen(const render::Projection &camera, size_t own, render::SampleBuffer &buffer,
                          std::optional<uint32_t> part = {}) const;

private:
  Rgb above(Vec3 from, Vec3 direction, double footprint_per_metre, double blur) const;
  Rgb wall(Vec3 from, Vec3 direction, double footprint_per_metre, double blur) const;
  Rgb at(Vec3 eye, Vec3 direction, double pixel, std::optional<Rgb> &reflection) const;

  render::Light light;
  std::vector<size_t> tripods; // number of each camera among those of props, or SIZE_MAX
  Props props;
  Texture ground;
  std::array<Texture, 4> walls;
  std::optional<Texture> ceiling;
};

} // namespace fvv::synth
