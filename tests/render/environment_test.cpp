// The environment around the action: in front of and behind the mesh, repeated, clamped, from behind.
#include "fvv_catch.h"

#include "view_fixture.h"

using namespace view_fixture;

namespace {

// Red, green in the first row, blue, white in the second.
std::shared_ptr<const EnvironmentImage> four_pixels() {
  auto image = std::make_shared<EnvironmentImage>();
  *image = {2, 2, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255}};
  return image;
}

// A square of side 2 * half in the plane z, its front towards -z, whose picture is repeats times as wide and
// as high as it.
EnvironmentPart wall(double half, double z, double repeats = 1) {
  Shape shape;
  shape.square(half, z);
  EnvironmentPart part;
  part.positions = shape.positions;
  part.faces = shape.faces;
  part.texture = {0, 0, repeats, 0, repeats, repeats, 0, repeats};
  return part;
}

EnvironmentPart plain(double half, double z, Vec3 colour) {
  EnvironmentPart part = wall(half, z);
  part.colour = colour;
  return part;
}

// The action is a grey square at z = 0, seen from z = -4 in 40 x 40 pixels of 0.1 m.
struct Stage {
  Shape shape;
  Sources sources;
  fvv_camera target = looking({0, 0, -4}, {0, 0, 0}, 40, 40, 40);
  Stage() {
    shape.square(1, 0);
    sources.plain(looking({0, 0, -3}, {0, 0, 0}, 64, 64, 20), {0.5, 0.5, 0.5});
  }
  ViewPicture draw(const std::vector<EnvironmentPart> &parts, fvv_camera camera, uint32_t samples = 1) const {
    const Environment environment(parts);
    ViewOptions options;
    options.background = {0, 0, 0.25};
    options.samples = samples;
    options.environment = &environment;
    return render(shape, sources, camera, options);
  }
};

constexpr size_t centre = 20 * 40 + 20, corner = 2 * 40 + 2;
constexpr Vec3 red{1, 0, 0}, grey{0.5, 0.5, 0.5}, blue{0, 0, 0.25};

} // namespace

TEST_CASE("the nearer of environment and action is drawn") {
  const Stage stage;
  const ViewPicture behind = stage.draw({plain(20, 2, red)}, stage.target);
  CHECK(farthest(colour_of(behind, centre), grey) < 1e-3);
  CHECK(farthest(colour_of(behind, corner), red) < 1e-6);
  CHECK(behind.coverage[centre] == 1);
  CHECK(behind.coverage[corner] == 0);
  CHECK(std::isinf(behind.depth[corner])); // depth is the action's
  const ViewPicture front = stage.draw({plain(0.2, -1, red)}, stage.target);
  CHECK(farthest(colour_of(front, centre), red) < 1e-6);
  CHECK(front.coverage[centre] == 0);
  CHECK(front.face[centre] == no_face);
  CHECK(farthest(colour_of(front, 20 * 40 + 13), grey) < 1e-3);
  CHECK(farthest(colour_of(front, corner), blue) < 1e-6);
  // At the same depth the action stays.
  const ViewPicture level = stage.draw({plain(20, 0, red)}, stage.target);
  CHECK(farthest(colour_of(level, centre), grey) < 1e-3);
}

TEST_CASE("an environment does not change what cameras show of the action") {
  const Stage stage;
  // Between the source and the action, behind the target.
  const ViewPicture with = stage.draw({plain(0.5, -3.5, red)}, looking({0, 0, -2}, {0, 0, 0}, 40, 40, 40));
  CHECK(farthest(colour_of(with, centre), grey) < 1e-3);
}

TEST_CASE("faces of an environment show from their front, double-sided ones from behind too") {
  const Stage stage;
  const fvv_camera behind = looking({0, 0, 8}, {0, 0, 0}, 40, 40, 40);
  EnvironmentPart part = plain(20, 3, red);
  CHECK(farthest(colour_of(stage.draw({part}, behind), corner), blue) < 1e-6);
  part.double_sided = true;
  CHECK(farthest(colour_of(stage.draw({part}, behind), corner), red) < 1e-6);
}

TEST_CASE("a picture of an environment repeats or ends with its last pixels") {
  const Stage stage;
  // 6 m wide at z = 2, 6 m from the eye: a pixel covers 0.15 m, the picture 3 m with two repetitions.
  EnvironmentPart part = wall(3, 2, 2);
  part.picture = four_pixels();
  const auto at = [&](const ViewPicture &picture, double x, double y) {
    return colour_of(picture, size_t(std::floor(20 + y / 0.15)) * 40 + size_t(std::floor(20 + x / 0.15)));
  };
  const ViewPicture repeated = stage.draw({part}, stage.target);
  // Pixels have their centres at 0.75 m and 2.25 m from the left edge of each repetition.
  for (const double left : {-3.0, 0.0})
    for (const double top : {-3.0, 0.0}) {
      if (std::abs(left + 2.25) < 1.6 && std::abs(top + 2.25) < 1.6) continue; // behind the action
      const auto shown = [&](double u, double v) { return at(repeated, left + u, top + v); };
      if (left < 0 && top < 0) CHECK(farthest(shown(0.75, 0.75), {1, 0, 0}) < 0.11);
      if (left > -1 && top < 0) CHECK(farthest(shown(2.25, 0.75), {0, 1, 0}) < 0.11);
      if (left < 0 && top > -1) CHECK(farthest(shown(0.75, 2.25), {0, 0, 1}) < 0.11);
      if (left > -1 && top > -1) CHECK(farthest(shown(2.25, 2.25), {1, 1, 1}) < 0.11);
    }
  part.clamped = true;
  const ViewPicture clamped = stage.draw({part}, stage.target);
  CHECK(farthest(at(clamped, 2.25, 2.25), {1, 1, 1}) < 1e-6);
  CHECK(farthest(at(clamped, 2.25, -2.25), {0, 1, 0}) < 0.11);
  // A factor is one of light, not of display values: half of white is 188 of 255.
  part.colour = {0.5, 0.5, 0.5};
  CHECK(std::abs(at(stage.draw({part}, stage.target), 2.25, 2.25).x - 188 / 255.0) < 2e-3);
}

TEST_CASE("an environment through a lens is where it is without one in the middle") {
  const Stage stage;
  const ViewPicture picture = stage.draw({plain(20, 2, red)}, with_lens(stage.target, -0.2, 0.02), 3);
  CHECK(farthest(colour_of(picture, centre), grey) < 1e-3);
  CHECK(farthest(colour_of(picture, corner), red) < 1e-6);
}

TEST_CASE("a part of an environment has to fit its vertices") {
  EnvironmentPart part = wall(1, 0);
  part.faces[0] = 4;
  CHECK_THROWS_AS(Environment({part}), std::invalid_argument);
  part = wall(1, 0);
  part.picture = four_pixels();
  part.texture.pop_back();
  CHECK_THROWS_AS(Environment({part}), std::invalid_argument);
}
