// The surface that cameras show and that lies inside the mesh: how it is drawn and how its depth is found.
#include "fvv_render/texture_inset.h"

#include "fvv_catch.h"
#include "view_fixture.h"

#include <deque>

namespace {

using namespace view_fixture;

// Bands of 0.2 that go smoothly from dark to light, across both axes.
Vec3 bands(Vec3 at) {
  const double value = 0.5 + 0.2 * std::sin(31.4 * at.x) + 0.2 * std::sin(31.4 * at.y + 1);
  return {value, 1 - value, 0.5};
}

// Cameras around a plane z = 0, which they show, and its mesh outside of it, nearer to them.
struct Scene {
  Scene(double outside, const std::vector<Vec3> &eyes) {
    shape.square(1, -outside);
    for (const Vec3 eye : eyes) sources.film(looking(eye, {}, 320, 240, 420), bands);
  }
  HeldOutFrame frame() const {
    HeldOutFrame out = {shape.mesh(), {}};
    for (const SourceView &view : sources.views) out.views.push_back({view});
    return out;
  }
  Shape shape;
  Sources sources;
};

const std::vector<Vec3> around = {
    {0, 0, -4}, {1.5, 0, -3.7}, {-1.5, 0.5, -3.7}, {0, 1.6, -3.7}, {0.3, -1.7, -3.6}};

} // namespace

TEST_CASE("colours come from the surface that lies inside the mesh, the outline from the mesh") {
  const double outside = 0.03;
  const Scene scene(outside, around);
  ViewOptions options;
  options.inset = outside;
  const fvv_camera target = looking({1, -1, -3}, {}, 200, 150, 180);
  const ViewPicture moved = render(scene.shape, scene.sources, target, options),
                    unmoved = render(scene.shape, scene.sources, target);
  REQUIRE(moved.depth == unmoved.depth);
  REQUIRE(moved.coverage == unmoved.coverage);
  double with = 0, without = 0;
  size_t inside = 0;
  for (uint32_t y = 0; y < target.height; y++)
    for (uint32_t x = 0; x < target.width; x++) {
      const size_t pixel = size_t(y) * target.width + x;
      // Behind the border of the mesh the viewer sees more of the plane than cameras show.
      if (moved.coverage[pixel] < 1 || moved.contributions[3 * pixel].source == no_source) continue;
      const Vec3 truth = bands(on_plane(target, x + 0.5, y + 0.5, 0));
      with = std::max(with, farthest(colour_of(moved, pixel), truth));
      without = std::max(without, farthest(colour_of(unmoved, pixel), truth));
      inside++;
    }
  REQUIRE(inside > 3000);
  REQUIRE(with < 0.02);
  REQUIRE(without > 0.05);
}

TEST_CASE("what hides a point, and what is beyond 60 degrees, does not follow the inset") {
  Shape shape;
  shape.square(1, 0);
  shape.square(0.3, -0.02); // before the middle
  Sources sources;
  sources.film(looking({0, 0, -4}, {}, 320, 240, 420), bands);
  ViewOptions options;
  options.inset = 0.5;
  // The surface that is shown lies behind the large square, which does not hide it.
  const fvv_camera front = looking({0, 0, -3}, {}, 100, 100, 100);
  const ViewPicture picture = render(shape, sources, front, options);
  for (const size_t pixel : {50 * 100 + 50, 50 * 100 + 70})
    REQUIRE(picture.contributions[3 * pixel].source == 0);
  // At 75 degrees from the normal the way inward is no longer than at 60.
  options.inset = 0.01;
  const Vec3 eye = {3 * std::sin(1.309), 0, -3 * std::cos(1.309)};
  const fvv_camera flat = looking(eye, {0.5, 0, 0}, 1, 1, 100);
  Shape plane;
  plane.square(1, 0);
  const ViewPicture spot = render(plane, sources, flat, options);
  const Vec3 towards = normalised(eye - Vec3{0.5, 0, 0}), shown = Vec3{0.5, 0, 0} - towards * 0.02;
  // Where the camera, 4 away, sees the shown point on the plane.
  const double scale = 4 / (4 + shown.z);
  REQUIRE(farthest(colour_of(spot, 0), bands({shown.x * scale, shown.y * scale, 0})) < 0.02);
}

TEST_CASE("the inset is found by drawing cameras from each other", "[slow]") {
  for (const double outside : {0.004, 0.012}) {
    const Scene scene(outside, around);
    const TextureInset found = find_texture_inset({scene.frame()}, {});
    CHECK(found.inset > 0.85 * outside);
    CHECK(found.inset < 1.15 * outside);
    CHECK(found.views == 5);
    CHECK(found.better == 5);
    CHECK(found.pixels > 5000);
    CHECK(found.after > found.before + 1);
    // Several frames, and threads in any order, change nothing of that.
    ViewOptions backwards;
    backwards.executor = [](size_t count, const std::function<void(size_t)> &work) {
      while (count) work(--count);
    };
    const TextureInset again = find_texture_inset({scene.frame()}, backwards);
    CHECK(again.inset == found.inset);
    CHECK(again.after == found.after);
    CHECK(std::abs(find_texture_inset({scene.frame(), scene.frame()}, {}).inset - found.inset) < 1e-9);
  }
}

TEST_CASE("a mesh that is right has no inset, nor has one that no two cameras share") {
  const Scene right(0, around);
  const TextureInset exact = find_texture_inset({right.frame()}, {});
  CHECK(exact.inset == 0);
  CHECK(exact.pixels > 5000);
  CHECK(exact.after - exact.before < least_gain);
  // A mesh within the body would need colours from outside of it.
  const Scene inner(-0.01, around);
  CHECK(find_texture_inset({inner.frame()}, {}).inset == 0);
  const Scene alone(0.01, {{0, 0, -4}});
  const TextureInset nothing = find_texture_inset({alone.frame()}, {});
  CHECK(nothing.inset == 0);
  CHECK(nothing.pixels < least_compared);
  CHECK(find_texture_inset({}, {}).inset == 0);
  CHECK(find_texture_inset({{alone.shape.mesh(), {}}}, {}).inset == 0);
}

TEST_CASE("pixels beside the mask are not compared") {
  const Scene scene(0.01, around);
  std::deque<std::vector<uint8_t>> masks;
  HeldOutFrame frame = scene.frame();
  for (HeldOutView &view : frame.views) {
    std::vector<uint8_t> &mask = masks.emplace_back(320 * 240, 255);
    for (size_t i = 0; i < mask.size(); i++) mask[i] = i % 320 < 160 ? 127 : 128;
    view.mask = mask.data();
  }
  const size_t all = find_texture_inset({scene.frame()}, {}).pixels,
               half = find_texture_inset({frame}, {}).pixels;
  CHECK(half > all / 3);
  CHECK(half < 2 * all / 3);
}

TEST_CASE("a picture of a few pixels, or a single row, has an inset of none") {
  Scene scene(0.01, {{0, 0, -4}, {1, 0, -4}});
  for (const auto &[width, height] : {std::pair{3u, 2u}, {4000u, 1u}, {1u, 16000u}}) {
    Sources small;
    for (const Vec3 eye : {Vec3{0, 0, -4}, Vec3{1, 0, -4}})
      small.film(looking(eye, {}, width, height, width), bands);
    HeldOutFrame frame = {scene.shape.mesh(), {}};
    for (const SourceView &view : small.views) frame.views.push_back({view});
    CHECK(find_texture_inset({frame}, {}).inset == 0);
  }
}
