// View-dependent texture against directly computed pictures.
#include "fvv_catch.h"

#include "fvv_render/scene_lengths.h"
#include "view_fixture.h"

#include <algorithm>

using namespace view_fixture;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A picture of 1 x 1 pixel whose ray meets the point.
fvv_camera spot(Vec3 point) {
  return looking(point + Vec3{0, 0, -3}, point, 1, 1, 100);
}

// At this angle to the front of the plane z = 0, round about the axis.
Vec3 at_angle(double cosine, double round, double distance = 4) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return Vec3{sine * std::cos(round), sine * std::sin(round), -cosine} * distance;
}

std::vector<uint32_t> used(const ViewPicture &picture) {
  std::vector<uint32_t> out;
  for (const Contribution &c : picture.contributions)
    if (c.source != no_source) out.push_back(c.source);
  return out;
}

// Of a square of side 2 with a gradient: the largest difference from the computed one, where the outline is
// more than 0.1 pixel away; coverage and depth have to be right there.
double largest_error(const ViewPicture &picture, const fvv_camera &target, size_t &inside) {
  double worst = 0;
  for (uint32_t y = 0; y < target.height; y++)
    for (uint32_t x = 0; x < target.width; x++) {
      const size_t pixel = size_t(y) * target.width + x;
      bool all = true, none = true;
      for (const double du : {0.4, 0.5, 0.6})
        for (const double dv : {0.4, 0.5, 0.6}) {
          const Vec3 p = on_plane(target, x + du, y + dv, 0);
          const bool in = std::abs(p.x) < 1 && std::abs(p.y) < 1;
          all = all && in;
          none = none && !in;
        }
      if (!all && !none) continue;
      REQUIRE(picture.coverage[pixel] == (all ? 1.0f : 0.0f));
      REQUIRE((picture.face[pixel] != no_face) == all);
      if (!all) continue;
      inside++;
      const Vec3 p = on_plane(target, x + 0.5, y + 0.5, 0);
      worst = std::max(worst, farthest(colour_of(picture, pixel), gradient(p)));
      const double *r = target.rotation;
      const double depth = r[6] * p.x + r[7] * p.y + r[8] * p.z + target.translation[2];
      REQUIRE(std::abs(double(picture.depth[pixel]) - depth) < 1e-4);
    }
  return worst;
}

} // namespace

TEST_CASE("a view of a textured plane is the computed one") {
  Shape shape;
  shape.square(1, 0);
  Sources sources;
  sources.film(looking({0, 0, -4}, {}, 640, 480, 600), gradient);
  sources.film(with_lens(looking({-1.5, 1, -3}, {}, 640, 480, 500), -0.2, 0.05), gradient);
  sources.film(looking({2, 0.5, -3}, {0.2, 0, 0}, 320, 240, 250), gradient);
  const auto visibility = GENERATE(Visibility::depth_map, Visibility::rays);
  ViewOptions options;
  options.visibility = visibility;
  for (const fvv_camera &target : {looking({1, -1, -3}, {}, 200, 150, 180),
                                   with_lens(looking({1, -1, -2.2}, {}, 200, 150, 110), -0.25, 0.04),
                                   with_lens(looking({0.3, 0.2, -2}, {}, 201, 151, 90), 0.15, 0)}) {
    const ViewPicture picture = render(shape, sources, target, options);
    size_t inside = 0;
    REQUIRE(largest_error(picture, target, inside) < 1.0 / 255);
    REQUIRE(inside > 3000);
  }
}

TEST_CASE("weights of the paper are cosines over their sum, of the best three above the threshold") {
  Shape shape;
  shape.square(1, 0);
  const std::vector<double> cosines = {0.3, 0.9, 0.2499, 0.5, 0.2501, 0.7};
  Sources sources;
  for (size_t i = 0; i < cosines.size(); i++)
    sources.plain(looking(at_angle(cosines[i], double(i)), {}, 64, 64, 60), {0.1 * double(i), 0.2, 1});
  ViewOptions paper;
  paper.blend = Blend::paper;
  paper.threshold = 0.25;
  const ViewPicture picture = render(shape, sources, spot({}), paper);
  REQUIRE(used(picture) == std::vector<uint32_t>{1, 5, 3});
  double sum = 0;
  for (const Contribution &c : picture.contributions) {
    REQUIRE(std::abs(double(c.weight) - cosines[c.source] / 2.1) < 1e-6);
    sum += double(c.weight);
  }
  REQUIRE(std::abs(sum - 1) < 1e-6);
  const Vec3 expected = {(0.1 * 0.9 + 0.5 * 0.7 + 0.3 * 0.5) / 2.1, 0.2, 1};
  REQUIRE(farthest(colour_of(picture, 0), expected) < 1e-4);

  ViewOptions more = paper;
  more.best = 8;
  REQUIRE(used(render(shape, sources, spot({}), more)) == std::vector<uint32_t>{1, 5, 3, 0, 4});
  more.threshold = 0.2498;
  REQUIRE(used(render(shape, sources, spot({}), more)) == std::vector<uint32_t>{1, 5, 3, 0, 4, 2});
  more.best = 1;
  REQUIRE(used(render(shape, sources, spot({}), more)) == std::vector<uint32_t>{1});
  REQUIRE(used(render(shape, sources, spot({}), more, 1)) == std::vector<uint32_t>{5});
}

TEST_CASE("weights by the viewer's direction are those of clause 17.5") {
  Shape shape;
  shape.square(1, 0);
  const std::vector<double> cosines = {0.3, 0.9, 0.04, 0.5, 0.7};
  Sources sources;
  for (size_t i = 0; i < cosines.size(); i++)
    sources.plain(looking(at_angle(cosines[i], double(i)), {}, 64, 64, 60), {0.1 * double(i), 0.2, 1});
  ViewOptions options;
  options.best = 2;
  const fvv_camera target = spot({});
  const ViewPicture picture = render(shape, sources, target, options);
  double centre[3];
  fvv_camera_centre(&target, centre);
  std::vector<std::pair<double, uint32_t>> expected;
  for (uint32_t i = 0; i < cosines.size(); i++) {
    const double apart = 1.01 - dot(normalised(at_angle(cosines[i], double(i))),
                                    normalised({centre[0], centre[1], centre[2]}));
    if (cosines[i] > 0.05) expected.emplace_back((cosines[i] - 0.05) / 0.95 / (apart * apart), i);
  }
  std::sort(expected.rbegin(), expected.rend());
  const double next = expected[2].first * 1023 / 1024, sum = expected[0].first + expected[1].first - 2 * next;
  REQUIRE(used(picture) == std::vector<uint32_t>{expected[0].second, expected[1].second});
  for (size_t k = 0; k < 2; k++)
    REQUIRE(std::abs(double(picture.contributions[k].weight) - (expected[k].first - next) / sum) < 1e-6);
}

// Six cameras around a square whose visibility weights fall from 255 to 0, each at another corner.
TEST_CASE("colours change without jumps as the viewer moves, and over the surface") {
  Shape shape;
  shape.square(1, 0);
  Sources sources;
  std::vector<std::vector<uint8_t>> seen;
  for (size_t i = 0; i < 6; i++) {
    sources.plain(looking(at_angle(0.3 + 0.1 * double(i), double(i)), {}, 64, 64, 60),
                  {double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)});
    seen.push_back({255, 255, 255, 255});
    seen.back()[i % 4] = 0;
  }
  for (size_t i = 0; i < 6; i++) sources.views[i].visible_vertices = seen[i].data();
  ViewOptions options;
  options.visibility = Visibility::given;
  const auto largest_step = [&](Blend blend, const auto &target_at) {
    options.blend = blend;
    options.threshold = blend == Blend::paper ? 0.25 : 0.05;
    double largest = 0;
    std::optional<Vec3> former;
    for (int i = 0; i < 2000; i++) {
      const Vec3 colour = colour_of(render(shape, sources, target_at(i / 2000.0), options), 0);
      if (former) largest = std::max(largest, farthest(colour, *former));
      former = colour;
    }
    return largest;
  };
  const auto around = [](double t) {
    return looking({3 * std::cos(6 * t), 3 * std::sin(6 * t), -1.5}, {0.2, 0.1, 0}, 1, 1, 9);
  };
  const auto across = [](double t) {
    return looking({1.7 * t - 0.85, 0.9 * t - 0.5, -2}, {1.7 * t - 0.85, 0.9 * t - 0.5, 0}, 1, 1, 9);
  };
  REQUIRE(largest_step(Blend::viewer, around) < 0.02);
  REQUIRE(largest_step(Blend::viewer, across) < 0.02);
  // The cameras of the paper do not depend on the viewer, and drop out at once.
  REQUIRE(largest_step(Blend::paper, around) == 0);
  REQUIRE(largest_step(Blend::paper, across) > 0.2);
}

TEST_CASE("a camera loses its weight towards the border of its picture") {
  Shape shape;
  shape.square(4, 0);
  Sources sources;
  sources.plain(looking({0, 0, -4}, {}, 64, 64, 64), {1, 0, 0}); // 16 pixels a metre
  sources.plain(looking({0, 0, -4.5}, {}, 640, 640, 64), {0, 1, 0});
  double former = 0;
  for (const double x : {1.95, 1.8, 1.6, 1.4}) {
    const ViewPicture picture = render(shape, sources, looking({x, 0, -4}, {x, 0, 0}, 1, 1, 9));
    const double red = colour_of(picture, 0).x;
    REQUIRE(red > former);
    former = red;
  }
  REQUIRE(former > 0.4);
  REQUIRE(colour_of(render(shape, sources, looking({1.98, 0, -4}, {1.98, 0, 0}, 1, 1, 9)), 0).x == 0);
}

TEST_CASE("at equal weight the camera that was named first is taken") {
  Shape shape;
  shape.square(1, 0);
  Sources sources;
  // Mirrored at the plane x = 0 and at y = 0: the same products in the same sums.
  for (const auto &[x, y] : {std::pair{1.0, 1.0}, {-1.0, 1.0}, {1.0, -1.0}, {-1.0, -1.0}})
    sources.plain(looking({x, y, -2}, {}, 64, 64, 60), {x, y, 0});
  REQUIRE(used(render(shape, sources, spot({}))) == std::vector<uint32_t>{0, 1, 2});
  std::reverse(sources.views.begin(), sources.views.end());
  REQUIRE(used(render(shape, sources, spot({}))) == std::vector<uint32_t>{0, 1, 2});
}

TEST_CASE("normals of vertices are interpolated over the face") {
  Shape shape;
  shape.square(1, 0);
  Sources sources;
  sources.plain(looking({0, 0, -4}, {}, 64, 64, 20), {1, 0, 0});
  // Towards -z at the left, by 60 degrees towards +x at the right: halfway, 30 degrees.
  const Vec3 straight = {0, 0, -1}, leaning = {std::sqrt(3) / 2, 0, -0.5};
  const ViewRenderer renderer(shape.mesh(), {straight, leaning, leaning, straight}, sources.views, [] {
    ViewOptions options;
    options.threshold = std::sqrt(3) / 2 - 1e-6;
    return options;
  }());
  REQUIRE(used(renderer.render(spot({}))) == std::vector<uint32_t>{0});
  REQUIRE(used(renderer.render(spot({0.01, 0, 0}))).empty());
}

TEST_CASE("a face that turns its back is not shown, for any normals of its vertices") {
  Shape shape;
  shape.square(1, 0);
  Sources sources;
  sources.plain(looking({0, 0, 3}, {}, 64, 64, 60), {1, 0, 0});
  sources.plain(looking({0, 0, -3}, {}, 64, 64, 60), {1, 0, 0});
  ViewOptions options;
  options.visibility = GENERATE(Visibility::depth_map, Visibility::rays);
  options.threshold = 0;
  for (const double side : {1.0, -1.0}) {
    const ViewRenderer renderer(shape.mesh(), std::vector<Vec3>(4, {0, 0, side}), sources.views, options);
    const auto expected = side > 0 ? std::vector<uint32_t>{} : std::vector<uint32_t>{1};
    REQUIRE(used(renderer.render(spot({}))) == expected);
  }
}

TEST_CASE("a surface before a camera hides what is behind it") {
  Shape shape;
  shape.square(3, 0);
  shape.square(0.3, -1); // seen from (0, 0, -4) it hides |x|, |y| < 0.4 of the plane
  Sources sources;
  sources.film(looking({0, 0, -4}, {}, 480, 480, 300), gradient);
  const fvv_camera target = looking({2.5, 0, -3}, {0, 0, 0}, 240, 200, 150);
  const auto visibility = GENERATE(Visibility::depth_map, Visibility::rays);
  ViewOptions options;
  options.visibility = visibility;
  options.keep_visibility = true;
  const ViewPicture picture = render(shape, sources, target, options);
  size_t hidden = 0, shown = 0;
  for (size_t pixel = 0; pixel < picture.face.size(); pixel++) {
    if (picture.face[pixel] == no_face || picture.face[pixel] >= 2) continue; // the plane is faces 0 and 1
    const Vec3 p = on_plane(target, double(pixel % 240) + 0.5, double(pixel / 240) + 0.5, 0);
    const double reach = std::max(std::abs(p.x), std::abs(p.y));
    // The map is exact to its spacing: a pixel at 4 m has 13 mm.
    if (std::abs(reach - 0.4) < 0.015 || reach > 2.4) continue; // beyond, the gradient is clipped
    const bool expected = reach > 0.4;
    (expected ? shown : hidden)++;
    REQUIRE((picture.visible[pixel] != 0) == expected);
    REQUIRE((picture.contributions[pixel * 3].source != no_source) == expected);
    REQUIRE(farthest(colour_of(picture, pixel), expected ? gradient(p) : options.unseen) < 1.0 / 255);
  }
  REQUIRE(hidden > 200);
  REQUIRE(shown > 5000);
}

TEST_CASE("cameras behind, beside, and on the near plane of a surface") {
  Shape shape;
  shape.square(50, 0);
  const auto visibility = GENERATE(Visibility::depth_map, Visibility::rays);
  ViewOptions options;
  options.visibility = visibility;
  options.blend = Blend::paper;
  options.threshold = 0.25;
  options.best = 8;
  Sources sources;
  sources.plain(looking({0, 0, 3}, {}, 64, 64, 60), {});            // 0: sees the back
  sources.plain(looking({0, 0, -3}, {0, 0, -6}, 64, 64, 60), {});   // 1: looks away
  sources.plain(looking(at_angle(0.26, 0), {}, 64, 64, 60), {});    // 2: grazing, above the threshold
  sources.plain(looking(at_angle(0.24, 0), {}, 64, 64, 60), {});    // 3: grazing, below
  sources.plain(looking({1, 0, -1}, {0, 0, -0.4}, 64, 64, 30), {}); // 4: the plane continues behind it
  sources.plain(with_lens(sources.views[4].camera, -0.1, 0), {});   // 5: the same through a lens
  sources.plain(looking({0, 0, -near_plane(shape.mesh()) / 2}, {}, 64, 64, 60),
                {});                                                // 6: nearer than the near plane
  sources.plain(looking({20, 0, -20}, {20, 0, 0}, 64, 64, 60), {}); // 7: beside its picture
  const auto found = used(render(shape, sources, spot({}), options));
  const std::vector<uint32_t> expected =
      visibility == Visibility::rays ? std::vector<uint32_t>{6, 4, 5, 2} : std::vector<uint32_t>{4, 5, 2};
  REQUIRE(found == expected);
}

TEST_CASE("a lens too wide for a depth map is answered by rays") {
  Shape shape;
  shape.square(1, 0);
  shape.square(0.1, -1);
  Sources sources;
  fvv_camera fisheye = looking({0, 0, -2}, {0, 0, 0}, 200, 200, 60); // 95 degrees off the axis in the corners
  fisheye.lens = FVV_LENS_FISHEYE;
  fisheye.r_max = fvv_camera_r_max(&fisheye);
  sources.plain(fisheye, {1, 0, 0});
  REQUIRE(DepthMap(fisheye, shape.mesh(), {}).too_wide());
  REQUIRE(used(render(shape, sources, spot({0.5, 0, 0}))) == std::vector<uint32_t>{0});
  const fvv_camera beside = looking({2, 0, -2}, {}, 1, 1, 100);
  REQUIRE(used(render(shape, sources, beside)).empty()); // behind the small square
}

TEST_CASE("visibility may be given for vertices: it is interpolated, and one half is enough") {
  Shape shape;
  shape.square(1, 0); // vertices at (-1, -1), (1, -1), (1, 1), (-1, 1)
  Sources sources;
  sources.plain(looking({0, 0, -4}, {}, 64, 64, 60), {1, 0, 0});
  sources.plain(looking({0, 0, 4}, {}, 64, 64, 60), {1, 0, 0});
  ViewOptions options;
  options.visibility = Visibility::given;
  // Without any, depth maps are drawn.
  REQUIRE(used(render(shape, sources, spot({0.3, 0.2, 0}), options)) == std::vector<uint32_t>{0});
  const uint8_t left[4] = {255, 0, 0, 255};
  for (SourceView &view : sources.views) view.visible_vertices = left;
  // The one behind would see the same vertices, but not the front.
  for (const double x : {-0.9, -0.3, -0.01})
    REQUIRE(used(render(shape, sources, spot({x, 0.2, 0}), options)) == std::vector<uint32_t>{0});
  for (const double x : {0.01, 0.3, 0.9})
    REQUIRE(used(render(shape, sources, spot({x, 0.2, 0}), options)).empty());
}

TEST_CASE("samples of a pixel are averaged with the background") {
  Shape shape;
  shape.square(1, 0);
  Sources sources;
  sources.plain(looking({0, 0, -4}, {}, 64, 64, 28), {1, 1, 1});
  ViewOptions options;
  options.samples = 5;
  options.background = {0.25, 0, 0};
  // f = 4 at a distance of 4: pixels have a side of 1, the square covers four of them, and 0.6 of the next
  // column when the picture's centre moves by 0.6.
  fvv_camera target = looking({0, 0, -4}, {}, 8, 8, 4);
  target.cx += 0.6;
  const ViewPicture picture = render(shape, sources, target, options);
  const size_t row = 4 * 8;
  const std::vector<float> coverage(picture.coverage.begin() + row, picture.coverage.begin() + row + 8);
  const std::vector<float> expected = {0, 0, 0, 0.4f, 1, 0.6f, 0, 0};
  for (size_t i = 0; i < 8; i++) {
    REQUIRE(std::abs(coverage[i] - expected[i]) < 1e-6f);
    const Vec3 colour = Vec3{0.25, 0, 0} * double(1 - expected[i]) + Vec3{1, 1, 1} * double(expected[i]);
    REQUIRE(farthest(colour_of(picture, row + i), colour) < 1e-5);
  }
  REQUIRE(picture.depth[row] == float(infinity));
  REQUIRE(std::abs(picture.depth[row + 4] - 4) < 1e-6f);
}

TEST_CASE("the order in which rows are drawn does not matter") {
  Shape shape;
  shape.square(1, 0);
  shape.square(0.3, -1);
  Sources sources;
  sources.film(looking({0, 0, -4}, {}, 160, 120, 150), gradient);
  sources.film(looking({1, 1, -3}, {}, 160, 120, 150), gradient);
  const fvv_camera target = with_lens(looking({0.5, -1, -3}, {}, 80, 60, 70), -0.1, 0);
  ViewOptions options;
  const ViewPicture forth = render(shape, sources, target, options);
  options.executor = [](size_t count, const std::function<void(size_t)> &work) {
    while (count-- > 0) work(count);
  };
  const ViewPicture back = render(shape, sources, target, options);
  REQUIRE(forth.rgb == back.rgb);
  REQUIRE(forth.depth == back.depth);
  REQUIRE(forth.coverage == back.coverage);
}

TEST_CASE("options out of range are refused") {
  Shape shape;
  shape.square(1, 0);
  Sources sources;
  sources.plain(looking({0, 0, -4}, {}, 64, 64, 28), {1, 1, 1});
  for (const auto &spoil : std::vector<void (*)(ViewOptions &)>{
           [](ViewOptions &o) { o.threshold = 1.5; }, [](ViewOptions &o) { o.threshold = NAN; },
           [](ViewOptions &o) { o.best = 0; }, [](ViewOptions &o) { o.best = 9; },
           [](ViewOptions &o) { o.margin = -1; }, [](ViewOptions &o) { o.inset = -1; },
           [](ViewOptions &o) { o.inset = INFINITY; }, [](ViewOptions &o) { o.samples = 2; },
           [](ViewOptions &o) { o.depth_test.samples = 9; }}) {
    ViewOptions options;
    spoil(options);
    REQUIRE_THROWS_AS(render(shape, sources, spot({}), options), std::invalid_argument);
  }
  REQUIRE_THROWS_AS(ViewRenderer(shape.mesh(), std::vector<Vec3>(3), sources.views, {}),
                    std::invalid_argument);
}
