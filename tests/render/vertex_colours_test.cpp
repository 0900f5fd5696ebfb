// Colours of vertices: from the cameras that show them well, from their neighbours where none does, and shown
// in pictures.
#include "fvv_render/vertex_colours.h"

#include "fvv_catch.h"
#include "view_fixture.h"

#include <algorithm>
#include <optional>

namespace {

using namespace view_fixture;

// The square |x|, |y| <= 1 in the plane z = 0, its front towards -z, n x n vertices.
Shape sheet(uint32_t n) {
  Shape shape;
  for (uint32_t i = 0; i < n * n; i++)
    for (const double value : {2.0 * (i % n) / (n - 1) - 1, 2.0 * (i / n) / (n - 1) - 1, 0.0})
      shape.positions.push_back(float(value));
  for (uint32_t y = 0; y + 1 < n; y++)
    for (uint32_t x = 0; x + 1 < n; x++) {
      const uint32_t a = y * n + x;
      for (const uint32_t i : {a, a + n, a + 1, a + 1, a + n, a + n + 1}) shape.faces.push_back(i);
    }
  return shape;
}

VertexColours vertex_colours(const Mesh &mesh, const std::vector<ColourView> &views) {
  VertexColourGatherer gatherer(mesh);
  for (const ColourView &view : views) gatherer.add(view);
  return gatherer.colours();
}

// A picture of 8 bits of what a camera sees on the plane z = 0.
template <class Colour> std::vector<uint8_t> filmed(const fvv_camera &camera, const Colour &colour) {
  std::vector<uint8_t> out;
  for (uint32_t y = 0; y < camera.height; y++)
    for (uint32_t x = 0; x < camera.width; x++) {
      const Vec3 c = colour(on_plane(camera, x + 0.5, y + 0.5, 0));
      for (const double value : {c.x, c.y, c.z})
        out.push_back(uint8_t(std::lround(255 * std::fmin(std::fmax(value, 0), 1))));
    }
  return out;
}

// Largest difference from a colour, of 255, over the vertices with x from least to most.
template <class Colour>
double error_of(const VertexColours &found, const Shape &shape, const Colour &colour, double least = -2,
                double most = 2) {
  double worst = 0;
  for (size_t v = 0; v < found.weight.size(); v++) {
    const float *p = &shape.positions[3 * v];
    if (p[0] < least || p[0] > most) continue;
    const Vec3 wanted = colour(Vec3{p[0], p[1], p[2]});
    const uint8_t *rgb = &found.rgb[3 * v];
    worst = std::max(worst, farthest(Vec3{double(rgb[0]), double(rgb[1]), double(rgb[2])}, wanted * 255));
  }
  return worst;
}

} // namespace

TEST_CASE("vertices have the colours that cameras show, and one camera that differs counts little") {
  const Shape shape = sheet(21);
  std::vector<fvv_camera> cameras;
  std::vector<std::vector<uint8_t>> pictures;
  for (const double x : {-1.0, 0.0, 1.0, 2.0}) {
    cameras.push_back(looking({x, 0.5, -4}, {}, 320, 240, 300));
    pictures.push_back(filmed(cameras.back(), gradient));
  }
  std::vector<ColourView> views;
  for (size_t i = 0; i < cameras.size(); i++) views.push_back({cameras[i], pictures[i].data()});
  const VertexColours found = vertex_colours(shape.mesh(), views);
  CHECK(error_of(found, shape, gradient) < 2);
  CHECK(std::count(found.weight.begin(), found.weight.end(), 255) == 21 * 21);
  std::fill(pictures[3].begin(), pictures[3].end(), uint8_t(255));
  CHECK(error_of(vertex_colours(shape.mesh(), views), shape, gradient) < 8);
}

TEST_CASE("what no camera shows has colours from around it, never a constant") {
  const Shape shape = sheet(41);
  // The camera sees the left half.
  const fvv_camera camera = looking({0, 0, -4}, {}, 320, 240, 300);
  const auto halves = [](Vec3 at) { return Vec3{0.9, at.y > 0 ? 0.8 : 0.2, 0.1}; };
  const std::vector<uint8_t> picture = filmed(camera, halves);
  std::vector<uint8_t> seen(shape.positions.size() / 3);
  for (size_t v = 0; v < seen.size(); v++) seen[v] = shape.positions[3 * v] < 0 ? 255 : 0;
  const VertexColours found = vertex_colours(shape.mesh(), {{camera, picture.data(), nullptr, seen.data()}});
  size_t unseen = 0;
  for (size_t v = 0; v < seen.size(); v++) {
    CHECK((found.weight[v] > 0) == (seen[v] > 0));
    unseen += !seen[v];
    CHECK(std::abs(found.rgb[3 * v] - 230) <= 1);
    // Far from where the colours meet, those of the same side.
    if (std::abs(shape.positions[3 * v + 1]) > 0.9 && shape.positions[3 * v] < 0.3)
      CHECK(std::abs(found.rgb[3 * v + 1] - (shape.positions[3 * v + 1] > 0 ? 204 : 51)) < 20);
  }
  CHECK(unseen > 800);
  // A piece that no camera shows, and a mesh without cameras.
  Shape two = shape;
  two.square(0.2, 3);
  seen.resize(seen.size() + 4);
  const VertexColours more = vertex_colours(two.mesh(), {{camera, picture.data(), nullptr, seen.data()}});
  CHECK(std::abs(more.rgb[3 * (seen.size() - 1)] - 230) <= 1);
  const VertexColours none = vertex_colours(two.mesh(), {});
  CHECK(std::all_of(none.rgb.begin(), none.rgb.end(), [](uint8_t value) { return value == 128; }));
}

TEST_CASE("colours next to a silhouette are not mixed with what lies behind") {
  const Shape shape = sheet(41);
  const fvv_camera camera = looking({0, 0, -4}, {}, 320, 240, 300);
  // Behind the right half, which the mask leaves out, there is white, which matting has drawn over its edge.
  const std::vector<uint8_t> picture = filmed(camera, [](Vec3 at) {
    return at.x > -0.03 ? Vec3{1, 1, 1} : Vec3{0.2, 0.4, 0.1};
  });
  std::vector<uint8_t> mask;
  for (uint32_t i = 0; i < camera.width * camera.height; i++)
    mask.push_back(on_plane(camera, i % camera.width + 0.5, i / camera.width + 0.5, 0).x < 0 ? 255 : 0);
  const VertexColours found = vertex_colours(shape.mesh(), {{camera, picture.data(), mask.data()}});
  for (size_t v = 0; v < found.weight.size(); v++)
    if (found.weight[v] == 255) CHECK(std::abs(found.rgb[3 * v] - 51) <= 1);
  CHECK(std::count(found.weight.begin(), found.weight.end(), 255) > 600);
}

TEST_CASE(
    "pictures show colours of vertices where no camera shows the surface, and shade them without cameras") {
  Shape shape;
  shape.square(1, 0);
  const std::vector<uint8_t> colours = {250, 50, 0, 250, 50, 0, 250, 50, 0, 250, 50, 0};
  const Vec3 own = Vec3{250, 50, 0} * (1 / 255.0);
  ViewOptions options;
  options.vertex_colours = colours.data();
  const fvv_camera target = looking({1, 0, -3}, {}, 100, 80, 90);
  const size_t centre = 40 * 100 + 50;
  // Of a camera behind the surface.
  Sources behind;
  behind.plain(looking({0, 0, 4}, {}, 64, 48, 50), {0, 1, 0});
  CHECK(farthest(colour_of(render(shape, behind, target, options), centre), own) < 1e-6);
  options.vertex_colours = nullptr;
  CHECK(farthest(colour_of(render(shape, behind, target, options), centre), {0.5, 0.5, 0.5}) < 1e-6);
  options.vertex_colours = colours.data();
  // The lamp is at the viewer's left shoulder, the sky above: the normal is (0, 0, -1).
  const double *r = target.rotation;
  const Vec3 lamp =
      normalised(normalised(Vec3{1, 0, -3}) - Vec3{r[3], r[4], r[5]} * 0.6 - Vec3{r[0], r[1], r[2]} * 0.5);
  const double light = 0.38 + 0.3 * (0.5 + 0.5 * r[5]) + 0.62 * -lamp.z;
  CHECK(farthest(colour_of(render(shape, {}, target, options), centre), own * light) < 2e-3);
}

TEST_CASE("colours of cameras change to those of vertices without jumps") {
  Shape shape;
  shape.square(1, 0);
  const std::vector<uint8_t> colours = {250, 50, 0, 250, 50, 0, 250, 50, 0, 250, 50, 0};
  const fvv_camera target = looking({0.2, 0, -3}, {0.2, 0, 0}, 1, 1, 9);
  ViewOptions options;
  options.vertex_colours = colours.data();
  const auto largest_step = [&](Blend blend) {
    options.blend = blend;
    options.threshold = blend == Blend::paper ? 0.25 : 0.05;
    double largest = 0;
    std::optional<Vec3> former;
    for (int i = 0; i <= 1000; i++) {
      // A camera in front that goes around to the side, and sinks below the horizon of the surface.
      Sources sources;
      const double cosine = 0.6 - 0.7 * i / 1000;
      sources.plain(looking({3 * std::sqrt(1 - cosine * cosine), 0, -3 * cosine}, {}, 64, 64, 60), {0, 1, 0});
      const Vec3 colour = colour_of(render(shape, sources, target, options), 0);
      if (former) largest = std::max(largest, farthest(colour, *former));
      if (i == 0) CHECK(farthest(colour, {0, 1, 0}) < 1e-6);
      if (i == 1000) CHECK(farthest(colour, Vec3{250, 50, 0} * (1 / 255.0)) < 1e-6);
      former = colour;
    }
    return largest;
  };
  CHECK(largest_step(Blend::viewer) < 0.02);
  CHECK(largest_step(Blend::paper) > 0.5);
}
