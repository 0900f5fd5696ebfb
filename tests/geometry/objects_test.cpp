// Pieces of meshes as objects over time: what moves, touches, parts and is lost.
#include "fvv_geometry/objects.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

using fvv::geometry::Mesh;
using namespace fvv::objects;

namespace {

constexpr double frame = 0.04; // seconds

// A ball of triangles, stretched upwards.
void add_ball(Mesh &mesh, Vec3 centre, double radius, double stretch = 1) {
  constexpr int rows = 12, columns = 16;
  const auto first = uint32_t(mesh.vertex_count());
  for (int i = 0; i <= rows; i++)
    for (int j = 0; j < columns; j++) {
      const double a = 3.14159265358979 * i / rows, b = 2 * 3.14159265358979 * j / columns;
      mesh.positions.push_back(centre.x + radius * std::sin(a) * std::cos(b));
      mesh.positions.push_back(centre.y + stretch * radius * std::cos(a));
      mesh.positions.push_back(centre.z + radius * std::sin(a) * std::sin(b));
    }
  const auto at = [&](int i, int j) { return first + uint32_t(i * columns + j % columns); };
  for (int i = 0; i < rows; i++)
    for (int j = 0; j < columns; j++) {
      if (i > 0) mesh.faces.insert(mesh.faces.end(), {at(i, j), at(i, j + 1), at(i + 1, j)});
      if (i + 1 < rows) mesh.faces.insert(mesh.faces.end(), {at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
    }
}

// Joins two balls to one piece by a thin face.
void join(Mesh &mesh, size_t a, size_t b) {
  mesh.faces.insert(mesh.faces.end(), {uint32_t(a), uint32_t(b), uint32_t(b + 1)});
}

constexpr size_t ball_vertices = 13 * 16;

std::vector<std::vector<Piece>> made(size_t count, const std::function<void(Mesh &, double)> &scene) {
  std::vector<std::vector<Piece>> out;
  for (size_t i = 0; i < count; i++) {
    Mesh mesh;
    scene(mesh, double(i) * frame);
    out.push_back(pieces_of(mesh));
  }
  return out;
}

bool near(Vec3 a, Vec3 b, double tolerance) {
  return length(a - b) <= tolerance;
}

} // namespace

TEST_CASE("pieces have their centres and sizes, also in coordinates of maps") {
  Mesh mesh;
  const Vec3 origin{500000, 5000000, 100};
  add_ball(mesh, origin + Vec3{1, 2, 3}, 0.5);
  add_ball(mesh, origin + Vec3{4, 2, 3}, 0.12);
  add_ball(mesh, origin + Vec3{9, 2, 3}, 0.02); // less than a hundredth of the area of the largest
  const std::vector<Piece> pieces = pieces_of(mesh);
  REQUIRE(pieces.size() == 2);
  CHECK(near(pieces[0].centre, origin + Vec3{1, 2, 3}, 1e-6));
  CHECK(near(pieces[1].centre, origin + Vec3{4, 2, 3}, 1e-6));
  CHECK(std::abs(pieces[1].radius - 0.12) < 1e-6);
  CHECK(std::abs(pieces[0].area / (4 * 3.14159 * 0.25) - 1) < 0.05);
}

TEST_CASE("a ball that bounces between two players keeps its identity") {
  // It falls by 0.5 m within two frames, and turns.
  const auto height = [](double t) { return 0.12 + std::abs(std::sin(8 * t)); };
  const auto frames = made(50, [&](Mesh &mesh, double t) {
    add_ball(mesh, {-1 + 0.3 * t, 1, 0}, 0.25, 3.5);
    add_ball(mesh, {1 - 0.3 * t, 1, 0.1}, 0.27, 3.5);
    add_ball(mesh, {-1 + t, height(t), 0.6}, 0.12);
  });
  const Following found = follow(frames, frame);
  REQUIRE(found.objects.size() == 3);
  CHECK((found.touches.empty() && found.splits.empty()));
  for (size_t i = 0; i < 50; i++) {
    const double t = double(i) * frame;
    REQUIRE(found.objects[2].path[i]);
    CHECK(near(*found.objects[2].path[i], {-1 + t, height(t), 0.6}, 1e-6));
    CHECK(near(*found.objects[0].path[i], {1 - 0.3 * t, 1, 0.1}, 1e-6));
  }
  CHECK(std::abs(found.objects[2].radius - 0.12) < 1e-6);
}

TEST_CASE("who touches is reported, and who is who afterwards, by size") {
  // From frame 10 to 19 they are one piece; a player and a ball cannot be confused afterwards.
  const auto frames = made(30, [&](Mesh &mesh, double t) {
    const double apart = std::abs(t - 0.58) + 0.1;
    add_ball(mesh, {-apart, 1, 0}, 0.25, 3.5);
    add_ball(mesh, {apart, 1, 0}, 0.12);
    if (t > 9.5 * frame && t < 19.5 * frame) join(mesh, 0, ball_vertices);
  });
  const Following found = follow(frames, frame);
  REQUIRE(found.objects.size() == 2);
  REQUIRE(found.touches.size() == 1);
  const Touch &touch = found.touches[0];
  CHECK(
      (touch.objects == std::vector<size_t>{0, 1} && touch.first == 10 && touch.last == 19 && touch.is_sure));
  CHECK(found.objects[1].path[25]->x > 0);
  CHECK(found.objects[0].path[25]->x < 0);
  // Both have the centre of the piece that they share.
  CHECK(near(*found.objects[0].path[15], *found.objects[1].path[15], 0));
  // The piece that they shared says nothing of their sizes.
  CHECK(std::abs(found.objects[1].radius - 0.12) < 1e-6);
}

TEST_CASE("twins that were one piece for long are not told apart without a mark") {
  const auto frames = made(60, [&](Mesh &mesh, double t) {
    const double x = std::abs(t - 1.2) < 0.6 ? 0.2 : 0.2 + std::abs(t - 1.2) - 0.6;
    // Turned by a quarter while they are together: they part along another line than the one on which they
    // met.
    const bool after = t > 1.2;
    add_ball(mesh, after ? Vec3{0, 1, x} : Vec3{x, 1, 0}, 0.25, 3.5);
    add_ball(mesh, after ? Vec3{0, 1, -x} : Vec3{-x, 1, 0}, 0.25, 3.5);
    if (std::abs(t - 1.2) < 0.61) join(mesh, 0, ball_vertices);
  });
  const Following found = follow(frames, frame);
  REQUIRE(found.objects.size() == 2);
  REQUIRE(found.touches.size() == 1);
  CHECK(!found.touches[0].is_sure);
  CHECK((found.objects[0].path.back() && found.objects[1].path.back()));
}

TEST_CASE("what is out of sight for a while is found again, and what comes off is reported") {
  const auto frames = made(50, [&](Mesh &mesh, double t) {
    add_ball(mesh, {0, 1, 0}, 0.25, 3.5);
    if (t < 0.5 || t > 0.9) add_ball(mesh, {1 + 2 * t, 1, 0}, 0.12);
    // A shoe, where a foot was.
    if (t > 1.0) add_ball(mesh, {0.02 + (t - 1), 0.2, 0}, 0.1);
  });
  const Following found = follow(frames, frame);
  REQUIRE(found.objects.size() == 3);
  CHECK(!found.objects[1].path[15]);
  REQUIRE(found.objects[1].path[40]);
  CHECK(found.objects[1].path[40]->x > 3);
  REQUIRE(found.splits.size() == 1);
  CHECK((found.splits[0].from == 0 && found.splits[0].object == 2));
}

TEST_CASE("a speck of a few frames is no object") {
  const auto frames = made(30, [&](Mesh &mesh, double t) {
    add_ball(mesh, {0, 1, 0}, 0.25);
    if (t > 0.5 && t < 0.6) add_ball(mesh, {2, 1, 0}, 0.1);
  });
  CHECK(follow(frames, frame).objects.size() == 1);
  CHECK(follow({}, frame).objects.empty());
  CHECK(follow({{}, {}}, frame).objects.empty());
}
