// Bits chosen for what players make of them: how often a player is wrong with them, against rays to places
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
using Bits = std::vector<uint8_t>;

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
    asked.assign(shape.faces.size() / 3, 1);
  }
  Shape shape;
  Mesh mesh;
  RayCaster rays;
  fvv_camera camera = looking({0.2, 0.1, -5}, {0, 0, 0}, 400, 400, 700);
  Bits asked;

  Bits fitted(const FitSettings &settings, const uint8_t *former = nullptr) const {
    return VisibilityFit(mesh, rays, FVV_VISIBILITY_FACES, settings).seen(camera, asked, former);
  }
  Bits weights(const FitSettings &settings, const uint8_t *former = nullptr) const {
    return VisibilityFit(mesh, rays, FVV_VISIBILITY_WEIGHTS, settings)
        .seen(camera, Bits(mesh.vertex_count, 1), former);
  }
  Bits plain() const { return seen_faces(camera, mesh, rays, asked); }

  // Per cent of the places, many to a face, where weights do not say what the ray does.
  double error(const Bits &seen, uint8_t domain = FVV_VISIBILITY_FACES) const {
    Bits states(seen.size());
    for (size_t i = 0; i < seen.size(); i++) states[i] = seen[i] ? FVV_ELEMENT_SEEN : FVV_ELEMENT_HIDDEN;
    if (domain == FVV_VISIBILITY_WEIGHTS) states = seen;
    fvv_mesh decoded = {};
    std::vector<uint32_t> faces = shape.faces;
    decoded.faces = faces.data();
    decoded.face_count = uint32_t(mesh.face_count);
    decoded.vertex_count = uint32_t(mesh.vertex_count);
    std::vector<uint32_t> counts(2 * mesh.vertex_count);
    Bits weights(mesh.vertex_count);
    fvv_visibility_weights(&decoded, domain, states.data(), counts.data(), weights.data());
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

  // Edges of the floor between faces of different bits.
  size_t outline(const Bits &seen) const {
    size_t count = 0;
    for (size_t cell = 0; cell < size_t(cells) * cells; cell++) {
      count += seen[2 * cell] != seen[2 * cell + 1];
      if (cell % cells) count += seen[2 * cell + 1] != seen[2 * (cell - 1)];
      if (cell >= cells) count += seen[2 * cell] != seen[2 * (cell - cells) + 1];
    }
    return count;
  }
};

size_t differing(const Bits &a, const Bits &b) {
  return size_t(std::inner_product(a.begin(), a.end(), b.begin(), 0, std::plus<>(), std::not_equal_to<>()));
}

} // namespace

TEST_CASE("fit: players err less by fitted bits than by what most of each face is") {
  std::printf("angle  plain %%  fitted %%  vertices, plain %%  fitted %%\n");
  double plain_sum = 0, fitted_sum = 0;
  for (const double angle : {0.1, 0.3, 0.5, 0.7}) {
    const Scene scene(shaded_floor(angle));
    const double plain = scene.error(scene.plain()), fitted = scene.error(scene.fitted({}));
    Bits vertices(scene.mesh.vertex_count, 1);
    const double by_vertex = scene.error(seen_vertices(scene.camera, scene.mesh, scene.rays, vertices),
                                         FVV_VISIBILITY_VERTICES),
                 vertex_fit = scene.error(VisibilityFit(scene.mesh, scene.rays, FVV_VISIBILITY_VERTICES, {})
                                              .seen(scene.camera, vertices, nullptr),
                                          FVV_VISIBILITY_VERTICES);
    std::printf("%5.1f %8.3f %9.3f %18.3f %9.3f\n", angle, plain, fitted, by_vertex, vertex_fit);
    CHECK(plain > 0.3);
    CHECK(fitted < plain);
    CHECK(vertex_fit <= by_vertex);
    plain_sum += plain;
    fitted_sum += fitted;
  }
  CHECK(fitted_sum < 0.85 * plain_sum);
}

TEST_CASE("fit: players err less by weights than by bits, the more so the less a bit costs") {
  std::printf("angle  faces %%  weights %%  free of price %%\n");
  double faces_sum = 0, weights_sum = 0, free_sum = 0;
  FitSettings free;
  free.bit = 0;
  for (const double angle : {0.1, 0.3, 0.5, 0.7}) {
    const Scene scene(shaded_floor(angle));
    const Bits weights = scene.weights({});
    const double faces = scene.error(scene.fitted({})),
                 by_weights = scene.error(weights, FVV_VISIBILITY_WEIGHTS),
                 at_any_price = scene.error(scene.weights(free), FVV_VISIBILITY_WEIGHTS);
    std::printf("%5.1f %8.3f %9.3f %16.3f\n", angle, faces, by_weights, at_any_price);
    // Levels near a half are for outlines alone.
    const auto near =
        std::count_if(weights.begin(), weights.end(), [](uint8_t s) { return s > FVV_ELEMENT_SEEN; });
    CHECK(near > 0);
    CHECK(near < 200);
    CHECK(std::count(weights.begin(), weights.end(), FVV_ELEMENT_BACKFACING) == 0);
    faces_sum += faces;
    weights_sum += by_weights;
    free_sum += at_any_price;
  }
  CHECK(weights_sum < 0.95 * faces_sum);
  CHECK(free_sum < weights_sum);
}

TEST_CASE("fit: a price of changes keeps weights of the time before") {
  const Scene before(shaded_floor(0.3)), after(shaded_floor(0.3, 0.004));
  const Bits former = before.weights({});
  FitSettings settings;
  const Bits free = after.weights(settings, former.data());
  settings.change = 0.4;
  const Bits held = after.weights(settings, former.data());
  INFO(differing(former, free) << " weights changed, held " << differing(former, held));
  CHECK(differing(former, free) > 20);
  CHECK(3 * differing(former, held) < 2 * differing(former, free));
}

TEST_CASE("fit: a higher price of edges makes outlines shorter") {
  const Scene scene(shaded_floor(0.3));
  FitSettings settings;
  size_t before = SIZE_MAX;
  for (const double edge : {0.0, 0.05, 0.5}) {
    settings.edge = edge;
    const size_t length = scene.outline(scene.fitted(settings));
    INFO("price " << edge);
    CHECK(length < before);
    before = length;
  }
}

TEST_CASE("fit: a price of changes keeps bits of the time before") {
  const Scene before(shaded_floor(0.3)), after(shaded_floor(0.3, 0.004));
  const Bits bits = before.fitted({});
  Bits former(bits.size());
  for (size_t i = 0; i < bits.size(); i++) former[i] = bits[i] ? FVV_ELEMENT_SEEN : FVV_ELEMENT_HIDDEN;
  FitSettings settings;
  const Bits free = after.fitted(settings, former.data());
  CHECK(free == after.fitted(settings));
  settings.change = 0.1;
  const Bits held = after.fitted(settings, former.data());
  CHECK(after.fitted(settings) == free);
  INFO(differing(bits, free) << " bits turned, held " << differing(bits, held));
  CHECK(differing(bits, free) > 20);
  CHECK(2 * differing(bits, held) < differing(bits, free));
  CHECK(after.error(held) < after.error(after.plain()));
  // No price keeps what has none.
  std::fill(former.begin(), former.end(), uint8_t(FVV_ELEMENT_BACKFACING));
  CHECK(after.fitted(settings, former.data()) == free);
}

TEST_CASE("fit: elements that are not selected have no bit, nor does anything outside the picture") {
  Scene scene(shaded_floor(0.3));
  const Bits whole = scene.fitted({});
  for (size_t f = 0; f < scene.asked.size(); f += 2) scene.asked[f] = 0;
  const Bits half = scene.fitted({});
  for (size_t f = 0; f < half.size(); f += 2) REQUIRE(half[f] == 0);
  CHECK(std::count(half.begin(), half.end(), 1) > 1000);
  scene.asked.assign(scene.asked.size(), 1);
  scene.camera.cx += 10000;
  const Bits none = scene.fitted({});
  CHECK(std::count(none.begin(), none.end(), 1) == 0);
  CHECK(std::count(whole.begin(), whole.end(), 1) > 2000);
}
