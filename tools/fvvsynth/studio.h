// The studio around the action: floor, walls and the things that stand there. Still; part of the pictures,
// not of the meshes. Knows its surfaces and the places of the cameras; knows no players.
#pragma once

#include "fvv/calibration.h"
#include "fvvsynth/props.h"
#include "fvvsynth/texture.h"

#include <array>

namespace fvv::synth {

class Studio {
public:
  // texel: finest detail of the floor in metres; that of walls, which are farther away, is twice as large.
  // The cameras are seen on their tripods, except those above everything.
  Studio(uint32_t key, double texel, const std::vector<fvv_camera> &cameras, const render::Light &light,
         uint32_t threads);
  // What a camera sees of it, linear, each pixel from 2 x 2 places and of things that stand there from those
  // of buffer. own: the number of this camera, whose tripod is not seen. part: of those things, as for
  // render::illuminate.
  render::LightField seen(const render::Projection &camera, size_t own, render::SampleBuffer &buffer,
                          std::optional<uint32_t> part = {}) const;

private:
  Rgb wall(Vec3 from, Vec3 direction, double footprint_per_metre, double blur) const;
  Rgb at(Vec3 eye, Vec3 direction, double pixel) const;

  render::Light light;
  std::vector<size_t> tripods; // number of each camera among those of props, or SIZE_MAX
  Props props;
  Texture ground;
  std::array<Texture, 4> walls;
};

} // namespace fvv::synth
