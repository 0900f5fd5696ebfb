// Rays against all triangles one by one, and visibility against the rasteriser.
#include "fvv_catch.h"

#include "fvv_render/ray_visibility.h"
#include "fvvsynth/scene.h"

#include <algorithm>
#include <limits>

using namespace fvv::render;
using fvv::synth::Moment;
using fvv::synth::Random;
using fvv::synth::Scene;
using fvv::synth::Settings;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Triangles {
  std::vector<float> positions;
  std::vector<uint32_t> faces;
  Mesh mesh() const { return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3}; }
  Vec3 corner(size_t face, size_t i) const {
    const float *p = &positions[3 * faces[3 * face + i]];
    return {p[0], p[1], p[2]};
  }
};

// Triangles of all sizes, some slender, that cut each other.
Triangles soup(uint64_t seed, size_t count) {
  Random random(seed);
  Triangles out;
  for (size_t i = 0; i < count; i++) {
    const double size = i % 10 ? 0.1 : 1;
    const Vec3 centre{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    for (int c = 0; c < 3; c++) {
      for (const double value : {centre.x, centre.y, centre.z})
        out.positions.push_back(float(value + size * random.between(-1, 1)));
      out.faces.push_back(uint32_t(out.faces.size()));
    }
  }
  return out;
}

// Where a ray meets a triangle (Moeller and Trumbore, 1997), in long doubles: another method than the one
// that is tested. doubt: so near to an edge or the end of the ray that the two may differ.
struct Meeting {
  bool hit = false, doubt = false;
  long double distance = 0;
};
Meeting meet(Vec3 origin, Vec3 direction, Vec3 a, Vec3 b, Vec3 c, double least, double most) {
  struct Long {
    long double x, y, z;
  };
  const auto minus = [](Vec3 p, Vec3 q) {
    return Long{(long double)p.x - q.x, (long double)p.y - q.y, (long double)p.z - q.z};
  };
  const auto inner = [](Long p, Long q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
  const auto outer = [](Long p, Long q) {
    return Long{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  };
  const Long along = minus(direction, {}), e1 = minus(b, a), e2 = minus(c, a), from = minus(origin, a);
  const Long p = outer(along, e2), q = outer(from, e1);
  const long double determinant = inner(e1, p);
  Meeting out;
  if (determinant == 0) return out;
  const long double u = inner(from, p) / determinant, v = inner(along, q) / determinant;
  out.distance = inner(e2, q) / determinant;
  const long double room =
      std::min({u, v, 1 - u - v, (out.distance - least) * 10, (most - out.distance) * 10});
  out.hit = room > 0;
  out.doubt = std::abs(room) < 1e-9L;
  return out;
}

Settings seven_cameras() {
  Settings settings;
  settings.threads = 2;
  return settings;
}

} // namespace

TEST_CASE("the nearest face along a ray is the one that trying all faces finds") {
  for (const size_t count : {1u, 3u, 5u, 64u, 700u}) {
    const Triangles triangles = soup(count, count);
    const RayCaster rays(triangles.mesh());
    Random random(11);
    size_t hits = 0, doubtful = 0;
    for (int i = 0; i < 3000; i++) {
      Vec3 origin{random.between(-2, 2), random.between(-2, 2), random.between(-2, 2)};
      Vec3 direction{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
      if (i % 5 == 0) direction.x = 0; // along the sides of boxes
      if (i % 15 == 0) direction.y = -0.0;
      const double least = i % 3 ? 0 : 0.5, most = i % 4 ? infinity : 2;
      const uint32_t except = i % 7 ? no_face : uint32_t(size_t(i) % count);
      uint32_t nearest = no_face;
      long double distance = infinity;
      bool doubt = false;
      for (uint32_t f = 0; f < count; f++) {
        const Meeting m = meet(origin, direction, triangles.corner(f, 0), triangles.corner(f, 1),
                               triangles.corner(f, 2), least, most);
        doubt = doubt || m.doubt;
        if (f == except || !m.hit || m.distance >= distance) continue;
        nearest = f;
        distance = m.distance;
      }
      doubtful += doubt;
      if (doubt) continue;
      const RayHit hit = rays.nearest(origin, direction, least, most, except);
      REQUIRE(hit.face == nearest);
      if (nearest == no_face) continue;
      hits++;
      CHECK(hit.distance == Approx(double(distance)).epsilon(1e-9));
      Vec3 met;
      for (size_t c = 0; c < 3; c++) met += triangles.corner(nearest, c) * hit.barycentric[c];
      CHECK(length(met - (origin + direction * hit.distance)) <
            1e-9 * (1 + length(direction) * hit.distance));
      const Vec3 end = origin + direction * (hit.distance * 1.5);
      CHECK((least > 0 || except != no_face || rays.blocked(origin, end)));
    }
    CHECK(hits > count);
    CHECK(doubtful < 30);
  }
}

TEST_CASE("rays slip through no edge and no vertex of a closed mesh", "[long]") {
  const Scene scene(seven_cameras());
  const Moment moment = scene.at(0.3);
  // The ball: the last of three closed surfaces, which begins at the vertex where its faces do.
  const size_t first_vertex = scene.vertex_count() - 1002;
  Triangles ball;
  ball.positions.assign(moment.positions.begin() + std::ptrdiff_t(3 * first_vertex), moment.positions.end());
  for (const uint32_t v : scene.faces())
    if (v >= first_vertex) ball.faces.push_back(v - uint32_t(first_vertex));
  const RayCaster rays(ball.mesh());
  Vec3 inside;
  for (size_t i = 0; i < 1002; i++)
    inside +=
        Vec3{ball.positions[3 * i], ball.positions[3 * i + 1], ball.positions[3 * i + 2]} * (1.0 / 1002);
  size_t lost = 0;
  for (size_t f = 0; f < ball.faces.size() / 3; f++)
    for (size_t c = 0; c < 3; c++) {
      const Vec3 a = ball.corner(f, c), b = ball.corner(f, (c + 1) % 3);
      for (const double t : {0.0, 0.3, 0.5, 0.77}) {
        const Vec3 target = mix(a, b, t);
        lost += rays.nearest(inside, target - inside, 0, 1.5).face == no_face;
        lost += !rays.blocked(inside, inside + (target - inside) * 2);
      }
    }
  CHECK(lost == 0);
}

TEST_CASE("degenerate meshes and rays meet nothing, and of coincident faces the first is met") {
  const RayCaster none(Mesh{});
  CHECK(none.nearest({0, 0, 0}, {0, 0, 1}, 0, infinity).face == no_face);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Triangles odd;
  odd.positions = {0, 0, 1, 1, 0, 1, 0, 1, 1, nan, 0, 1};
  odd.faces = {0, 1, 3, 0, 0, 1, 0, 1, 2, 0, 2, 1, 0, 1, 2, 2, 1, 0, 0, 1, 2};
  const RayCaster rays(odd.mesh());
  const RayHit hit = rays.nearest({0.25, 0.25, 0}, {0, 0, 2}, 0, infinity);
  CHECK(hit.face == 2);
  CHECK(hit.distance == 0.5);
  CHECK(rays.nearest({0.25, 0.25, 0}, {0, 0, 2}, 0, infinity, 2).face == 3);
  CHECK(rays.nearest({0.25, 0.25, 0}, {0, 0, 2}, 0, 0.5).face == no_face); // the end is left out
  CHECK(rays.nearest({0.25, 0.25, 0}, {0, 0, 2}, 0.5, 9).face == no_face);
  CHECK_FALSE(rays.blocked({0.25, 0.25, 0}, {0.25, 0.25, 1}));
  CHECK(rays.blocked({0.25, 0.25, 0}, {0.25, 0.25, 1.001}));
  CHECK(rays.nearest({0.25, 0.25, 0}, {0, 0, 0}, 0, infinity).face == no_face);
  CHECK(rays.nearest({0.25, 0.25, 0}, {0, nan, 1}, 0, infinity).face == no_face);
  // Equal boxes that no plane separates.
  Triangles same;
  same.positions = {0, 0, 1, 1, 0, 1, 0, 1, 1};
  for (int i = 0; i < 5000; i++) same.faces.insert(same.faces.end(), {0, 1, 2});
  CHECK(RayCaster(same.mesh()).nearest({0.25, 0.25, 0}, {0, 0, 1}, 0, 9).face == 0);
}

TEST_CASE("rays from one place are blocked as rays from anywhere are") {
  Random random(7);
  const auto place = [&](double extent) {
    return Vec3{random.between(-extent, extent), random.between(-extent, extent),
                random.between(-extent, extent)};
  };
  size_t blocked = 0, free = 0;
  for (const size_t count : {1u, 64u, 3000u})
    for (const bool has_walls : {false, true}) {
      Triangles triangles = soup(count, count);
      if (has_walls) // as large as all others together
        for (int i = 0; i < 12; i++) {
          for (int c = 0; c < 3; c++) {
            const Vec3 corner = place(2);
            for (const double value : {corner.x, corner.y, corner.z})
              triangles.positions.push_back(float(value));
            triangles.faces.push_back(uint32_t(triangles.faces.size()));
          }
        }
      const size_t faces = triangles.faces.size() / 3;
      const RayCaster rays(triangles.mesh());
      // Beside the mesh, above it, and within it.
      for (const Vec3 from : {Vec3{5, 0.5, -4}, Vec3{0, 9, 0}, Vec3{0.1, 0.2, 0.3}}) {
        const RayFan fan(from, triangles.mesh(), rays);
        for (size_t i = 0; i < 3000; i++) {
          const uint32_t except = i % 3 ? no_face : uint32_t(i % faces);
          // To anywhere, also away from the mesh; to a corner, and to the middle of a face.
          Vec3 to = place(i % 2 ? 1.5 : 12);
          if (i % 4 == 0) to = triangles.corner(i % faces, i % 3);
          if (i % 4 == 2)
            to = mix(triangles.corner(i % faces, 0),
                     mix(triangles.corner(i % faces, 1), triangles.corner(i % faces, 2), 0.5), 2.0 / 3);
          const bool expected = rays.blocked(from, to, except);
          REQUIRE(fan.blocked(to, except) == expected);
          ++(expected ? blocked : free);
        }
      }
    }
  CHECK(blocked > 10000);
  CHECK(free > 10000);
}

TEST_CASE("visibility of faces and vertices is what trying all faces finds", "[nightly]") {
  Settings settings = seven_cameras();
  settings.cameras = 2;
  const Scene scene(settings);
  const Moment moment = scene.at(1.1);
  Triangles whole{moment.positions, scene.faces()};
  // The ball and every 40th face of the players, so that all against all stays quick.
  Triangles part{moment.positions, {}};
  for (size_t f = 0; f < whole.faces.size() / 3; f++)
    if (f % 40 == 0 || f + 2000 >= whole.faces.size() / 3)
      part.faces.insert(part.faces.end(), &whole.faces[3 * f], &whole.faces[3 * f] + 3);
  const size_t count = part.faces.size() / 3;
  const RayCaster rays(part.mesh());
  for (const fvv_camera &camera : scene.cameras()) {
    double c[3];
    fvv_camera_centre(&camera, c);
    const Vec3 centre{c[0], c[1], c[2]};
    const auto seen_at = [&](Vec3 point, Vec3 normal, size_t except, bool &doubt) {
      const double world[3] = {point.x, point.y, point.z};
      double pixel[2];
      if (!fvv_camera_project(&camera, world, pixel, nullptr) || pixel[0] < 0 || pixel[0] >= camera.width ||
          pixel[1] < 0 || pixel[1] >= camera.height || dot(normal, centre - point) <= 0)
        return false;
      bool free = true;
      for (size_t f = 0; f < count; f++) {
        if (f == except) continue;
        const Meeting m =
            meet(centre, point - centre, part.corner(f, 0), part.corner(f, 1), part.corner(f, 2), 0, 1);
        doubt = doubt || m.doubt;
        free = free && !m.hit;
      }
      return free;
    };
    const std::vector<uint8_t> faces = visible_faces(camera, part.mesh(), rays),
                               vertices = visible_vertices(camera, part.mesh(), rays);
    REQUIRE(faces.size() == count);
    REQUIRE(vertices.size() == scene.vertex_count());
    std::vector<Vec3> normals(vertices.size());
    size_t wrong = 0, seen = 0, doubtful = 0, faces_seen = 0;
    for (size_t f = 0; f < count; f++) {
      const Vec3 p = part.corner(f, 0), q = part.corner(f, 1), r = part.corner(f, 2);
      const Vec3 normal = cross(q - p, r - p);
      for (size_t i = 0; i < 3; i++) normals[part.faces[3 * f + i]] += normal;
      bool doubt = false;
      const bool expected = seen_at((p + q + r) * (1.0 / 3), normal, f, doubt);
      doubtful += doubt;
      wrong += !doubt && expected != bool(faces[f]);
      faces_seen += expected;
    }
    for (size_t i = 0; i < vertices.size(); i++) {
      const Vec3 p{part.positions[3 * i], part.positions[3 * i + 1], part.positions[3 * i + 2]};
      bool doubt = false;
      const bool expected = length(normals[i]) > 0 &&
                            seen_at(p + normals[i] * (1e-4 / length(normals[i])), normals[i], count, doubt);
      doubtful += doubt;
      wrong += !doubt && expected != bool(vertices[i]);
      seen += expected;
    }
    CHECK(wrong == 0);
    CHECK(doubtful < 5);
    CHECK(faces_seen > count / 5);
    CHECK(faces_seen < count * 3 / 5);
    CHECK(seen > 500);
  }
}

TEST_CASE("visibility by rays agrees with the rasteriser at the centroids", "[long]") {
  for (const auto rig : {fvv::synth::RigKind::small, fvv::synth::RigKind::studio}) {
    Settings settings = seven_cameras();
    settings.rig = rig;
    settings.cameras = 2;
    settings.width = 960;
    settings.height = 540;
    const Scene scene(settings);
    const Moment moment = scene.at(0.6);
    const Mesh mesh = {moment.positions.data(), scene.vertex_count(), scene.faces().data(),
                       scene.faces().size() / 3};
    const RayCaster rays(mesh);
    size_t tested = 0, seen_count = 0, unlike = 0, broad = 0, broad_unlike = 0;
    for (size_t number = 0; number < 2; number++) {
      const fvv_camera &camera = scene.cameras()[number];
      const std::vector<uint8_t> seen = visible_faces(camera, mesh, rays);
      SampleBuffer buffer(camera.width, camera.height, 7);
      rasterise(Projection(camera), mesh, buffer);
      double c[3];
      fvv_camera_centre(&camera, c);
      for (size_t f = 0; f < mesh.face_count; f++) {
        Vec3 corner[3];
        for (size_t i = 0; i < 3; i++) {
          const float *p = mesh.positions + size_t(3) * mesh.faces[3 * f + i];
          corner[i] = {p[0], p[1], p[2]};
        }
        const Vec3 middle = (corner[0] + corner[1] + corner[2]) * (1.0 / 3);
        const Vec3 normal = normalised(cross(corner[1] - corner[0], corner[2] - corner[0]));
        const Vec3 back = normalised(Vec3{c[0], c[1], c[2]} - middle);
        const double cosine = dot(normal, back);
        if (cosine <= 0) { // turned away: the rasteriser draws both sides
          CHECK_FALSE(seen[f]);
          continue;
        }
        const double world[3] = {middle.x, middle.y, middle.z};
        double pixel[2];
        REQUIRE(fvv_camera_project(&camera, world, pixel, nullptr) == 1);
        if (pixel[0] < 0 || pixel[1] < 0 || pixel[0] >= camera.width || pixel[1] >= camera.height) continue;
        const size_t at = size_t(pixel[1] * 7) * buffer.columns + size_t(pixel[0] * 7);
        const bool drawn = buffer.face[at] == f;
        tested++;
        seen_count += seen[f];
        unlike += drawn != bool(seen[f]);
        if (cosine < 0.25) continue;
        broad++;
        broad_unlike += drawn != bool(seen[f]);
      }
    }
    // Centroid and sample are up to 0.1 pixels apart, which matters to faces that are narrow in the picture.
    const auto share = [](size_t part, size_t of) { return double(part) / double(of); };
    CAPTURE(tested, seen_count, unlike, broad, broad_unlike);
    CHECK(tested > 30000);
    CHECK(share(unlike, tested) < 0.04);
    CHECK(share(broad_unlike, broad) < 0.003); // 0.0007 and 0.0011
  }
}
