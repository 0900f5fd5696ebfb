// Weights chosen for what players make of them: how often a player is wrong with them, against rays to places
// that the search does not use, and what prices do.
#include "fvv_render/normals.h"
#include "fvv_render/occlusion.h"
#include "fvv_render/visibility_fit.h"
#include "view_fixture.h"

#include "fvv_catch.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace {

using namespace view_fixture;
using States = std::vector<uint8_t>;

constexpr uint32_t cells = 40;

// A floor of 2 m x 2 m, 40 cells a side, at z = 0, and above it a square that is turned by angle, off by
// shift.
Shape shaded_floor(double angle, double shift = 0) {
  Shape shape;
  for (uint32_t row = 0; row <= cells; row++)
    for (uint32_t column = 0; column <= cells; column++)
      for (const double value : {2.0 * column / cells - 1, 2.0 * row / cells - 1, 0.0})
        shape.positions.push_back(float(value));
  for (uint32_t row = 0; row < cells; row++)
    for (uint32_t column = 0; column < cells; column++) {
      const uint32_t a = row * (cells + 1) + column, b = a + 1, c = a + cells + 1, d = c + 1;
      for (const uint32_t i : {a, d, b, a, c, d}) shape.faces.push_back(i);
    }
  const auto first = uint32_t(shape.positions.size() / 3);
  for (const auto &[x, y] : {std::pair{-0.4, -0.4}, {0.4, -0.4}, {0.4, 0.4}, {-0.4, 0.4}})
    for (const double value :
         {x * std::cos(angle) - y * std::sin(angle) + shift, x * std::sin(angle) + y * std::cos(angle), -1.0})
      shape.positions.push_back(float(value));
  for (const uint32_t i : {0u, 2u, 1u, 0u, 3u, 2u}) shape.faces.push_back(first + i);
  return shape;
}

struct Scene {
  explicit Scene(Shape drawn) : shape(std::move(drawn)), mesh(shape.mesh()), rays(mesh) {
    asked.assign(mesh.vertex_count, 1);
  }
  Shape shape;
  Mesh mesh;
  RayCaster rays;
  fvv_camera camera = looking({0.2, 0.1, -5}, {0, 0, 0}, 400, 400, 700);
  States asked;

  States fitted(const FitSettings &settings, const uint8_t *former = nullptr) const {
    return VisibilityFit(mesh, rays, settings).states(camera, asked, former);
  }
  // Seen or hidden, as the ray to each vertex.
  States plain() const {
    States out;
    for (const uint8_t seen : visible_vertices(camera, mesh, rays))
      out.push_back(seen ? FVV_VERTEX_SEEN : FVV_VERTEX_HIDDEN);
    return out;
  }

  // Per cent of the places, many to a face, where weights do not say what the ray does.
  double error(const States &states) const {
    States weights(states.size());
    fvv_visibility_weights(states.data(), states.size(), weights.data());
    double wrong = 0, all = 0;
    for (uint32_t f = 0; f < mesh.face_count; f++)
      for (int i = 0; i < 20; i++) {
        double u = std::fmod(0.31 + 0.7548776662466927 * (20 * f + uint32_t(i)), 1.0),
               v = std::fmod(0.17 + 0.5698402909980532 * (20 * f + uint32_t(i)), 1.0);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const double weight[3] = {1 - u - v, u, v};
        Vec3 place = {0, 0, 0};
        double visible = 0;
        for (size_t k = 0; k < 3; k++) {
          const uint32_t vertex = shape.faces[3 * size_t(f) + k];
          const float *p = &shape.positions[3 * size_t(vertex)];
          place = place + Vec3{p[0], p[1], p[2]} * weight[k];
          visible += weights[vertex] * weight[k];
        }
        wrong += (visible >= 127.5) == hidden_by_rays({0.2, 0.1, -5}, place, f, rays);
        all++;
      }
    return 100 * wrong / all;
  }
};

size_t differing(const States &a, const States &b) {
  return size_t(std::inner_product(a.begin(), a.end(), b.begin(), 0, std::plus<>(), std::not_equal_to<>()));
}

} // namespace

TEST_CASE(
    "fit: players err less by fitted weights than by rays to vertices, the more so the less a bit costs") {
  std::printf("angle  plain %%  weights %%  free of price %%\n");
  double plain_sum = 0, weights_sum = 0, free_sum = 0;
  FitSettings free;
  free.bit = 0;
  for (const double angle : {0.1, 0.3, 0.5, 0.7}) {
    const Scene scene(shaded_floor(angle));
    const States states = scene.fitted({});
    const double plain = scene.error(scene.plain()), weights = scene.error(states),
                 at_any_price = scene.error(scene.fitted(free));
    std::printf("%5.1f %8.3f %9.3f %16.3f\n", angle, plain, weights, at_any_price);
    // Levels near a half are for outlines alone.
    const auto near =
        std::count_if(states.begin(), states.end(), [](uint8_t s) { return s > FVV_VERTEX_SEEN; });
    CHECK(near > 0);
    CHECK(near < 200);
    CHECK(std::count(states.begin(), states.end(), FVV_VERTEX_BACKFACING) == 0);
    CHECK(plain > 0.3);
    CHECK(weights < plain);
    plain_sum += plain;
    weights_sum += weights;
    free_sum += at_any_price;
  }
  CHECK(weights_sum < 0.6 * plain_sum);
  CHECK(free_sum < weights_sum);
}

TEST_CASE("fit: a higher price of bits brings fewer states near a half") {
  const Scene scene(shaded_floor(0.3));
  FitSettings settings;
  ptrdiff_t before = PTRDIFF_MAX;
  for (const double bit : {0.0, 0.03, 0.3}) {
    settings.bit = bit;
    const States states = scene.fitted(settings);
    const auto near =
        std::count_if(states.begin(), states.end(), [](uint8_t s) { return s > FVV_VERTEX_SEEN; });
    INFO("price " << bit);
    CHECK(near < before);
    before = near;
  }
}

TEST_CASE("fit: a price of changes keeps weights of the time before") {
  const Scene before(shaded_floor(0.3)), after(shaded_floor(0.3, 0.004));
  const States former = before.fitted({});
  FitSettings settings;
  const States free = after.fitted(settings, former.data());
  CHECK(free == after.fitted(settings));
  settings.change = 0.4;
  const States held = after.fitted(settings, former.data());
  INFO(differing(former, free) << " weights changed, held " << differing(former, held));
  CHECK(differing(former, free) > 20);
  CHECK(3 * differing(former, held) < 2 * differing(former, free));
  // No price keeps what has none.
  const States none(former.size(), FVV_VERTEX_BACKFACING);
  CHECK(after.fitted(settings, none.data()) == free);
}

TEST_CASE("fit: vertices that are not selected have no weight, nor is anything outside the picture seen") {
  Scene scene(shaded_floor(0.3));
  const States whole = scene.fitted({});
  const auto seen = [](const States &states) {
    return std::count_if(states.begin(), states.end(), [](uint8_t s) { return FVV_VERTEX_IS_SEEN(s); });
  };
  for (size_t v = 0; v < scene.asked.size(); v += 2) scene.asked[v] = 0;
  const States half = scene.fitted({});
  for (size_t v = 0; v < half.size(); v++) REQUIRE((half[v] == FVV_VERTEX_BACKFACING) == (v % 2 == 0));
  CHECK(seen(half) > 400);
  scene.asked.assign(scene.asked.size(), 1);
  scene.camera.cx += 10000;
  CHECK(seen(scene.fitted({})) == 0);
  CHECK(seen(whole) > 1000);
}
