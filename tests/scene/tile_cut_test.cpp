// fvv_scene: faces on which a picture repeats, cut where it begins again.
#include "fvv_catch.h"
#include "fvv_cxx/untrusted.h"

#include "fvv_scene/file_io.h"
#include "scene/src/atlas/atlas.h"
#include "scene/src/atlas/tile_cut.h"

#include <array>
#include <cmath>
#include <map>
#include <random>

using namespace fvv::scene;

namespace {

using Point = std::array<double, 3>;
using Borders = std::array<TileBorders, 2>;

constexpr double snap = 5e-5;
const fvv_limits limits = fvv::limits_or_default(nullptr);

Point point_of(const Mesh &mesh, uint32_t vertex) {
  return {mesh.positions[3 * size_t(vertex)], mesh.positions[3 * size_t(vertex) + 1],
          mesh.positions[3 * size_t(vertex) + 2]};
}

Point difference(const Point &a, const Point &b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Point cross(const Point &a, const Point &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Point normal_of(const Mesh &mesh, size_t face) {
  const Point a = point_of(mesh, mesh.faces[3 * face]);
  return cross(difference(point_of(mesh, mesh.faces[3 * face + 1]), a),
               difference(point_of(mesh, mesh.faces[3 * face + 2]), a));
}

double area_in_texture(const std::vector<double> &texture, size_t face) {
  const double *t = &texture[6 * face];
  return (t[2] - t[0]) * (t[5] - t[1]) - (t[4] - t[0]) * (t[3] - t[1]);
}

// Each edge is that of two faces, in opposite directions, where ends are places.
bool is_closed(const Mesh &mesh) {
  std::map<std::pair<Point, Point>, int> edges;
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const Point a = point_of(mesh, mesh.faces[i]), b = point_of(mesh, mesh.faces[i % 3 == 2 ? i - 2 : i + 1]);
    edges[{a, b}]++;
    edges[{b, a}]--;
  }
  for (const auto &[edge, count] : edges)
    if (count != 0) return false;
  return !edges.empty();
}

// A closed body; every face has vertices of its own, as at seams, or shares them.
Mesh body(bool seams) {
  Mesh mesh;
  const Point top = {0.1, 0.2, 1}, bottom = {0, 0, -1.2};
  const size_t parts = 5;
  std::vector<Point> points = {top, bottom};
  for (size_t i = 0; i < parts; i++) {
    const double turn = 2 * 3.14159265358979 * double(i) / double(parts);
    points.push_back({std::cos(turn), std::sin(turn), 0.1 * double(i)});
  }
  for (uint32_t i = 0; i < parts; i++) {
    const uint32_t a = 2 + i, b = 2 + (i + 1) % uint32_t(parts);
    mesh.faces.insert(mesh.faces.end(), {0, a, b, 1, b, a});
  }
  if (seams) {
    std::vector<Point> own;
    for (uint32_t &vertex : mesh.faces) {
      own.push_back(points[vertex]);
      vertex = uint32_t(own.size() - 1);
    }
    points = own;
  }
  for (const Point &point : points) mesh.positions.insert(mesh.positions.end(), point.begin(), point.end());
  return mesh;
}

// Of each corner: by vertex, so that neighbours agree.
std::vector<double> of_corners(const Mesh &mesh, const std::vector<double> &of_vertices) {
  std::vector<double> texture;
  for (const uint32_t vertex : mesh.faces)
    texture.insert(texture.end(), {of_vertices[2 * size_t(vertex)], of_vertices[2 * size_t(vertex) + 1]});
  return texture;
}

// Cuts, and checks what holds of every cut.
Mesh checked_cut(const Mesh &mesh, const std::vector<double> &texture, const std::vector<Borders> &borders) {
  const TileCut cut = cut_at_tiles(mesh, texture, borders, mesh.positions, snap, limits, "m");
  Mesh out = mesh;
  apply_cut(cut, out);
  std::vector<Point> sums(mesh.face_count());
  std::vector<double> areas(mesh.face_count());
  for (size_t face = 0; face < out.face_count(); face++) {
    const uint32_t whole = cut.whole[face];
    const Point normal = normal_of(out, face);
    for (size_t k = 0; k < 3; k++) sums[whole][k] += normal[k];
    areas[whole] += area_in_texture(cut.texture, face);
    for (size_t axis = 0; axis < 2; axis++) {
      const double *t = &cut.texture[6 * face + axis];
      const double low = std::min({t[0], t[2], t[4]}), high = std::max({t[0], t[2], t[4]});
      if (borders[whole][axis] == TileBorders::all) CHECK(high <= std::floor(low + snap) + 1 + snap);
      if (borders[whole][axis] == TileBorders::own)
        CHECK((high <= snap || low >= 1 - snap || (low >= -snap && high <= 1 + snap)));
    }
    // Pieces keep the side, and their corners the texture of their place.
    const Point of_whole = normal_of(mesh, whole);
    CHECK(normal[0] * of_whole[0] + normal[1] * of_whole[1] + normal[2] * of_whole[2] > 0);
  }
  for (size_t face = 0; face < mesh.face_count(); face++) {
    const Point normal = normal_of(mesh, face);
    for (size_t k = 0; k < 3; k++) CHECK(sums[face][k] == Approx(normal[k]).margin(1e-9));
    CHECK(areas[face] == Approx(area_in_texture(texture, face)).margin(2e-3));
  }
  return out;
}

} // namespace

TEST_CASE("a square of three by two tiles becomes six") {
  Mesh mesh;
  mesh.positions = {0, 0, 0, 3, 0, 0, 3, 2, 0, 0, 2, 0};
  mesh.faces = {0, 1, 2, 0, 2, 3};
  const std::vector<double> texture = of_corners(mesh, {0, 0, 3, 0, 3, 2, 0, 2});
  const Mesh out = checked_cut(mesh, texture, std::vector<Borders>(2, {TileBorders::all, TileBorders::all}));
  // 12 corners of tiles, and three where the diagonal crosses a border elsewhere.
  CHECK(out.vertex_count() == 12 + 3);
  const Mesh one = checked_cut(mesh, texture, std::vector<Borders>(2, {TileBorders::own, TileBorders::none}));
  CHECK(one.vertex_count() == 4 + 3);
  CHECK(cut_at_tiles(mesh, texture, std::vector<Borders>(2, {TileBorders::none, TileBorders::none}),
                     mesh.positions, snap, limits, "m")
            .faces == mesh.faces);
}

TEST_CASE("closed bodies stay closed, whatever their texture") {
  std::mt19937 random(7);
  for (int round = 0; round < 60; round++) {
    const bool seams = round % 2;
    const double span = round % 3 == 0 ? 1.5 : round % 3 == 1 ? 6 : 40;
    const Mesh mesh = body(seams);
    std::vector<double> of_vertices(2 * mesh.vertex_count());
    for (double &value : of_vertices) {
      value = span * (double(random()) / 4294967296.0 - 0.3);
      // Corners on borders, and nearly there.
      if (random() % 5 == 0) value = std::round(value) + (random() % 2 ? 0 : 3e-5);
    }
    std::vector<Borders> borders(mesh.face_count(), {TileBorders::all, TileBorders::all});
    for (Borders &of_face : borders) {
      if (random() % 4 == 0) of_face[random() % 2] = TileBorders::own;
      if (random() % 4 == 0) of_face = {TileBorders::none, TileBorders::none};
    }
    REQUIRE(is_closed(mesh));
    CHECK(is_closed(checked_cut(mesh, of_corners(mesh, of_vertices), borders)));
  }
}

TEST_CASE("pieces have the texture of their places") {
  std::mt19937 random(9);
  Mesh mesh = body(true);
  mesh.normals.resize(mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); i += 3) mesh.normals[i + 2] = 1;
  std::vector<double> of_vertices(2 * mesh.vertex_count());
  for (double &value : of_vertices) value = 9 * (double(random()) / 4294967296.0 - 0.5);
  const std::vector<double> texture = of_corners(mesh, of_vertices);
  const TileCut cut = cut_at_tiles(
      mesh, texture, std::vector<Borders>(mesh.face_count(), {TileBorders::all, TileBorders::all}),
      mesh.positions, snap, limits, "m");
  Mesh out = mesh;
  apply_cut(cut, out);
  CHECK(out.normals.size() == out.positions.size());
  for (size_t i = 0; i < out.faces.size(); i++) {
    CHECK(out.normals[3 * size_t(out.faces[i]) + 2] == Approx(1));
    // Weights of the corners of the whole face, by areas.
    const size_t whole = cut.whole[i / 3];
    const Point normal = normal_of(mesh, whole), at = point_of(out, out.faces[i]);
    const double square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    double found[2] = {};
    for (size_t c = 0; c < 3; c++) {
      const Point b = difference(point_of(mesh, mesh.faces[3 * whole + (c + 1) % 3]), at),
                  d = difference(point_of(mesh, mesh.faces[3 * whole + (c + 2) % 3]), at);
      const Point part = cross(b, d);
      const double weight = (part[0] * normal[0] + part[1] * normal[1] + part[2] * normal[2]) / square;
      for (size_t axis = 0; axis < 2; axis++) found[axis] += weight * texture[6 * whole + 2 * c + axis];
    }
    for (size_t axis = 0; axis < 2; axis++)
      CHECK(cut.texture[2 * i + axis] == Approx(found[axis]).margin(1e-4));
  }
}

TEST_CASE("too many pieces are refused") {
  Mesh mesh;
  mesh.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  mesh.faces = {0, 1, 2};
  const std::vector<Borders> all(1, {TileBorders::all, TileBorders::all});
  const auto cut = [&](double times, const fvv_limits &bounds = limits) {
    return cut_at_tiles(mesh, {0, 0, times, 0, 0, times}, all, mesh.positions, snap, bounds, "m.obj");
  };
  CHECK(cut(200).whole.size() > 200 * 199 / 2 * 2);
  CHECK_THROWS_WITH(cut(300), Catch::Contains("m.obj: face 0") && Catch::Contains("90000 times"));
  for (const double far : {1e10, 1e300, double(INFINITY), double(NAN)})
    CHECK_THROWS_WITH(cut(far), Catch::Contains("m.obj: face 0"));
  fvv_limits few = limits;
  few.max_faces = 100;
  CHECK_THROWS_WITH(cut(20, few), Catch::Contains("100 faces"));
  few = limits;
  few.max_vertices = 30;
  CHECK_THROWS_WITH(cut(20, few), Catch::Contains("30 vertices"));
}

TEST_CASE("a mesh without repeated pictures stays as it is") {
  Mesh mesh = body(false);
  mesh.texture = std::vector<double>(2 * mesh.vertex_count(), 0.5);
  mesh.texture[0] = -1e-5;
  Mesh other = mesh;
  FacePictures faces;
  settle_texture(mesh, faces, limits, "m");
  faces.bake_repeats = true;
  settle_texture(other, faces, limits, "m");
  CHECK(mesh.faces == other.faces);
  CHECK(mesh.texture == other.texture);
  CHECK(mesh.positions == other.positions);
}
