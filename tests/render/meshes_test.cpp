// Meshes that are not the scene's own: hulls of masks, and the same surface with other triangles.
#include "closed.h"
#include "fvv_catch.h"

#include "fvv_geometry/hull.h"
#include "fvvsynth/capture_writer.h"
#include "fvvsynth/remesh.h"
#include "fvvsynth/scene.h"
#include "surface_volume.h"

#include <cmath>

using namespace fvv::hull;
using namespace fvv::synth;

namespace {

Options on_ground() {
  Options options;
  options.floor = Floor{{0, 1, 0}, 0};
  return options;
}

Surface as_surface(const Scene &scene, const Moment &moment) {
  Surface surface;
  surface.faces = scene.faces();
  for (size_t i = 0; i < moment.positions.size(); i += 3)
    surface.vertices.push_back({moment.positions[i], moment.positions[i + 1], moment.positions[i + 2]});
  return surface;
}

std::vector<Silhouette> silhouettes(const Scene &scene, const Moment &moment) {
  std::vector<Silhouette> result;
  for (size_t i = 0; i < scene.cameras().size(); i++) {
    const fvv_camera camera = scene.camera(i, moment.seconds);
    fvv::render::SampleBuffer buffer(camera.width, camera.height, 3);
    result.emplace_back(camera, scene.picture(i, moment, buffer).mask);
  }
  return result;
}

void check_closed(const Surface &surface) {
  const Closedness found = closedness(surface.vertices.size(), surface.faces);
  CHECK(found.unmatched == 0);
  CHECK(found.pinched == 0);
}

// A camera at (0, 0, -10) that looks along +z.
fvv_camera straight(uint32_t side) {
  fvv_camera camera = {};
  camera.width = camera.height = side;
  camera.fx = camera.fy = side;
  camera.cx = camera.cy = side / 2.0;
  camera.r_max = INFINITY;
  for (int i = 0; i < 9; i += 4) camera.rotation[i] = 1;
  camera.translation[2] = 10;
  return camera;
}

} // namespace

TEST_CASE("any signs on a grid give a closed manifold") {
  Random random(3);
  const Grid grid = grid_over({0, 0, 0}, {1, 1, 1}, 1.0 / 16);
  for (int round = 0; round < 20; round++) {
    std::vector<double> value(grid.points(), 1);
    for (size_t k = 1; k < 16; k++)
      for (size_t j = 1; j < 16; j++)
        for (size_t i = 1; i < 16; i++) value[grid.at(i, j, k)] = random.between(-1, 0.4 + 0.1 * round);
    const Surface surface =
        march(grid, value, [&](size_t p, int axis) { return interpolated_crossing(grid, value, p, axis); });
    REQUIRE(surface.faces.size() > 100);
    check_closed(surface);
    CHECK(volume(surface) > 0); // counter-clockwise seen from outside
  }
}

TEST_CASE("marching over a sphere gives the sphere") {
  const Grid grid = grid_over({-1.21, -1.18, -1.23}, {1.2, 1.2, 1.2}, 0.05);
  std::vector<double> value;
  for (size_t k = 0; k < grid.count[2]; k++)
    for (size_t j = 0; j < grid.count[1]; j++)
      for (size_t i = 0; i < grid.count[0]; i++)
        value.push_back(length(grid.point(double(i), double(j), double(k))) - 1);
  const Surface surface =
      march(grid, value, [&](size_t p, int axis) { return interpolated_crossing(grid, value, p, axis); });
  check_closed(surface);
  double worst = 0;
  for (const Vec3 p : surface.vertices) worst = std::max(worst, std::abs(length(p) - 1));
  CHECK(worst < 0.05 * edge_margin * 1.5);
  CHECK(volume(surface) == Approx(4.18879).epsilon(0.01));
}

TEST_CASE("a silhouette measures distances from its outline") {
  const fvv_camera camera = straight(64);
  std::vector<uint8_t> mask(64 * 64);
  for (size_t y = 0; y < 64; y++)
    for (size_t x = 20; x < 40; x++) mask[y * 64 + x] = 255; // columns 20 ... 39: outlines at u = 20 and 40
  const Silhouette silhouette(camera, mask);
  for (const double u : {5.3, 12.0, 19.0, 21.5, 27.0, 36.5, 41.7, 60.0}) {
    const double world[3] = {(u - 32) * 10 / 64, 0.3, 0};
    const Silhouette::View view = silhouette.view(world);
    const double expected = u < 30 ? 20 - u : u - 40;
    REQUIRE(view.seen);
    CHECK(view.pixels == Approx(expected).margin(1e-4));
    CHECK(view.metres == Approx(expected * 10 / 64).margin(1e-5));
    using Ball = Silhouette::Ball;
    CHECK(silhouette.ball(world, 0.1) == (expected > 3    ? Ball::outside
                                          : expected < -3 ? Ball::inside
                                                          : Ball::unsure));
  }
  const double beside[3] = {6, 0, 0}, behind[3] = {0, 0, -11};
  CHECK_FALSE(silhouette.view(beside).seen);
  CHECK_FALSE(silhouette.view(behind).seen);
  CHECK(silhouette.ball(beside, 0.1) == Silhouette::Ball::unseen);
  CHECK(silhouette.ball(behind, 0.1) == Silhouette::Ball::unseen);
}

TEST_CASE("a hull has the intended size, is closed, holds the scene and fits the masks") {
  Settings settings;
  settings.rig = RigKind::small;
  settings.width = 480;
  settings.height = 270;
  const Scene scene(settings);
  const Moment moment = scene.at(0.44);
  const std::vector<Silhouette> masks = silhouettes(scene, moment);
  const Surface hull = carve(hull_grid(220), masks, on_ground()).surface;
  check_closed(hull);
  CHECK(hull.faces.size() / 3 > 32000);
  CHECK(hull.faces.size() / 3 < 38000);
  CHECK(volume(hull) > volume(as_surface(scene, moment)));
  CHECK(volume(hull) < 2 * volume(as_surface(scene, moment)));
  double lowest = 1;
  for (const Vec3 p : hull.vertices) lowest = std::min(lowest, p.y);
  CHECK(lowest > -0.01);
  CHECK(lowest < 0.005);

  // No vertex of the hull is outside a mask, and no vertex of the scene outside the hull, by more than half
  // a cell or a pixel.
  size_t out_of_mask = 0, out_of_hull = 0;
  for (const Vec3 p : hull.vertices) {
    const double world[3] = {p.x, p.y, p.z};
    for (const Silhouette &mask : masks) {
      const Silhouette::View view = mask.view(world);
      out_of_mask += view.seen && view.metres > 0.011;
    }
  }
  for (size_t i = 0; i < moment.positions.size(); i += 3) {
    const double world[3] = {moment.positions[i], moment.positions[i + 1], moment.positions[i + 2]};
    for (const Silhouette &mask : masks) {
      const Silhouette::View view = mask.view(world);
      out_of_hull += view.seen && view.pixels > 1;
    }
  }
  CHECK(out_of_mask == 0);
  CHECK(out_of_hull == 0);
}

TEST_CASE("what fewer than three cameras see is not in the hull") {
  Settings settings;
  settings.rig = RigKind::small;
  settings.cameras = 3;
  settings.width = 96;
  settings.height = 54;
  const Scene scene(settings);
  std::vector<Silhouette> masks = silhouettes(scene, scene.at(0));
  CHECK_FALSE(carve(hull_grid(60), masks, on_ground()).surface.faces.empty());
  masks.pop_back();
  CHECK(carve(hull_grid(60), masks, on_ground()).surface.faces.empty());
}

TEST_CASE("remeshing joins surfaces that cut each other") {
  // Two unit spheres whose centres are 1 apart: the union has a known volume.
  const Surface ball = make_ball(12);
  std::vector<float> positions;
  std::vector<uint32_t> faces;
  for (const double shift : {0.0, 1.0}) {
    const uint32_t first = uint32_t(positions.size() / 3);
    for (const Vec3 p : ball.vertices)
      for (const double value : {p.x + shift, p.y, p.z}) positions.push_back(float(value));
    for (const uint32_t v : ball.faces) faces.push_back(first + v);
  }
  const Surface joined = remesh(remesh_grid(positions, 0.05, 9), positions, faces);
  check_closed(joined);
  const double one = volume(ball), overlap = 3.14159265 * 5 / 12; // lens of two unit spheres at distance 1
  CHECK(volume(joined) == Approx(2 * one - overlap).epsilon(0.01));
  CHECK(joined.vertices.size() - closedness(joined.vertices.size(), joined.faces).edges +
            joined.faces.size() / 3 ==
        2); // one sphere
}

TEST_CASE("remeshed frames are the same surface with other triangles", "[long]") {
  Settings settings;
  settings.rig = RigKind::small;
  settings.cameras = 1;
  const Scene scene(settings);
  const Moment moment = scene.at(1.0);
  const double cell = 0.0203;
  const Surface a = remesh(remesh_grid(moment.positions, cell, 1), moment.positions, scene.faces()),
                b = remesh(remesh_grid(moment.positions, cell, 2), moment.positions, scene.faces());
  CHECK(a.faces != b.faces);
  const double whole = volume(as_surface(scene, moment));
  for (const Surface &surface : {a, b}) {
    check_closed(surface);
    CHECK(surface.faces.size() / 3 > 32000);
    CHECK(surface.faces.size() / 3 < 38000);
    CHECK(volume(surface) == Approx(whole).epsilon(0.03));
  }
}
