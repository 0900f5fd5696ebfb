// The unit of a capture is arbitrary: a scene has the same picture and visibility at every scale.
#include "fvv_catch.h"

#include "fvv_render/colour_match.h"
#include "fvv_render/environment.h"
#include "fvv_render/normals.h"
#include "fvv_render/ray_visibility.h"
#include "fvv_render/scene_lengths.h"
#include "fvv_render/texture_inset.h"
#include "view_fixture.h"

#include <algorithm>

using namespace view_fixture;

namespace {

// Balls of 32 x 16 vertices, of which the second one hides parts of the first, 2 m across together.
Shape balls() {
  constexpr int around = 32, rows = 16;
  Shape shape;
  for (const auto &[centre, radius] : {std::pair{Vec3{-0.2, 0, 0.1}, 0.8}, {Vec3{0.85, 0.1, -0.5}, 0.35}}) {
    const auto first = uint32_t(shape.positions.size() / 3);
    for (int row = 0; row < rows; row++)
      for (int i = 0; i < around; i++) {
        const double polar = M_PI * (row + 0.5) / rows, turn = 2 * M_PI * i / around;
        for (const double value :
             {centre.x + radius * std::sin(polar) * std::cos(turn), centre.y - radius * std::cos(polar),
              centre.z + radius * std::sin(polar) * std::sin(turn)})
          shape.positions.push_back(float(value));
      }
    const auto at = [&](int row, int i) { return first + uint32_t(row * around + i % around); };
    for (int row = 0; row + 1 < rows; row++)
      for (int i = 0; i < around; i++)
        for (const uint32_t v :
             {at(row, i), at(row + 1, i), at(row + 1, i + 1), at(row, i), at(row + 1, i + 1), at(row, i + 1)})
          shape.faces.push_back(v);
  }
  if (inside_out(shape.mesh()))
    for (size_t f = 0; f < shape.faces.size(); f += 3) std::swap(shape.faces[f], shape.faces[f + 1]);
  return shape;
}

Shape times(Shape shape, double scale) {
  for (float &value : shape.positions) value = float(value * scale);
  return shape;
}

fvv_camera times(fvv_camera camera, double scale) {
  for (double &value : camera.translation) value *= scale;
  return camera;
}

// The same pictures from cameras of another scale.
Sources films(double scale) {
  Sources out;
  for (const Vec3 eye : {Vec3{0, 0, -3}, {2.5, 0.5, -2}, {-2, -1, -2.4}})
    out.film(looking(eye, {}, 96, 64, 70), [](Vec3 at) { return gradient(at); });
  for (SourceView &view : out.views) view.camera = times(view.camera, scale);
  return out;
}

Environment room(double scale) {
  EnvironmentPart wall;
  for (const double value : {-4.0, -4.0, 2.0, 4.0, -4.0, 2.0, 4.0, 4.0, 2.0, -4.0, 4.0, 2.0})
    wall.positions.push_back(float(value * scale));
  wall.faces = {0, 2, 1, 0, 3, 2};
  wall.double_sided = true;
  wall.colour = {0.2, 0.5, 0.3};
  return Environment({wall});
}

} // namespace

TEST_CASE("lengths that are not measured follow the scene") {
  const Shape shape = balls();
  REQUIRE(longest_side(shape.mesh()) > 2);
  CHECK(near_plane(shape.mesh()) == 0.01);
  CHECK(vertex_lift(shape.mesh()) == 1e-4);
  for (const double scale : {1e-3, 1e-6}) {
    const Shape small = times(shape, scale);
    const double side = longest_side(small.mesh());
    CHECK(side == Approx(scale * longest_side(shape.mesh())).epsilon(1e-6));
    CHECK(near_plane(small.mesh()) == Approx(side / 100));
    CHECK(vertex_lift(small.mesh()) == Approx(side / 10000));
  }
  const Shape in_millimetres = times(shape, 1000);
  CHECK(near_plane(in_millimetres.mesh()) == 0.01);
  // More than coordinates are rounded by, or a vertex would hide itself.
  CHECK(vertex_lift(in_millimetres.mesh()) > 2 * std::ldexp(longest_side(in_millimetres.mesh()), -24));
  CHECK(near_plane(Mesh{}) == 0.01);
  CHECK(vertex_lift(Mesh{}) == 1e-4);
  Shape odd = times(shape, 1e-3);
  odd.positions.push_back(INFINITY);
  odd.positions.push_back(NAN);
  odd.positions.push_back(0);
  CHECK(near_plane(odd.mesh()) == near_plane(times(shape, 1e-3).mesh()));
}

TEST_CASE("a scene of another scale has the same picture, depth and visibility") {
  // Powers of two, so that nothing is rounded otherwise.
  const double scale = GENERATE(std::ldexp(1, -10), std::ldexp(1, -20), std::ldexp(1, 10));
  const Shape shape = balls(), other = times(shape, scale);
  const Sources sources = films(1), scaled = films(scale);
  const Environment around = room(1), around_other = room(scale);
  ViewOptions options, options_other;
  options.visibility = options_other.visibility = GENERATE(Visibility::depth_map, Visibility::rays);
  options.environment = &around;
  options_other.environment = &around_other;
  const fvv_camera plain = looking({0.5, 0.3, -2.6}, {}, 64, 48, 50);
  for (const fvv_camera &target : {plain, with_lens(plain, -0.1, 0)}) {
    const ViewPicture a = render(shape, sources, target, options);
    const ViewPicture b = render(other, scaled, times(target, scale), options_other);
    CHECK(std::count(a.face.begin(), a.face.end(), no_face) < 64 * 48 * 3 / 4);
    CHECK(a.face == b.face);
    CHECK(a.rgb == b.rgb);
    bool same_depth = true;
    for (size_t i = 0; i < a.depth.size(); i++)
      same_depth = same_depth && b.depth[i] == float(a.depth[i] * scale);
    CHECK(same_depth);
  }
  const RayCaster rays(shape.mesh()), rays_other(other.mesh());
  for (size_t i = 0; i < sources.views.size(); i++) {
    const fvv_camera &camera = sources.views[i].camera, &camera_other = scaled.views[i].camera;
    CHECK(visible_faces(camera, shape.mesh(), rays) == visible_faces(camera_other, other.mesh(), rays_other));
    CHECK(visible_vertices(camera, shape.mesh(), rays) ==
          visible_vertices(camera_other, other.mesh(), rays_other));
  }
}

TEST_CASE("the inset that is found of a scene of another scale is that times the scale") {
  const double scale = std::ldexp(1, -10);
  const Shape shape = balls(), other = times(shape, scale);
  const auto found = [](const Shape &of, const Sources &sources) {
    HeldOutFrame frame = {of.mesh(), {}};
    for (const SourceView &view : sources.views) frame.views.push_back({view, nullptr});
    ViewOptions options;
    options.visibility = Visibility::rays;
    return find_texture_inset({frame}, options);
  };
  const TextureInset a = found(shape, films(1)), b = found(other, films(scale));
  CHECK(a.pixels > 0);
  CHECK(a.pixels == b.pixels);
  CHECK(a.before == b.before);
  CHECK(a.after == b.after);
  CHECK(a.inset * scale == b.inset);
}
