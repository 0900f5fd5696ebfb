// The whole scene: players, ball, court, light and cameras from one seed; meshes and pictures of any moment.
// Knows no files.
#pragma once

#include "fvvsynth/body.h"
#include "fvvsynth/look.h"
#include "fvvsynth/play.h"
#include "fvvsynth/rig.h"

#include <string>

namespace fvv::synth {

struct Settings {
  uint64_t seed = 1;
  RigKind rig = RigKind::small;
  uint32_t cameras = 7; // of the small rig, 1..64
  // Of the small rig's pictures, 16..4096; of most pictures of the studio rig, 16..studio_max_side.
  uint32_t width = 480, height = 270;
  uint32_t threads = 1; // that prepare the scene; the result is the same for any number
};

// A mesh of one moment. Faces are those of Scene::faces() at all times.
struct Moment {
  std::vector<float> positions; // x y z, world metres
  std::vector<float> normals;   // unit vectors, outwards
};

class Scene {
public:
  explicit Scene(const Settings &settings); // throws std::invalid_argument outside the ranges above

  const Settings &settings() const { return wanted; }
  const std::vector<fvv_camera> &cameras() const { return rig; }
  // Player 0, player 1, ball: three closed surfaces, one after the other, the same faces at all times.
  const std::vector<uint32_t> &faces() const { return all_faces; }
  size_t vertex_count() const { return texture.size() / 3; }
  const Play &play() const { return choreography; }

  Moment at(double seconds) const;
  // Colour, mask and depth seen by a camera; buffer as for render::draw. May be called from several threads.
  render::Picture picture(size_t camera, const Moment &moment, render::SampleBuffer &buffer) const;

private:
  Settings wanted;
  Random random;
  std::array<Look, 2> looks;
  Play choreography;
  uint32_t court_key, ball_key;
  std::array<Body, 2> bodies;
  Surface ball;
  std::array<size_t, 2> face_count;
  std::vector<uint32_t> all_faces;
  std::vector<float> texture, exposure;
  std::vector<fvv_camera> rig;
  std::vector<std::string> names; // of the cameras, which borrow them
  std::vector<render::Projection> projections;
  std::vector<std::vector<render::Rgb>> backgrounds;
};

} // namespace fvv::synth
