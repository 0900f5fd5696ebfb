// The whole scene: players, ball, studio, light and cameras from one seed; meshes and pictures of any moment.
#pragma once

#include "fvvsynth/body/body.h"
#include "fvvsynth/game/hoop.h"
#include "fvvsynth/look.h"
#include "fvvsynth/play.h"
#include "fvvsynth/rig.h"
#include "fvvsynth/studio.h"

#include <memory>
#include <string>

namespace fvv::synth {

enum class SceneKind {
  practice, // two players pass a ball, 4 s
  game      // passes, a move past and a shot at a hoop, 10 s; finer figures, a ceiling, contact shadows
};

struct Settings {
  uint64_t seed = 1;
  SceneKind kind = SceneKind::practice;
  RigKind rig = RigKind::studio;
  uint32_t cameras = 7; // of the small rig, 1..64
  // Of the small rig's pictures, 16..4096; of most pictures of the studio rig, 16..studio_max_side.
  uint32_t width = 960, height = 540;
  bool still = false;   // no camera moves
  uint32_t threads = 1; // that prepare the scene; the result is the same for any number
};

// A mesh of one moment. Faces are those of Scene::faces() at all times.
struct Moment {
  std::vector<float> positions; // x y z, world metres
  std::vector<float> normals;   // unit vectors, outwards
  double seconds = 0;
  std::vector<Shadow> shadows; // one for each lamp that casts them
};

class Scene {
public:
  explicit Scene(const Settings &settings); // throws std::invalid_argument outside the ranges above

  const Settings &settings() const { return wanted; }
  // As they are at 0 s. A camera that moves has another calibration at every moment.
  const std::vector<fvv_camera> &cameras() const { return rig; }
  bool moves(size_t camera) const { return moving == camera; }
  fvv_camera camera(size_t number, double seconds) const;
  // Player 0, player 1, ball: three closed surfaces, one after the other, the same faces at all times. In the
  // game players are of several closed surfaces each, and those of the hoop follow.
  const std::vector<uint32_t> &faces() const { return all_faces; }
  size_t vertex_count() const { return texture.size() / 3; }
  const Action &action() const { return *choreography; }
  const Game *game() const { return match; } // the action, if it is that of the game, else NULL
  const std::array<Body, 2> &players() const { return bodies; }
  // Where the vertices lie in the solid textures, x y z: on the rest figures, on the unit sphere, and on the
  // hoop.
  const std::vector<float> &solid() const { return texture; }
  // Of a face at a point between its vertices there.
  render::Reflectance reflectance(uint32_t face, Vec3 at) const;

  Moment at(double seconds) const;
  // What a camera sees at a moment, with the calibration of that moment; buffer and part as for
  // render::illuminate. May be called from several threads.
  render::LitPicture light(size_t camera, const Moment &moment, render::SampleBuffer &buffer,
                           std::optional<uint32_t> part = {}) const;
  // What a camera that stands still sees without players and ball.
  const render::LightField &empty_stage(size_t camera) const { return backgrounds[camera]; }
  // The same with another object, which casts no shadow. For a camera that stands still.
  render::LitPicture light_object(size_t camera, const render::Mesh &mesh,
                                  const render::Attributes &attributes, const render::Material &material,
                                  render::SampleBuffer &buffer) const;
  // Of light(), as display values, as a perfect camera takes it.
  render::Picture picture(size_t camera, const Moment &moment, render::SampleBuffer &buffer) const {
    return render::displayed(light(camera, moment, buffer));
  }

  // The key of floor_colour() and wall_colour().
  uint32_t paint_key() const { return studio_key; }

private:
  // Half the faces of closed surfaces are behind the others for each camera, and need not be drawn.
  struct Facing {
    std::vector<uint32_t> corners; // of the faces that turn their front to a place
    std::vector<uint32_t> numbers; // of these among all
  };
  Facing facing_faces(const Moment &moment, Vec3 eye) const;

  Settings wanted;
  Random random;
  std::array<Look, 2> looks;
  std::unique_ptr<const Action> choreography;
  const Game *match = nullptr; // the choreography, if it is that of the game
  uint32_t studio_key, ball_key;
  std::array<Body, 2> bodies;
  Surface ball;
  std::optional<Hoop> hoop;
  std::array<size_t, 3> face_ends; // of the players and the ball
  std::vector<uint32_t> all_faces;
  std::vector<float> texture, exposure;
  std::vector<fvv_camera> rig;
  std::vector<std::string> names; // of the cameras, which borrow them
  std::optional<size_t> moving;
  fvv_camera at_rest = {};                     // the moving camera, unturned, at its shortest focal length
  std::vector<render::Projection> projections; // at 0 s
  std::unique_ptr<const Studio> studio;
  std::vector<render::LightField> backgrounds; // of the cameras that stand still
};

// The lamps that cast shadows on the floor.
const std::array<Lamp, 2> &studio_lamps();

} // namespace fvv::synth
