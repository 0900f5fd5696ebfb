// tools/capture: normals of meshes. A roof of two slopes has a hard edge at its ridge; every format has to
// keep its two normals apart, and glTF has to turn them with what it draws.
#include "fvv_catch.h"
#include "gltf_fixture.h"

#include "fvv_scene/mesh_file.h"
#include "scene/src/gltf/pose.h"

extern "C" {
#include "base/memory.h"
}

#include <algorithm>
#include <functional>

using namespace fvv::scene;
using namespace gltf_fixture;

namespace {

// Corners 0 and 1 are the ridge.
const std::string roof = "v 0 0 1\nv 0 4 1\nv -1 0 0\nv -1 4 0\nv 1 0 0\nv 1 4 0\n";
const std::string roof_faces = "f 1//1 2//1 4//1 3//1\nf 1//2 5//2 6//2 2//2\n";

Mesh obj(const std::string &text, bool texture = false) {
  return parse_obj(text, "m.obj", nullptr, nullptr, texture, true);
}

// Each corner's normal leans to the side of its face.
void check_roof(const Mesh &mesh) {
  REQUIRE(mesh.normals.size() == mesh.positions.size());
  REQUIRE(mesh.face_count() == 4);
  for (size_t f = 0; f < 4; f++) {
    double side = 0;
    for (size_t c = 0; c < 3; c++) side += mesh.positions[3 * size_t(mesh.faces[3 * f + c])];
    for (size_t c = 0; c < 3; c++) {
      const double *n = &mesh.normals[3 * size_t(mesh.faces[3 * f + c])];
      CHECK(n[0] == (side < 0 ? -0.5 : 0.5));
      CHECK(n[1] == 0);
      CHECK(n[2] == 0.5);
    }
  }
}

std::string message(const std::function<void()> &read) {
  try {
    read();
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

} // namespace

TEST_CASE("OBJ: vertices are split where normals differ") {
  const Mesh mesh = obj(roof + "vn -0.5 0 0.5\nvn 0.5 0 0.5\n" + roof_faces);
  CHECK(mesh.vertex_count() == 8);
  check_roof(mesh);
  // Not requested: vertices are not split, and normals are not checked.
  const Mesh plain = parse_obj(roof + "vn what\n" + roof_faces, "m.obj");
  CHECK(plain.vertex_count() == 6);
  CHECK(plain.normals.empty());
  // One corner without a normal: none.
  const Mesh some = obj(roof + "vn -0.5 0 0.5\nf 1//1 2//1 4//1 3//1\nf 1//1 5//1 6 2//1\n");
  CHECK(some.normals.empty());
  CHECK(some.vertex_count() == 6);
  // Seams and edges are one matter: of the two at each end of the ridge none is left out.
  const Mesh both = obj(roof + "vn -0.5 0 0.5\nvn 0.5 0 0.5\nvt 0 0\nvt 1 1\n"
                               "f 1/1/1 2/1/1 4/1/1 3/1/1\nf 1/2/2 5/2/2 6/2/2 2/1/2\n",
                        true);
  check_roof(both);
  CHECK(both.vertex_count() == 8);
  CHECK(both.texture.size() == 16);
}

TEST_CASE("OBJ: normals that are none are errors with their line") {
  CHECK(message([] { obj(roof + "vn 0 1\n" + roof_faces); }) ==
        "m.obj:7: expected 3 numbers after vn, found 2");
  CHECK(message([] { obj(roof + "vn 0 nan 1\n" + roof_faces); }) ==
        "m.obj:7: expected a finite number after vn, found \"nan\"");
  CHECK(message([] { obj(roof + "vn 0 0 1\n" + roof_faces); }) ==
        "m.obj:9: normal 2 is used, the file has 1");
}

TEST_CASE("PLY: normals of vertices, through the split at seams too") {
  const auto ply = [](const std::string &face, const std::string &rows, bool normals = true) {
    return parse_ply("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
                     "float z\nproperty float nz\nproperty float ny\nproperty float nx\n"
                     "element face 2\nproperty list uchar int vertex_indices\n" +
                         face + "end_header\n0 0 0 1 2 3\n1 0 0 4 5 6\n1 1 0 7 8 9\n0 1 0 10 11 12\n" + rows,
                     "m.ply", nullptr, nullptr, !face.empty(), normals);
  };
  const Mesh mesh = ply("", "3 0 1 2\n3 0 2 3\n");
  CHECK(mesh.normals == std::vector<double>{3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10});
  CHECK(ply("", "3 0 1 2\n3 0 2 3\n", false).normals.empty());
  const Mesh seam =
      ply("property list uchar float texcoord\n", "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0.5 0 1 1 0 1\n");
  CHECK(seam.vertex_count() == 5);
  CHECK(std::vector<double>(seam.normals.end() - 3, seam.normals.end()) == std::vector<double>{3, 2, 1});
}

TEST_CASE("what is written with normals is read with the same ones") {
  const Mesh mesh = obj(roof + "vn -0.5 0 0.5\nvn 0.5 0 0.5\n" + roof_faces);
  Mesh textured = mesh;
  for (size_t i = 0; i < 16; i++) textured.texture.push_back(double(i) / 16);
  const Lattice lattice = {{0, 0, 0}, 0.001};
  for (const Mesh *one : {&static_cast<const Mesh &>(mesh), &static_cast<const Mesh &>(textured)}) {
    const bool texture = !one->texture.empty();
    for (const Mesh &again :
         {parse_obj(format_obj(*one, "m.obj"), "m.obj", nullptr, nullptr, texture, true),
          parse_ply(format_ply(*one, "m.ply"), "m.ply", nullptr, nullptr, texture, true),
          parse_drc(format_drc(*one, lattice, "m.drc"), "m.drc", nullptr, nullptr, texture, true)}) {
      CHECK(again.positions == one->positions);
      CHECK(again.faces == one->faces);
      CHECK(again.normals == one->normals);
      CHECK(again.texture == one->texture);
    }
  }
  textured.normals.pop_back();
  CHECK(message([&] { format_ply(textured, "m.ply"); }) ==
        "m.ply: expected 3 normal coordinates for each of 8 vertices, found 23");
}

TEST_CASE("glTF: normals stay perpendicular on stretched, mirrored, bent and morphed surfaces") {
  const auto pose = [](const File &file, bool normals = true) {
    return gltf::pose(gltf::read_scene(file.glb(), "m.glb", gltf::NoAnimation{},
                                       fvv_limits_or_default(nullptr), gltf::Texture::skipped, normals),
                      std::nullopt);
  };
  // (0, 0, 1) is the triangle's own; a tangent and the normal stay at right angles.
  const std::vector<double> lean = {1, 2, 2, 1, 2, 2, 1, 2, 2};
  for (const double mirror : {1.0, -1.0}) {
    File file = triangle();
    file.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = file.add("VEC3", float32, lean);
    const std::vector<double> scale = {2 * mirror, 3, 0.5}; // turned by 90 degrees about z afterwards
    file.document["nodes"][0]["scale"] = scale;
    file.document["nodes"][0]["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};
    const Mesh mesh = pose(file);
    REQUIRE(mesh.normals.size() == 9);
    // By the inverse transpose: each axis divided by its scale.
    const double expected[3] = {-lean[1] / scale[1], lean[0] / scale[0], lean[2] / scale[2]};
    const double ratio = mesh.normals[2] / expected[2];
    CHECK(ratio > 0);
    for (size_t k = 0; k < 3; k++) CHECK(mesh.normals[k] == Approx(ratio * expected[k]).margin(1e-6));
    CHECK(pose(file, false).normals.empty());

    file.document["meshes"][0]["primitives"][0]["targets"] = {
        {{"NORMAL", file.add("VEC3", float32, {0, 0, 4, 0, 0, 4, 0, 0, 4})}}};
    file.document["meshes"][0]["weights"] = {0.5};
    const Mesh morphed = pose(file);
    CHECK(morphed.normals[2] == Approx(2 * mesh.normals[2]));
    CHECK(morphed.normals[0] == Approx(mesh.normals[0]));
  }
  // At its end the tube follows joint 1, half way up it follows both by halves.
  File bent = tube();
  std::vector<double> up;
  for (int v = 0; v < 20; v++) up.insert(up.end(), {0, 1, 0});
  bent.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = bent.add("VEC3", float32, up);
  const Mesh mesh = gltf::pose(gltf::read_scene(bent.glb(), "m.glb", gltf::OnlyAnimation{},
                                                fvv_limits_or_default(nullptr), gltf::Texture::skipped, true),
                               1.0);
  REQUIRE(mesh.normals.size() == 60);
  for (const auto &[vertex, angle] : {std::pair(0, 0.0), std::pair(8, 45.0), std::pair(16, 90.0)}) {
    const double *n = &mesh.normals[3 * size_t(vertex)];
    CHECK(std::atan2(-n[0], n[1]) * 180 / std::acos(-1.0) == Approx(angle).margin(1e-4));
    CHECK(n[2] == Approx(0).margin(1e-6));
  }
  // One primitive without normals: none.
  File half = triangle();
  half.document["meshes"][0]["primitives"].push_back(half.document["meshes"][0]["primitives"][0]);
  half.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = half.add("VEC3", float32, lean);
  CHECK(pose(half).normals.empty());
  CHECK(pose(half).vertex_count() == 6);
}
