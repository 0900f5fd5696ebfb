// Visual hulls of shapes whose hulls are known.
#include "decimate_fixture.h"

#include "fvv_cxx/error.h"
#include "fvv_geometry/hull.h"
#include "fvv_geometry/outline.h"
#include "geometry/src/hull_mesh.h"
#include "render/closed.h"
#include "surface_volume.h"

#include <algorithm>
#include <random>

using namespace fvv::hull;
using shapes::Mesh;

namespace {

// At centre, looking at the origin; up is y.
fvv_camera looking(Vec3 centre, uint32_t side, double focal) {
  fvv_camera camera = {};
  camera.width = camera.height = side;
  camera.fx = camera.fy = focal;
  camera.cx = camera.cy = side / 2.0;
  camera.r_max = INFINITY;
  const Vec3 z = normalised(-centre), x = normalised(cross(Vec3{0, -1, 0}, z)), y = cross(z, x);
  const Vec3 rows[3] = {x, y, z};
  for (int k = 0; k < 3; k++) {
    camera.rotation[3 * k] = rows[k].x;
    camera.rotation[3 * k + 1] = rows[k].y;
    camera.rotation[3 * k + 2] = rows[k].z;
    camera.translation[k] = -dot(rows[k], centre);
  }
  return camera;
}

// count cameras on a ring around the y axis, every other one higher up; one from above with the last.
std::vector<fvv_camera> ring(size_t count, double radius = 4, uint32_t side = 200) {
  std::vector<fvv_camera> out;
  for (size_t i = 0; i + 1 < count; i++) {
    const double angle = 2 * M_PI * double(i) / double(count - 1);
    out.push_back(looking({radius * std::cos(angle), radius * (i % 2 ? 0.5 : 0.1), radius * std::sin(angle)},
                          side, 1.2 * side));
  }
  out.push_back(looking({0.1 * radius, 1.2 * radius, 0}, side, 1.2 * side));
  return out;
}

std::vector<uint8_t> mask_of(const Mesh &mesh, const fvv_camera &camera) {
  return fvv::geometry::ViewedSurface(mesh.positions, mesh.faces).cover(camera);
}

std::vector<Silhouette> silhouettes(const std::vector<fvv_camera> &cameras, const Mesh &mesh) {
  std::vector<Silhouette> out;
  for (const fvv_camera &camera : cameras) out.emplace_back(camera, mask_of(mesh, camera));
  return out;
}

Mesh moved(Mesh mesh, Vec3 by) {
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    mesh.positions[3 * v] += by.x;
    mesh.positions[3 * v + 1] += by.y;
    mesh.positions[3 * v + 2] += by.z;
  }
  return mesh;
}

Mesh joined(Mesh a, const Mesh &b) {
  for (const uint32_t v : b.faces) a.faces.push_back(v + uint32_t(a.vertex_count()));
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  return a;
}

double area(const Surface &surface) {
  double sum = 0;
  for (size_t i = 0; i < surface.faces.size(); i += 3) {
    const Vec3 a = surface.vertices[surface.faces[i]];
    sum += length(cross(surface.vertices[surface.faces[i + 1]] - a,
                        surface.vertices[surface.faces[i + 2]] - a)) /
           2;
  }
  return sum;
}

void check_closed(const Surface &surface) {
  const Closedness found = closedness(surface.vertices.size(), surface.faces);
  CHECK(found.unmatched == 0);
  CHECK(found.pinched == 0);
  CHECK(surface.crossings.size() == surface.vertices.size());
}

size_t inside_points(const Hull &hull) {
  size_t count = 0;
  for (size_t i = 0; i < hull.grid.points(); i++) count += hull.occupancy[i / 8] >> i % 8 & 1;
  return count;
}

bool same(const Surface &a, const Surface &b) {
  return a.faces == b.faces &&
         std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(), b.vertices.end(),
                    [](Vec3 p, Vec3 q) { return p.x == q.x && p.y == q.y && p.z == q.z; });
}

// The definition of a hull, point by point.
Surface dense(const Grid &grid, const std::vector<Silhouette> &views, const Options &options) {
  std::vector<double> value(grid.points(), grid.cell);
  for (size_t k = 1; k + 1 < grid.count[2]; k++)
    for (size_t j = 1; j + 1 < grid.count[1]; j++)
      for (size_t i = 1; i + 1 < grid.count[0]; i++) {
        const Vec3 p = grid.point(double(i), double(j), double(k));
        const double world[3] = {p.x, p.y, p.z};
        std::vector<double> seen;
        for (const Silhouette &view : views)
          if (const Silhouette::View at = view.view(world); at.seen) seen.push_back(at.metres);
        if (seen.size() < options.least_views) continue;
        std::sort(seen.begin(), seen.end());
        const size_t last = seen.size() > options.missed ? seen.size() - 1 - options.missed : 0;
        double v = seen[std::max(last, options.least_views - 1)];
        if (options.floor) v = std::max(v, options.floor->height - dot(options.floor->up, p));
        value[grid.at(i, j, k)] = std::clamp(v, -2 * grid.cell, 2 * grid.cell);
      }
  return march(grid, value, [&](size_t p, int axis) { return interpolated_crossing(grid, value, p, axis); });
}

const Mesh ball = shapes::sphere(0.5, 5);

} // namespace

TEST_CASE("an octree finds the same hull as a dense grid", "[long]") {
  // A ball and one beside it, in pictures that show a part of the scene.
  const Mesh scene = joined(ball, moved(shapes::sphere(0.2, 4), {0.7, 0.3, 0}));
  const std::vector<Silhouette> views = silhouettes(ring(9, 2.2, 128), scene);
  const Grid grid = grid_over({-0.9, -0.8, -0.85}, {1.1, 0.8, 0.8}, 0.021);
  for (const size_t missed : {0, 1, 2})
    for (const size_t least : {1, 3, 6})
      for (const bool floor : {false, true}) {
        Options options;
        options.missed = missed;
        options.least_views = least;
        if (floor) options.floor = Floor{{0, 1, 0}, -0.3};
        CAPTURE(missed, least, floor);
        const Surface expected = dense(grid, views, options);
        REQUIRE(expected.faces.size() > 3000);
        const Hull found = carve(grid, views, options);
        CHECK(same(found.surface, expected));
        options.threads = 3;
        CHECK(same(carve(grid, views, options).surface, expected));
      }
}

TEST_CASE("what is certain of a ball holds for its points") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> even(-1, 1);
  std::vector<fvv_camera> cameras = ring(4, 2);
  cameras[1].lens = FVV_LENS_RADTAN;
  cameras[1].distortion[0] = -0.2;
  cameras[1].r_max = fvv_camera_r_max(&cameras[1]);
  size_t certain[4] = {};
  for (const fvv_camera &camera : cameras) {
    const Silhouette view(camera, mask_of(ball, camera));
    for (int i = 0; i < 4000; i++) {
      const double centre[3] = {2 * even(random), 2 * even(random), 2 * even(random)},
                   radius = 0.1 * std::abs(even(random));
      const Silhouette::Ball found = view.ball(centre, radius);
      certain[size_t(found)]++;
      if (found == Silhouette::Ball::unsure) continue;
      for (int k = 0; k < 8; k++) {
        const Vec3 way = normalised(Vec3{even(random), even(random), even(random)}) * radius;
        const double world[3] = {centre[0] + way.x, centre[1] + way.y, centre[2] + way.z};
        const Silhouette::View at = view.view(world);
        REQUIRE(at.seen == (found != Silhouette::Ball::unseen));
        if (at.seen) REQUIRE((at.pixels < 0) == (found == Silhouette::Ball::inside));
      }
    }
  }
  for (const size_t count : certain) CHECK(count > 100);
}

TEST_CASE("the hull of a sphere is little more than the sphere") {
  const std::vector<Silhouette> views = silhouettes(ring(17, 4, 300), ball);
  const Box box = *bounds(views, {});
  for (const double side : {box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z}) {
    CHECK(side > 1);
    CHECK(side < 1.3);
  }
  const double cell = cell_for(views, box, 3);
  CHECK(cell == Approx(3 * 3.4 / 360).epsilon(0.1)); // 3.4 m away, with a focal length of 360 pixels
  const Hull hull = carve(grid_over(box.low, box.high, cell), views, {});
  check_closed(hull.surface);
  CHECK(hull.components == 1);
  CHECK(hull.dropped == 0);
  const double exact = M_PI / 6;
  CHECK(volume(hull.surface) > 0.99 * exact);
  CHECK(volume(hull.surface) < 1.06 * exact);
  CHECK(double(inside_points(hull)) * cell * cell * cell == Approx(volume(hull.surface)).epsilon(0.02));
  for (const Vec3 p : hull.surface.vertices) {
    CHECK(length(p) > 0.5 - 0.009); // a pixel
    CHECK(length(p) < 0.57);
  }
  for (size_t v = 0; v < hull.surface.vertices.size(); v++) {
    const Crossed &crossed = hull.surface.crossings[v];
    const std::array<size_t, 3> p = hull.grid.place(size_t(crossed.edge / 3));
    Vec3 at = hull.grid.point(double(p[0]), double(p[1]), double(p[2]));
    const double step = double(crossed.offset) * cell;
    at += Vec3{crossed.edge % 3 == 0 ? step : 0, crossed.edge % 3 == 1 ? step : 0,
               crossed.edge % 3 == 2 ? step : 0};
    REQUIRE(length(at - hull.surface.vertices[v]) < 1e-7);
  }
}

TEST_CASE("bounds are found in any unit, and there are none around nothing") {
  for (const double unit : {0.001, 100.0}) {
    Mesh scaled = ball;
    for (double &p : scaled.positions) p *= unit;
    const std::vector<Silhouette> views = silhouettes(ring(9, 4 * unit), scaled);
    const std::optional<Box> box = bounds(views, {});
    REQUIRE(box);
    CHECK(length(box->high - box->low) < 1.4 * std::sqrt(3) * unit);
    CHECK(length(box->high - box->low) > std::sqrt(3) * unit);
  }
  std::vector<Silhouette> empty;
  for (const fvv_camera &camera : ring(9)) empty.emplace_back(camera, std::vector<uint8_t>(200 * 200));
  CHECK_FALSE(bounds(empty, {}));
  CHECK_FALSE(bounds({}, {}));
  const Hull nothing = carve(grid_over({-1, -1, -1}, {1, 1, 1}, 0.1), empty, {});
  CHECK(nothing.surface.faces.empty());
  CHECK(nothing.components == 0);
  CHECK(inside_points(nothing) == 0);
}

TEST_CASE("a mask that misses a part cuts the hull unless a camera may miss it") {
  const std::vector<fvv_camera> cameras = ring(9);
  std::vector<Silhouette> views;
  for (size_t i = 0; i < cameras.size(); i++) {
    std::vector<uint8_t> mask = mask_of(ball, cameras[i]);
    if (i == 2) std::fill(mask.begin(), mask.begin() + std::ptrdiff_t(mask.size() / 2), uint8_t(0));
    views.emplace_back(cameras[i], mask);
  }
  const Grid grid = grid_over({-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7}, 0.02);
  const double whole = volume(carve(grid, silhouettes(cameras, ball), {}).surface);
  Options options;
  CHECK(volume(carve(grid, views, options).surface) < 0.6 * whole);
  options.missed = 1;
  const Hull robust = carve(grid, views, options);
  check_closed(robust.surface);
  CHECK(volume(robust.surface) > whole);
  CHECK(volume(robust.surface) < 1.2 * whole);
}

TEST_CASE("a point that too few cameras see is outside") {
  const std::vector<fvv_camera> cameras = ring(5);
  const Grid grid = grid_over({-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7}, 0.03);
  Options options;
  options.least_views = 5;
  CHECK_FALSE(carve(grid, silhouettes(cameras, ball), options).surface.faces.empty());
  options.least_views = 6;
  CHECK(carve(grid, silhouettes(cameras, ball), options).surface.faces.empty());
  // missed does not make up for cameras that are not there.
  options.missed = 5;
  options.least_views = 3;
  std::vector<Silhouette> two = silhouettes(cameras, ball);
  for (size_t i = 2; i < 5; i++) two[i] = Silhouette(cameras[i], std::vector<uint8_t>(200 * 200));
  CHECK(carve(grid, two, options).surface.faces.empty());
}

TEST_CASE("the floor cuts the hull") {
  Options options;
  options.floor = Floor{{0, 1, 0}, -0.205};
  const std::vector<Silhouette> views = silhouettes(ring(9), ball);
  const Hull hull = carve(grid_over({-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7}, 0.02), views, options);
  check_closed(hull.surface);
  size_t at_floor = 0;
  for (const Vec3 p : hull.surface.vertices) {
    CHECK(p.y > -0.207); // vertices stay 0.05 cells from grid points
    at_floor += p.y < -0.203;
  }
  CHECK(at_floor > 500);
}

TEST_CASE("small components are dropped, and the occupancy with them") {
  const Mesh scene = joined(joined(ball, moved(shapes::sphere(0.15, 4), {0.9, 0, 0})),
                            moved(shapes::sphere(0.04, 3), {0, 0.8, 0}));
  const std::vector<Silhouette> views = silhouettes(ring(17), scene);
  const Grid grid = grid_over({-0.7, -0.7, -0.7}, {1.2, 1, 0.7}, 0.02);
  const Hull all = carve(grid, views, {});
  CHECK(all.components == 3);
  size_t before = inside_points(all);
  for (const auto &[share, left] :
       {std::pair(0.005, size_t(2)), std::pair(0.1, size_t(1)), std::pair(1.0, size_t(1))}) {
    Options options;
    options.min_share = share;
    const Hull hull = carve(grid, views, options);
    CHECK(hull.components == left);
    CHECK(hull.dropped == 3 - left);
    check_closed(hull.surface);
    CHECK(inside_points(hull) <= before);
    before = inside_points(hull);
    CHECK(double(before) * 0.02 * 0.02 * 0.02 == Approx(volume(hull.surface)).epsilon(0.02));
  }
  for (const Vec3 p : all.surface.vertices) CHECK(length(p) < 1.2);
}

TEST_CASE("a dropped cavity is filled") {
  const Grid grid = grid_over({-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2}, 0.06);
  std::vector<double> value;
  for (size_t k = 0; k < grid.count[2]; k++)
    for (size_t j = 0; j < grid.count[1]; j++)
      for (size_t i = 0; i < grid.count[0]; i++) {
        const double r = length(grid.point(double(i), double(j), double(k)));
        value.push_back(std::max(r - 1, 0.3 - r));
      }
  Hull hull;
  hull.grid = grid;
  hull.surface =
      march(grid, value, [&](size_t p, int axis) { return interpolated_crossing(grid, value, p, axis); });
  hull.occupancy.resize((grid.points() + 7) / 8);
  for (size_t i = 0; i < value.size(); i++)
    if (value[i] < 0) hull.occupancy[i / 8] |= uint8_t(1u << i % 8);
  const size_t hollow = inside_points(hull);
  drop_components(hull, 0.1);
  CHECK(hull.components == 1);
  CHECK(hull.dropped == 1);
  CHECK(volume(hull.surface) == Approx(4.0 / 3 * M_PI).epsilon(0.02));
  CHECK(inside_points(hull) > hollow + 300);
  CHECK(double(inside_points(hull)) * 0.06 * 0.06 * 0.06 == Approx(4.0 / 3 * M_PI).epsilon(0.02));
  check_closed(hull.surface);
}

TEST_CASE("smoothing keeps vertices on the outlines") {
  const std::vector<Silhouette> views = silhouettes(ring(9), ball);
  const Grid grid = grid_over({-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7}, 0.03);
  Options options;
  options.floor = Floor{{0, 1, 0}, -0.3};
  const Hull rough = carve(grid, views, options);
  options.smoothing = 10;
  const Hull smooth = carve(grid, views, options);
  check_closed(smooth.surface);
  REQUIRE(smooth.surface.faces == rough.surface.faces);
  // The hull's outline: the farthest of all signed distances.
  const auto off = [&](Vec3 p) {
    const double world[3] = {p.x, p.y, p.z};
    double farthest = -INFINITY;
    for (const Silhouette &view : views) farthest = std::max(farthest, view.view(world).pixels);
    return std::abs(farthest);
  };
  size_t moved_vertices = 0;
  for (size_t v = 0; v < smooth.surface.vertices.size(); v++) {
    const Vec3 before = rough.surface.vertices[v], after = smooth.surface.vertices[v];
    moved_vertices += length(after - before) > 0.05 * grid.cell;
    CHECK(length(after - before) <= 0.5 * grid.cell + 1e-12);
    CHECK(after.y >= -0.3 - 0.05 * grid.cell);
    if (before.y > -0.299) CHECK(off(after) <= std::max(options.tolerance, off(before)) + 1e-9);
    if (before.y < -0.3 + 1e-6) CHECK(length(after - before) == 0);
  }
  CHECK(moved_vertices > smooth.surface.vertices.size() / 10);
  CHECK(area(smooth.surface) < area(rough.surface));
  CHECK(volume(smooth.surface) == Approx(volume(rough.surface)).epsilon(0.01));
}

TEST_CASE("a cell that is too small is refused before memory is used") {
  const std::vector<Silhouette> views = silhouettes(ring(5), ball);
  const auto refused = [&](const Grid &grid) {
    try {
      carve(grid, views, {});
    } catch (const fvv::Error &error) {
      return error.kind == fvv::Error::usage;
    }
    return false;
  };
  CHECK(refused(grid_over({-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7}, 0.001)));
  CHECK(refused(grid_over({-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7}, 1e-6)));
  CHECK(refused(grid_over({-0.7, -0.7, -0.7}, {-0.7, 0.7, 0.7}, 0.1)));
}
