// The rasteriser: coverage, depth, barycentric coordinates, clipping.
#include "fvv_catch.h"

#include "fvv_render/rasteriser.h"
#include "fvv_render/scene_lengths.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace fvv::render;

namespace {

// Looks along the world's z axis; f a power of two, so that pixel positions can be hit exactly.
fvv_camera straight(uint32_t width, uint32_t height, double f) {
  fvv_camera camera = {};
  camera.lens = FVV_LENS_NONE;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = f;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  camera.r_max = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 9; i += 4) camera.rotation[i] = 1;
  return camera;
}

struct Triangles {
  std::vector<float> positions;
  std::vector<uint32_t> faces;
  uint32_t add(double x, double y, double z) {
    for (const double value : {x, y, z}) positions.push_back(float(value));
    return uint32_t(positions.size() / 3 - 1);
  }
  void quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) { faces.insert(faces.end(), {a, b, c, a, c, d}); }
  Mesh mesh() const { return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3}; }
};

// How many triangles hit each sample when each is drawn by itself.
std::vector<int> hits(const fvv_camera &camera, const Triangles &triangles, uint32_t samples) {
  const Projection projection(camera);
  SampleBuffer buffer(camera.width, camera.height, samples);
  std::vector<int> count(buffer.face.size());
  for (size_t i = 0; i < triangles.faces.size(); i += 3) {
    Mesh one = triangles.mesh();
    one.faces += i;
    one.face_count = 1;
    buffer.clear();
    rasterise(projection, one, buffer);
    for (size_t s = 0; s < count.size(); s++) count[s] += buffer.face[s] != no_face;
  }
  return count;
}

bool all_one(const std::vector<int> &count) {
  return std::all_of(count.begin(), count.end(), [](int n) { return n == 1; });
}

uint32_t next(uint32_t &state) {
  return state = state * 1664525 + 1013904223, state >> 8;
}

// Vertices over the whole picture in a grid of n x n cells; jitter in pixels, depths 1 m to 1 + relief m.
Triangles sheet(const fvv_camera &camera, int n, double jitter, double relief) {
  Triangles out;
  uint32_t state = 7;
  const auto wobble = [&] { return double(next(state) % 2001) / 1000 - 1; };
  for (int j = 0; j <= n; j++)
    for (int i = 0; i <= n; i++) {
      const double step_u = (camera.width + 2.0) / n, step_v = (camera.height + 2.0) / n;
      const double u = i * step_u - 1 + jitter * wobble(), v = j * step_v - 1 + jitter * wobble();
      const double z = 1 + relief * (wobble() + 1) / 2;
      out.add((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z);
    }
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      const uint32_t a = uint32_t(j * (n + 1) + i), b = a + 1, d = a + uint32_t(n) + 1, c = d + 1;
      // Both windings and both diagonals.
      if ((i + j) % 2)
        out.quad(a, b, c, d);
      else
        out.quad(d, a, b, c);
    }
  return out;
}

} // namespace

TEST_CASE("triangles that share edges cover every sample exactly once") {
  const fvv_camera camera = straight(64, 48, 64);
  for (const uint32_t samples : {1u, 3u}) {
    // The picture is two pixels smaller than the sheet. 33 cells of 2 pixels: edges and corners run right
    // through pixel centres only when the sheet starts at half a pixel.
    Triangles regular;
    for (int j = 0; j <= 50; j++)
      for (int i = 0; i <= 66; i++) regular.add((i - 0.5 - 32) / 64.0, (j - 0.5 - 24) / 64.0, 1);
    for (uint32_t j = 0; j < 50; j++)
      for (uint32_t i = 0; i < 66; i++) {
        const uint32_t a = j * 67 + i;
        if ((i + j) % 2)
          regular.quad(a, a + 1, a + 68, a + 67);
        else
          regular.quad(a + 67, a, a + 1, a + 68);
      }
    CHECK(all_one(hits(camera, regular, samples)));
    CHECK(all_one(hits(camera, sheet(camera, 20, 0.7, 0), samples)));
    CHECK(all_one(hits(camera, sheet(camera, 20, 0.4, 0.5), samples)));
    CHECK(all_one(hits(camera, sheet(camera, 3, 0, 5), samples)));
  }
}

TEST_CASE("samples on an edge belong to top and left edges") {
  const fvv_camera camera = straight(16, 16, 16);
  for (const bool mirrored : {false, true}) { // the other winding
    Triangles square;                         // from pixel centre (2.5, 3.5) to (10.5, 9.5)
    const double x0 = (2.5 - 8) / 16, x1 = (10.5 - 8) / 16, y0 = (3.5 - 8) / 16, y1 = (9.5 - 8) / 16;
    square.add(x0, y0, 1);
    square.add(x1, y0, 1);
    square.add(x1, y1, 1);
    square.add(x0, y1, 1);
    if (mirrored)
      square.quad(3, 2, 1, 0);
    else
      square.quad(0, 1, 2, 3);
    SampleBuffer buffer(16, 16, 1);
    rasterise(Projection(camera), square.mesh(), buffer);
    for (size_t y = 0; y < 16; y++)
      for (size_t x = 0; x < 16; x++) {
        INFO("pixel " << x << " " << y);
        CHECK((buffer.face[y * 16 + x] != no_face) == (x >= 2 && x < 10 && y >= 3 && y < 9));
      }
  }
}

TEST_CASE("a room around the camera is seen once in every direction, through the near plane and beyond it") {
  // Each wall in 4 x 4 cells: many triangles lie behind the camera, beside it, or reach from front to back.
  Triangles room;
  for (int axis = 0; axis < 3; axis++)
    for (const double side : {-1.0, 1.0})
      for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++) {
          const auto corner = [&](int u, int v) {
            double p[3];
            p[axis] = side;
            p[(axis + 1) % 3] = u * 0.5 - 1;
            p[(axis + 2) % 3] = v * 0.5 - 1;
            return room.add(p[0], p[1], p[2]);
          };
          room.quad(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
        }
  fvv_camera camera = straight(60, 40, 16); // 124 degrees wide
  const double angle = 0.4, c = std::cos(angle), s = std::sin(angle);
  const double tilted[9] = {c, 0, s, s * s, c, -s * c, -s * c, s, c * c};
  std::copy(tilted, tilted + 9, camera.rotation);
  for (const double eye : {0.0, 0.3, 0.95}) {
    camera.translation[0] = eye;
    CHECK(all_one(hits(camera, room, 3)));
  }
}

TEST_CASE("of a triangle from behind the camera only the part beyond the near plane is drawn") {
  const fvv_camera camera = straight(32, 32, 16);
  Triangles floor; // y = 0.5 below the camera, from 4 m behind to 4 m in front
  const uint32_t a = floor.add(-8, 0.5, -4), b = floor.add(8, 0.5, -4), c = floor.add(0, 0.5, 4);
  floor.faces = {a, b, c};
  SampleBuffer buffer(32, 32, 1);
  rasterise(Projection(camera), floor.mesh(), buffer);
  const double nearest = near_plane(floor.mesh());
  REQUIRE(nearest == 0.01);
  for (size_t y = 0; y < 32; y++)
    for (size_t x = 0; x < 32; x++) {
      const double v = (y + 0.5 - 16) / 16, u = (x + 0.5 - 16) / 16, z = v > 0 ? 0.5 / v : -1;
      const bool inside = z >= nearest && z < 4 && std::abs(u * z) < 4 - z;
      INFO("pixel " << x << " " << y);
      CHECK((buffer.face[y * 32 + x] == 0) == inside);
      if (inside) CHECK(buffer.depth[y * 32 + x] == Approx(z).epsilon(1e-6));
    }
}

TEST_CASE("depth is that of the plane, and barycentric coordinates are perspective-correct") {
  const fvv_camera camera = straight(64, 64, 32);
  Triangles plane; // z = 2 + 0.8 x + 0.3 y, larger than the picture
  for (const auto &corner : {std::array<double, 2>{-3.0, -2.2}, {9.0, -2.0}, {-3.0, 9.0}})
    plane.faces.push_back(plane.add(corner[0], corner[1], 2 + 0.8 * corner[0] + 0.3 * corner[1]));
  const Mesh mesh = plane.mesh();
  const Projection projection(camera);
  SampleBuffer buffer(64, 64, 3);
  rasterise(projection, mesh, buffer);
  size_t drawn = 0;
  for (size_t y = 0; y < 192; y++)
    for (size_t x = 0; x < 192; x++) {
      if (buffer.face[y * 192 + x] == no_face) continue;
      const double u = (x + 0.5) / 3, v = (y + 0.5) / 3;
      const double rx = (u - 32) / 32, ry = (v - 32) / 32, z = 2 / (1 - 0.8 * rx - 0.3 * ry);
      const auto weight = barycentric(projection, mesh, 0, u, v);
      double px = 0, py = 0;
      for (size_t i = 0; i < 3; i++) {
        px += weight[i] * double(plane.positions[3 * i]);
        py += weight[i] * double(plane.positions[3 * i + 1]);
      }
      // Samples that only the rounding of vertices covers are clamped to the triangle.
      const bool at_edge = std::min({weight[0], weight[1], weight[2]}) < 1e-3;
      const double tolerance = at_edge ? 1e-2 : 1e-6;
      if (std::abs(buffer.depth[y * 192 + x] - z) > tolerance * z || std::abs(px - rx * z) > tolerance * z ||
          std::abs(py - ry * z) > tolerance * z)
        FAIL("pixel " << u << " " << v << ": depth " << buffer.depth[y * 192 + x] << " for " << z << ", x "
                      << px << " for " << rx * z);
      drawn++;
    }
  CHECK(drawn > 10000);
}

TEST_CASE("triangles behind the camera, without area or not finite are not drawn") {
  const fvv_camera camera = straight(16, 16, 16);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<std::vector<float>> bad = {
      {-1, -1, -1, 1, -1, -1, 0, 1, -1},             // behind
      {-1, -1, 0.005f, 1, -1, 0.005f, 0, 1, 0.005f}, // nearer than the near plane
      {-1, -1, 2, 1, 1, 2, 0, 0, 2},                 // a line
      {0, 0, 2, 0, 0, 2, 0, 0, 2},                   // a point
      {-1, -1, nan, 1, -1, 2, 0, 1, 2},
      {-1, -1, inf, 1, -1, 2, 0, 1, 2},
      {-inf, -1, 2, 1, -1, 2, 0, 1, 2},
      {-1, 0, 1, 1, 0, 1, 0, 0, 3}}; // edge-on
  for (const auto &positions : bad) {
    const uint32_t face[3] = {0, 1, 2};
    SampleBuffer buffer(16, 16, 3);
    rasterise(Projection(camera), {positions.data(), 3, face, 1}, buffer);
    INFO("triangle from " << positions[0] << " " << positions[1] << " " << positions[2]);
    CHECK(std::count(buffer.face.begin(), buffer.face.end(), no_face) == 48 * 48);
    CHECK(std::count(buffer.depth.begin(), buffer.depth.end(), inf) == 48 * 48);
  }
}

TEST_CASE("the nearer face is seen in either order, at equal depth the first") {
  const fvv_camera camera = straight(8, 8, 8);
  Triangles two;
  for (const double z : {2.0, 1.0}) {
    const uint32_t a = two.add(-4, -4, z);
    two.add(12, -4, z);
    two.add(-4, 12, z);
    two.faces.insert(two.faces.end(), {a, a + 1, a + 2});
  }
  const Projection projection(camera);
  SampleBuffer buffer(8, 8, 1);
  rasterise(projection, two.mesh(), buffer);
  CHECK(std::count(buffer.face.begin(), buffer.face.end(), 1u) == 64);
  std::swap_ranges(two.faces.begin(), two.faces.begin() + 3, two.faces.begin() + 3);
  buffer.clear();
  rasterise(projection, two.mesh(), buffer);
  CHECK(std::count(buffer.face.begin(), buffer.face.end(), 0u) == 64);
  std::copy(two.faces.begin(), two.faces.begin() + 3, two.faces.begin() + 3);
  buffer.clear();
  rasterise(projection, two.mesh(), buffer);
  CHECK(std::count(buffer.face.begin(), buffer.face.end(), 0u) == 64);
}

TEST_CASE("a vertex is projected to where fvv_camera_project puts it") {
  fvv_camera camera = straight(640, 360, 500);
  camera.fy = 497;
  camera.skew = 1.5;
  camera.cx = 311.25;
  const double c = std::cos(0.7), s = std::sin(0.7);
  const double turned[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
  std::copy(turned, turned + 9, camera.rotation);
  camera.translation[0] = 0.3;
  camera.translation[1] = -1.2;
  camera.translation[2] = 4;
  const Projection projection(camera);
  uint32_t state = 3;
  for (int i = 0; i < 100; i++) {
    double world[3], pixel[2], depth;
    for (double &value : world) value = double(next(state) % 4000) / 1000 - 2;
    REQUIRE(fvv_camera_project(&camera, world, pixel, &depth) == 1);
    const Vec3 at = projection.to_camera({world[0], world[1], world[2]}),
               homogeneous = projection.to_pixel(at);
    CHECK(homogeneous.x / homogeneous.z == Approx(pixel[0]).margin(1e-9));
    CHECK(homogeneous.y / homogeneous.z == Approx(pixel[1]).margin(1e-9));
    CHECK(homogeneous.z == Approx(depth).margin(1e-12));
    const Vec3 ray = projection.ray(pixel[0], pixel[1]);
    CHECK(length(cross(ray, at)) < 1e-9);
  }
}

TEST_CASE("rays through a lens are those of fvv_camera_unproject to a thousandth of a pixel") {
  for (const uint32_t width : {64u, 101u, 963u}) {
    fvv_camera camera = straight(width, width * 3 / 4, width * 0.7);
    camera.lens = FVV_LENS_RADTAN;
    const double distortion[8] = {-0.2, 0.045, 0.001, -0.001};
    std::copy_n(distortion, 8, camera.distortion);
    camera.r_max = fvv_camera_r_max(&camera);
    const Projection projection(camera);
    uint32_t state = 3;
    double worst = 0;
    for (int i = 0; i < 3000; i++) {
      const double pixel[2] = {camera.width * double(next(state) % 10001) / 10000,
                               camera.height * double(next(state) % 10001) / 10000};
      double expected[3];
      REQUIRE(fvv_camera_unproject(&camera, pixel, expected) == 1);
      const Vec3 ray = projection.ray(pixel[0], pixel[1]);
      worst = std::max(worst, length(ray - Vec3{expected[0], expected[1], expected[2]}) * camera.fx);
    }
    INFO(width);
    CHECK(worst < (width < 500 ? 0.01 : 0.001)); // rays bend within wide pixels
  }
}

TEST_CASE("a buffer that takes another size is clear") {
  Triangles all;
  all.add(-9, -9, 2);
  all.add(9, -9, 2);
  all.add(0, 12, 2);
  all.faces = {0, 1, 2};
  SampleBuffer buffer(16, 12, 3);
  for (const auto &[width, height] : {std::pair{16u, 12u}, {5u, 4u}, {40u, 30u}, {7u, 64u}}) {
    buffer.resize(width, height);
    CHECK(buffer.face == std::vector<uint32_t>(size_t(width) * height * 9, no_face));
    CHECK(std::count(buffer.depth.begin(), buffer.depth.end(), INFINITY) == int(width * height * 9));
    rasterise(Projection(straight(width, height, 8)), all.mesh(), buffer);
    CHECK(std::count(buffer.face.begin(), buffer.face.end(), 0u) > 100);
  }
}

TEST_CASE("through a lens a tilted sheet is seen within its outline, at its depth") {
  fvv_camera camera = straight(320, 240, 300);
  camera.lens = FVV_LENS_RADTAN;
  const double distortion[8] = {-0.2, 0.04, 0.001, -0.0008};
  std::copy_n(distortion, 8, camera.distortion);
  camera.r_max = fvv_camera_r_max(&camera);
  // z = 2 + 0.3 x over |x| <= 0.7, |y| <= 0.5, in triangles of 2 cm (3 pixels).
  Triangles sheet;
  for (int j = 0; j <= 50; j++)
    for (int i = 0; i <= 70; i++) sheet.add(i / 50.0 - 0.7, j / 50.0 - 0.5, 2 + 0.3 * (i / 50.0 - 0.7));
  for (uint32_t j = 0; j < 50; j++)
    for (uint32_t i = 0; i < 70; i++) {
      const uint32_t a = j * 71 + i;
      sheet.quad(a, a + 1, a + 72, a + 71);
    }
  const Projection projection(camera);
  SampleBuffer buffer(320, 240, 3);
  rasterise(projection, sheet.mesh(), buffer);
  size_t covered = 0, wrong = 0;
  double worst_depth = 0, worst_ray = 0;
  for (size_t row = 0; row < 720; row++)
    for (size_t column = 0; column < 960; column++) {
      const double pixel[2] = {(double(column) + 0.5) / 3, (double(row) + 0.5) / 3};
      double ray[3];
      REQUIRE(fvv_camera_unproject(&camera, pixel, ray) == 1);
      const Vec3 used = projection.ray(pixel[0], pixel[1]);
      worst_ray = std::max(worst_ray, 300 * std::hypot(used.x - ray[0], used.y - ray[1]));
      const double z = 2 / (1 - 0.3 * ray[0]), x = ray[0] * z, y = ray[1] * z;
      const double to_outline = std::min(0.7 - std::abs(x), 0.5 - std::abs(y)); // metres, positive within
      const size_t at = row * 960 + column;
      const bool seen = buffer.face[at] != no_face;
      covered += seen;
      if (std::abs(to_outline) > 0.01 * 2 / 300) wrong += seen != (to_outline > 0); // 0.01 pixels
      if (seen) worst_depth = std::max(worst_depth, std::abs(double(buffer.depth[at]) - z));
    }
  CHECK(covered > 200000);
  CHECK(wrong == 0);
  CHECK(worst_ray < 1e-3);
  CHECK(worst_depth < 1e-5);
}

TEST_CASE("without depth the same samples are covered, with a lens and without") {
  for (const bool bent : {false, true}) {
    fvv_camera camera = straight(160, 120, 128);
    if (bent) {
      camera.lens = FVV_LENS_RADTAN;
      camera.distortion[0] = -0.2;
      camera.r_max = fvv_camera_r_max(&camera);
    }
    Triangles soup;
    uint32_t state = 7;
    for (int i = 0; i < 600; i++)
      soup.faces.push_back(soup.add(next(state) % 1000 / 250.0 - 2, next(state) % 1000 / 250.0 - 2,
                                    0.5 + next(state) % 1000 / 250.0));
    SampleBuffer seen(160, 120, 3), covered(160, 120, 3);
    rasterise(Projection(camera), soup.mesh(), seen);
    rasterise_coverage(Projection(camera, Projection::Rays::none), soup.mesh(), covered);
    size_t count = 0;
    for (size_t s = 0; s < seen.face.size(); s++) {
      REQUIRE((seen.face[s] == no_face) == (covered.face[s] == no_face));
      REQUIRE(covered.depth[s] == std::numeric_limits<float>::infinity());
      count += seen.face[s] != no_face;
    }
    CHECK(count > 20000);
  }
}

TEST_CASE("triangles with a corner beyond the lens are not drawn") {
  fvv_camera camera = straight(64, 64, 64);
  camera.lens = FVV_LENS_RADTAN;
  camera.distortion[0] = -0.1;
  camera.r_max = fvv_camera_r_max(&camera);
  Triangles out;
  for (const double far : {4.0, 0.2}) { // at 2 m: a direction of 2, and of 0.1
    const uint32_t a = out.add(0, 0, 2);
    out.add(far, 0, 2);
    out.add(0, 0.2, 2);
    out.faces.insert(out.faces.end(), {a, a + 1, a + 2});
    SampleBuffer buffer(64, 64, 1);
    rasterise(Projection(camera), out.mesh(), buffer);
    CHECK(std::count(buffer.face.begin(), buffer.face.end(), 0u) == 0);
    if (far < 1) CHECK(std::count(buffer.face.begin(), buffer.face.end(), 1u) > 10);
  }
}

TEST_CASE("other sizes and even samples are refused") {
  SampleBuffer smaller(8, 16, 1);
  CHECK_THROWS_AS(rasterise(Projection(straight(16, 16, 16)), Mesh(), smaller), std::invalid_argument);
  CHECK_THROWS_AS(SampleBuffer(8, 8, 2), std::invalid_argument);
  CHECK_THROWS_AS(SampleBuffer(8, 16385, 1), std::invalid_argument);
}
