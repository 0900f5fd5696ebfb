// fvv_scene: texture coordinates of meshes. An upright square has each corner on another colour of a picture
// of 2 x 2 pixels; every format writes that on its own axes, and every reader has to find the colours.
#include "fvv_catch.h"
#include "gltf_fixture.h"

#include "fvv_scene/mesh_file.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace fvv::scene;
using gltf_fixture::File;

namespace {

// Rows from top to bottom, as pictures are stored.
constexpr const char *picture[2][2] = {{"red", "green"}, {"blue", "white"}};

// The pixel at u, v of fvv.md clause 8.6.
std::string colour(const Mesh &mesh, size_t vertex) {
  const auto pixel = [&](size_t k) { return std::min(1, int(mesh.texture[vertex * 2 + k] * 2)); };
  return picture[pixel(1)][pixel(0)];
}

// x to the right and y up: seen from the front, red is top left.
void check_square(const Mesh &mesh) {
  REQUIRE(mesh.texture.size() == mesh.vertex_count() * 2);
  std::set<std::string> seen;
  for (const uint32_t v : mesh.faces) {
    const double x = mesh.positions[v * 3], y = mesh.positions[v * 3 + 1];
    CHECK(colour(mesh, v) == (y > 0.5 ? (x > 0.5 ? "green" : "red") : (x > 0.5 ? "white" : "blue")));
    seen.insert(colour(mesh, v));
  }
  CHECK(seen.size() == 4);
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
Mesh obj(const std::string &text) {
  return parse_obj(text, "m.obj", nullptr, nullptr, true);
}
Mesh ply(const std::string &vertex, const std::string &face, const std::string &body) {
  return parse_ply("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
                   "float z\n" +
                       vertex + "element face 1\nproperty list uchar int vertex_indices\n" + face +
                       "end_header\n" + body,
                   "m.ply", nullptr, nullptr, true);
}
std::string message(const std::function<void()> &read) {
  try {
    read();
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

// Two triangles as another program writes them; texture coordinates on the axes of OBJ.
std::string draco_square(bool texture, bool seam) {
  const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const int faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int pairs =
      texture ? builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32) : -1;
  for (int f = 0; f < 2; f++) {
    const int *v = faces[f];
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(f), corners[v[0]], corners[v[1]],
                                      corners[v[2]]);
    float uv[3][2];
    for (int k = 0; k < 3; k++)
      for (int axis = 0; axis < 2; axis++)
        uv[k][axis] = corners[v[k]][axis] * (seam && f ? 0.75f : 1.0f) + (seam && f ? 0.125f : 0.0f);
    if (texture) builder.SetAttributeValuesForFace(pairs, draco::FaceIndex(f), uv[0], uv[1], uv[2]);
  }
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeMeshToBuffer(*builder.Finalize(), &buffer).ok());
  return std::string(buffer.data(), buffer.size());
}

// glTF counts v from the top: its own example reads (0, 0) as the upper left corner of the image.
File gltf_square() {
  File file;
  const size_t positions = file.add("VEC3", gltf_fixture::float32, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  auto &primitive = file.mesh(positions, int(file.add("SCALAR", gltf_fixture::uint16, {0, 1, 2, 0, 2, 3})));
  primitive["attributes"]["TEXCOORD_0"] = file.add("VEC2", gltf_fixture::float32, {0, 1, 1, 1, 1, 0, 0, 0});
  return file;
}
Mesh gltf(const File &file) {
  return parse_gltf(file.glb(), "m.glb", nullptr, nullptr, true);
}

// A material with a base colour out of image, and that image in the chunk BIN.
void paint(File &file, const std::string &bytes) {
  const size_t from = file.binary.size();
  file.binary += bytes;
  file.document["images"].push_back({{"bufferView", file.view(from)}, {"mimeType", "image/png"}});
  file.document["textures"].push_back({{"source", file.document["images"].size() - 1}});
  file.document["materials"].push_back(
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", file.document["textures"].size() - 1}}}}}});
}

} // namespace

TEST_CASE("texture coordinates: every reader turns them to the axes of the format") {
  check_square(obj(square + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"));
  check_square(obj(square + "vt 0 0 0\nvt 1 0 0\nvt 1 1 0\nvt 0 1 0\nf -4/-4/1 -3/-3/1 -2/-2/1 -1/-1/1\n"));
  check_square(obj("f 1/1 2/2 3/3\nf 1/1 3/3 4/4\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n" + square));
  for (const char *names : {"s t", "u v", "texture_u texture_v"}) {
    const std::string both = names, first = both.substr(0, both.find(' ')),
                      second = both.substr(both.find(' ') + 1);
    INFO(names);
    check_square(ply("property float " + first + "\nproperty double " + second + "\n", "",
                     "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n"));
  }
  check_square(ply("", "property list uchar float texcoord\nproperty int texnumber\n",
                   "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1 0\n"));
  check_square(parse_drc(draco_square(true, false), "m.drc", nullptr, nullptr, true));
  check_square(gltf(gltf_square()));
}

TEST_CASE("texture coordinates: every writer writes what its reader reads") {
  const Lattice lattice = {{0, 0, 0}, 0.001};
  Mesh mesh = obj(square + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
  mesh.texture[2] = 4095.0 / 4096;
  mesh.texture[3] = 1.0 / 65536;
  const Mesh drc = parse_drc(format_drc(mesh, lattice, "a"), "a", nullptr, nullptr, true);
  for (const Mesh &again :
       {obj(format_obj(mesh, "a")), drc, parse_ply(format_ply(mesh, "a"), "a", nullptr, nullptr, true)}) {
    CHECK(again.texture == mesh.texture);
    CHECK(again.faces == mesh.faces);
    CHECK(again.positions == mesh.positions);
  }
  mesh.texture.pop_back();
  CHECK(message([&] { format_obj(mesh, "a"); }) ==
        "a: expected 2 texture coordinates for each of 4 vertices, found 7");
  mesh.texture.push_back(NAN);
  CHECK(message([&] { format_ply(mesh, "a"); }) == "a: a texture coordinate of vertex 3 is not finite");
}

TEST_CASE("texture coordinates are not read unless requested") {
  CHECK(parse_obj(square + "vt nonsense\nf 1/7 2 3/9/1\n", "m.obj").texture.empty());
  CHECK(parse_drc(draco_square(true, true), "m.drc").vertex_count() == 4);
  File file = gltf_square();
  file.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 77;
  CHECK(parse_gltf(file.glb(), "m.glb").texture.empty());
}

TEST_CASE("texture coordinates: vertices on a seam are split, others stay where they are") {
  const std::string pairs = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt .5 .5\nvt 0 0\n";
  const Mesh mesh = obj(square + pairs + "f 1/1 2/2 3/3\nf 1/5 3/3 4/4\nf 1/6 4/4 2/2\nf 3/3 1/5 2/2");
  // Pairs of equal values are the same pair.
  CHECK(mesh.faces == std::vector<uint32_t>{0, 1, 2, 4, 2, 3, 0, 3, 1, 2, 4, 1});
  CHECK(mesh.positions == std::vector<double>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0});
  CHECK(mesh.texture == std::vector<double>{0, 1, 1, 1, 1, 0, 0, 0, .5, .5});
  const Mesh listed = ply("", "property list uchar float texcoord\n",
                          "0 0 0\n1 0 0\n1 1 0\n0 1 0\n5 0 1 2 0 3 10 0 0 1 0 1 1 .5 .5 0 1\n");
  CHECK(listed.vertex_count() == 5);
  CHECK(listed.faces == std::vector<uint32_t>{0, 1, 2, 0, 2, 4, 0, 4, 3});
  CHECK(listed.texture == mesh.texture);
  const Mesh drc = parse_drc(draco_square(true, true), "m.drc", nullptr, nullptr, true);
  CHECK(drc.vertex_count() == 6); // the two corners of the diagonal have two pairs
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = 4;
  CHECK(message([&] {
          parse_obj(square + pairs + "f 1/1 2/2 3/3\nf 1/5 3/3 4/4\n", "m.obj", &limits, nullptr, true);
        }) == "m.obj: more than the allowed 4 vertices, split where texture coordinates or normals differ");
}

TEST_CASE("texture coordinates: files that lack some are refused where they lack them") {
  CHECK(message([] { obj(square + "vt 0 0\nf 1/1 2/1 3/1\nf 1/1 3 4/1\n"); }) ==
        "m.obj:7: expected v/vt or v/vt/vn, for every corner needs texture coordinates, found \"3\"");
  CHECK(message([] { obj(square + "vt 0 0\nf 1/1 2/2 3/1\n"); }) ==
        "m.obj:6: texture coordinate 2 is used, the file has 1");
  CHECK(message([] { obj(square + "f 1/-1 2/1 3/1\n"); }) ==
        "m.obj:5: texture coordinate -1 is used, 0 precede it");
  CHECK(message([] { obj(square + "vt 0 inf\nf 1/1 2/1 3/1\n"); }) ==
        "m.obj: expected texture coordinates that are numbers, found others (vt) in triangle 0");
  CHECK(message([] { obj(square + "vt 0 inf\nvt 0.5\nf 1/2 2/2 3/2\n"); }).empty());
  CHECK(message([] { obj("vt 0 x\n"); }) == "m.obj:1: expected a finite number after vt, found \"x\"");
  CHECK(message([] { obj("vt\n"); }) == "m.obj:1: expected 1 to 3 numbers after vt, found 0");
  CHECK(message([] { ply("property float s\n", "", "0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 0\n3 0 1 2\n"); }) ==
        "m.ply:3: expected texture coordinates: properties s and t, u and v or texture_u and texture_v of "
        "the vertices, or a list texcoord of the faces; found none");
  CHECK(message([] {
          ply("", "property list uchar float texcoord\n", "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 4 0 0 1 1\n");
        }) == "m.ply:15: face 0: expected 6 numbers in texcoord, found 4");
  CHECK(message([] {
          parse_ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                    "float z\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar "
                    "float texcoord\nproperty int texnumber\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2 6 0 0 "
                    "1 0 1 1 0\n3 0 1 2 6 0 0 1 0 1 1 1\n",
                    "m.ply", nullptr, nullptr, true);
        }) == "m.ply:16: face 1: has texture 1, others have 0: expected one atlas for all faces");
  CHECK(message([] { parse_drc(draco_square(false, false), "m.drc", nullptr, nullptr, true); }) ==
        "m.drc: expected an attribute of texture coordinates, found none");
  File file = gltf_square();
  file.document["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  CHECK(message([&] { gltf(file); }) ==
        "m.glb: /meshes/0/primitives/0/attributes: expected key \"TEXCOORD_0\", found none");
}

TEST_CASE("texture coordinates: glTF materials name set, transform and picture") {
  File file = gltf_square();
  auto &primitive = file.document["meshes"][0]["primitives"][0];
  // Half the size, in the lower right quarter, upside down: undone by the transform.
  primitive["attributes"]["TEXCOORD_1"] =
      file.add("VEC2", gltf_fixture::uint16, {32768, 32768, 65535, 32768, 65535, 65535, 32768, 65535}, true);
  paint(file, "picture of the atlas");
  primitive["material"] = 0;
  check_square(gltf(file));
  auto &info = file.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  info["extensions"]["KHR_texture_transform"] = {{"offset", {-1, 2}}, {"scale", {2, -2}}, {"texCoord", 1}};
  const Mesh mesh = gltf(file);
  check_square(mesh);
  CHECK(mesh.texture[0] == Approx(0).margin(1e-4)); // 32768 is not exactly a half
  CHECK(parse_gltf_picture(file.glb(), "m.glb") == "picture of the atlas");
  info["extensions"]["KHR_texture_transform"]["rotation"] = "north";
  CHECK(message([&] { gltf(file); }).find("KHR_texture_transform/rotation: expected a number") !=
        std::string::npos);
  info["extensions"]["KHR_texture_transform"]["rotation"] = 1e7;
  CHECK(message([&] { gltf(file); }).find("KHR_texture_transform/rotation: expected radians") !=
        std::string::npos);
}

TEST_CASE("texture coordinates: glTF scales, then rotates, then moves") {
  // The example of the extension: the lower left quadrant, for coordinates of the whole picture.
  struct Case {
    double offset[2], rotation, scale[2], u, v;
  };
  const double quarter = std::acos(-1.0) / 2;
  for (const Case &one :
       {Case{{0, 1}, quarter, {0.5, 0.5}, 0.3, 0.6}, Case{{0, 0}, 0, {2, 3}, 0.3, 0.6},
        Case{{0.5, 0.25}, 0.392699, {1.5, 0.5}, 0.3, 0.6}, Case{{0, 0}, -7.5, {-1, 2}, 0.9, 0.1},
        Case{{1, 1}, 2 * quarter, {1, 1}, 0, 0}, Case{{0, 0}, 1000, {1, 1}, 0.1, 0.2}}) {
    CAPTURE(one.rotation);
    File file = gltf_square();
    file.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] =
        file.add("VEC2", gltf_fixture::float32, {one.u, one.v, one.u, one.v, one.u, one.v, one.u, one.v});
    paint(file, "picture");
    file.document["meshes"][0]["primitives"][0]["material"] = 0;
    file.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]
                 ["KHR_texture_transform"] = {{"offset", {one.offset[0], one.offset[1]}},
                                              {"scale", {one.scale[0], one.scale[1]}},
                                              {"rotation", one.rotation},
                                              {"texCoord", 1}};
    const Mesh mesh = gltf(file);
    const double c = std::cos(one.rotation), s = std::sin(one.rotation), u = one.u * one.scale[0],
                 v = one.v * one.scale[1];
    CHECK(mesh.texture[0] == Approx(c * u + s * v + one.offset[0]).margin(1e-6));
    CHECK(mesh.texture[1] == Approx(-s * u + c * v + one.offset[1]).margin(1e-6));
  }
}

TEST_CASE("texture coordinates: glTF with several pictures has no atlas") {
  File file = gltf_square();
  auto &primitives = file.document["meshes"][0]["primitives"];
  paint(file, "first");
  primitives.push_back(primitives[0]);
  primitives[0]["material"] = 0;
  CHECK(message([&] { gltf(file); }) == "m.glb: /nodes/0: expected one base colour image in the whole scene, "
                                        "found image 0 and none: bake one atlas of them");
  CHECK(message([&] { parse_gltf(file.glb(), "m.glb"); }) == "");
  paint(file, "second");
  primitives[1]["material"] = 1;
  CHECK(message([&] { gltf(file); }) == "m.glb: /nodes/0: expected one base colour image in the whole scene, "
                                        "found image 0 and image 1: bake one atlas of them");
  // Two materials of one image are one atlas.
  file.document["textures"][1]["source"] = 0;
  CHECK(gltf(file).vertex_count() == 8);
  CHECK(parse_gltf_picture(file.glb(), "m.glb") == "first");
  CHECK(message([] { parse_gltf_picture(gltf_square().glb(), "m.glb"); }) ==
        "m.glb: expected a material with a baseColorTexture, found none");
  file.document["images"][0] = {{"uri", "data:image/png;base64,Zmlyc3Q="}};
  CHECK(parse_gltf_picture(file.glb(), "m.glb") == "first");
  file.document["images"][0] = {{"uri", "../outside.png"}};
  CHECK(message([&] { parse_gltf_picture(file.glb(), "m.glb"); }) ==
        "m.glb: /images/0/uri: expected a data: URI or a file below the folder of this one, found "
        "\"../outside.png\"");
}

TEST_CASE("texture coordinates: glTF whose primitive is compressed by Draco") {
  File file = gltf_square();
  auto &primitive = file.document["meshes"][0]["primitives"][0];
  const size_t from = file.binary.size();
  // The axes of glTF: v of the Draco file points down here.
  const std::string bytes = draco_square(true, false);
  file.binary += bytes;
  primitive["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", file.view(from)}, {"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}};
  file.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  for (const size_t accessor : {0, 2}) file.document["accessors"][accessor].erase("bufferView");
  Mesh mesh = gltf(file);
  CHECK(mesh.face_count() == 2);
  REQUIRE(mesh.vertex_count() == 4);
  for (size_t v = 0; v < 4; v++) {
    CHECK(mesh.texture[2 * v] == mesh.positions[3 * v]);
    CHECK(mesh.texture[2 * v + 1] == mesh.positions[3 * v + 1]);
  }
  File other = file;
  other.document["accessors"][2]["count"] = 5;
  CHECK(message([&] { gltf(other); }) ==
        "m.glb: /accessors/2: expected what Draco holds: 4 elements of 2 components of type 5126");
  other = file;
  other.document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]
                ["TEXCOORD_0"] = 7;
  CHECK(message([&] { gltf(other); }) ==
        "m.glb: /meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: expected an attribute 7, found "
        "none");
  other = file;
  other.document["meshes"][0]["primitives"][0]["mode"] = 5;
  CHECK(message([&] { gltf(other); }) ==
        "m.glb: /meshes/0/primitives/0: expected triangles (mode 4) in a mesh compressed by Draco");
  // Every cut is an error, and so are most flips; none may do more than that.
  for (size_t at = 0; at < bytes.size(); at++) {
    other = file;
    other.binary[from + at] = char(other.binary[from + at] ^ 0x41);
    message([&] { gltf(other); });
    other = file;
    other.document["bufferViews"].back()["byteLength"] = at + 1;
    CHECK((at + 1 == bytes.size() || !message([&] { gltf(other); }).empty()));
  }
}
