// Still things in the studio: the other cameras on their tripods, a hoop, lamps on a truss and on stands,
// benches, balls. Part of the pictures, not of the meshes. Knows shapes and colours; knows no cameras'
// images.
#pragma once

#include "fvv_render/picture.h"

#include <cstdint>
#include <vector>

namespace fvv::synth {

using render::Rgb;
using render::Vec3;

// A dark place on the floor, where a thing stands.
struct Spot {
  double x, z, radius, depth; // depth: share of the light that is missing in the middle
};

class Props {
public:
  Props();
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

} // namespace fvv::synth
