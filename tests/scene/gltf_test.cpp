// tools/capture: static glTF: containers, buffers, accessors, primitives, and the tree of nodes.
#include "fvv_catch.h"
#include "fvv_scene/file_io.h"

#include "fvv_scene/mesh_file.h"
#include "gltf_fixture.h"

#include <algorithm>
#include <filesystem>
#include <unistd.h>

using namespace fvv::scene;
using namespace gltf_fixture;
namespace fs = std::filesystem;

namespace {

using Numbers = std::vector<double>;
using Faces = std::vector<uint32_t>;

Mesh read(const File &file) {
  return parse_gltf(file.glb(), "m.glb");
}

double distance(const Numbers &a, const Numbers &b) {
  REQUIRE(a.size() == b.size());
  double most = 0;
  for (size_t i = 0; i < a.size(); i++) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

} // namespace

TEST_CASE("glTF: a triangle in a GLB, in a separate file, as a data: URI") {
  const File file = triangle();
  const Numbers positions = {0, 0, 0, 1, 0, 0, 0, 2, 0};
  const Mesh mesh = read(file);
  CHECK(mesh.positions == positions);
  CHECK(mesh.faces == Faces{0, 1, 2});
  CHECK(parse_gltf(file.text(file.data_uri()), "m.gltf").positions == positions);
  const fs::path root = fs::temp_directory_path() / ("fvv_gltf_test_" + std::to_string(getpid()));
  fs::create_directories(root / "part s");
  write_file((root / "part s/m.bin").string(), file.binary);
  // An image that is not there is not missed.
  File with_image = file;
  with_image.document["images"] = {{{"uri", "absent.png"}}};
  write_file((root / "m.gltf").string(), "\n " + with_image.text("part%20s/m.bin"));
  write_file((root / "m.GLB").string(), file.glb());
  CHECK(read_mesh((root / "m.gltf").string()).positions == positions);
  CHECK(read_mesh((root / "m.GLB").string()).positions == positions);
  write_file((root / "part s/m.bin").string(), file.binary.substr(1));
  CHECK_THROWS_WITH(read_mesh((root / "m.gltf").string()),
                    (root / "m.gltf").string() + ": /buffers/0: expected " +
                        std::to_string(file.binary.size()) + " bytes, found " +
                        std::to_string(file.binary.size() - 1));
  fs::remove(root / "part s/m.bin");
  CHECK_THROWS_WITH(read_mesh((root / "m.gltf").string()),
                    (root / "m.gltf").string() + ": /buffers/0/uri: " + (root / "part s/m.bin").string() +
                        ": cannot be opened: No such file or directory");
  fs::remove_all(root);
}

TEST_CASE("glTF: links may lead to files below the folder of the file, and to no others") {
  const fs::path root = fs::temp_directory_path() / ("fvv_gltf_link_test_" + std::to_string(getpid()));
  fs::remove_all(root);
  fs::create_directories(root / "in/part");
  fs::create_directories(root / "inside");
  const File file = triangle();
  const std::string place = (root / "in/m.gltf").string();
  const auto complaint = [&](const char *uri) {
    write_file(place, file.text(uri));
    try {
      read_mesh(place);
      return std::string();
    } catch (const fvv::Error &error) {
      return std::string(error.what());
    }
  };
  for (const char *bin : {"in/part/m.bin", "secret.bin", "inside/m.bin"})
    write_file((root / bin).string(), file.binary);
  fs::create_symlink("part/m.bin", root / "in/near.bin");
  fs::create_symlink("../secret.bin", root / "in/far.bin");
  fs::create_symlink(root / "secret.bin", root / "in/part/absolute.bin");
  fs::create_directory_symlink("../inside", root / "in/folder");
  fs::create_symlink("../nowhere.bin", root / "in/dangling.bin");
  CHECK(complaint("near.bin").empty());
  for (const char *uri : {"far.bin", "part/absolute.bin", "folder/m.bin"})
    CHECK(complaint(uri) == place +
                                ": /buffers/0/uri: expected a file below the folder of this one, found a "
                                "symbolic link out of it: \"" +
                                uri + "\"");
  CHECK(!complaint("dangling.bin").empty());
  // The folder itself may be reached by a link, and so may the file.
  fs::create_directory_symlink(root / "in", root / "other");
  complaint("near.bin");
  CHECK(read_mesh((root / "other/m.gltf").string()).vertex_count() == 3);
  // Pictures are found in the same way.
  File with_picture = file;
  const size_t coordinates = with_picture.add("VEC2", float32, {0, 0, 1, 0, 1, 1});
  json &primitive = with_picture.document["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_0"] = coordinates;
  primitive["material"] = 0;
  with_picture.document["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  with_picture.document["textures"] = {{{"source", 0}}};
  with_picture.document["images"] = {{{"uri", "far.bin"}}};
  write_file((root / "in/m.glb").string(), with_picture.glb());
  CHECK_THROWS_WITH(
      parse_gltf_picture(with_picture.glb(), (root / "in/m.glb").string()),
      (root / "in/m.glb").string() +
          ": /images/0/uri: expected a file below the folder of this one, found a symbolic link "
          "out of it: \"far.bin\"");
  fs::remove_all(root);
}

TEST_CASE(
    "glTF: nodes multiply from the root, matrices and TRS, mirrors turn faces round, other scenes stay out") {
  File file = triangle();
  const double half = std::sqrt(0.5);
  file.document["nodes"] = {
      // 90 degrees about z after doubling x, then moved by (10, 20, 30).
      {{"children", {1, 2}},
       {"translation", {10, 20, 30}},
       {"rotation", {0, 0, half, half}},
       {"scale", {2, 1, 1}}},
      {{"mesh", 0}},
      {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 7, 1}}},
      {{"mesh", 0}},
      {{"mesh", 0}, {"translation", {-1, 0, 0}}},
  };
  file.document["scenes"] = {{{"nodes", {3}}}, {{"nodes", {0, 4}}}};
  file.document["scene"] = 1;
  const Mesh mesh = read(file);
  CHECK(mesh.faces == Faces{0, 1, 2, 3, 5, 4, 6, 7, 8});
  CHECK(distance(mesh.positions, {10, 20, 30, 10, 22, 30, 8,  20, 30, // (x, y) to (-y, 2x)
                                  10, 20, 37, 10, 22, 37, 8,  20, 37, //
                                  -1, 0,  0,  0,  0,  0,  -1, 2,  0}) < 1e-12);
  file.document.erase("scene");
  CHECK(read(file).positions == Numbers{0, 0, 0, 1, 0, 0, 0, 2, 0});
}

TEST_CASE("glTF: strips, fans, no indices, indices of all types, lines and points counted") {
  for (const int type : {uint8, uint16, uint32}) {
    File file;
    const size_t positions = file.add("VEC3", float32, {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    json &primitive = file.mesh(positions, static_cast<int>(file.add("SCALAR", type, {0, 1, 2, 3, 4})));
    primitive["mode"] = 5;
    CHECK(read(file).faces == Faces{0, 1, 2, 1, 3, 2, 2, 3, 4});
    primitive["mode"] = 6;
    CHECK(read(file).faces == Faces{1, 2, 0, 2, 3, 0, 3, 4, 0});
    primitive.erase("indices");
    CHECK(read(file).faces == Faces{1, 2, 0, 2, 3, 0, 3, 4, 0});
    json &primitives = file.document["meshes"][0]["primitives"];
    for (const int mode : {0, 1, 2, 3}) {
      primitives.push_back(primitives[0]);
      primitives.back()["mode"] = mode;
    }
    MeshReport report;
    CHECK(parse_gltf(file.glb(), "m.glb", nullptr, &report).face_count() == 3);
    CHECK(report.lines_and_points == 4);
  }
}

TEST_CASE("glTF: quantised positions, normalised or not, with a stride") {
  struct Case {
    int type;
    bool normalised;
    double most; // what the greatest number means
    double raw;
  };
  for (const Case &c : {Case{int8, true, 1, 127},
                        {uint8, true, 1, 255},
                        {int16, true, 1, 32767},
                        {uint16, true, 1, 65535},
                        {int8, false, 127, 127},
                        {uint8, false, 255, 255},
                        {int16, false, 32767, 32767},
                        {uint16, false, 65535, 65535}}) {
    File file;
    file.document["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit"};
    file.mesh(file.add("VEC3", c.type, {0, 0, 0, c.raw, 0, 0, 0, c.raw, 0}, c.normalised, 8));
    CHECK(read(file).positions == Numbers{0, 0, 0, c.most, 0, 0, 0, c.most, 0});
  }
  // -128 is no more than -127.
  File file;
  file.mesh(file.add("VEC3", int8, {0, 0, 0, -128, 0, 0, 0, -127, 0}, true));
  CHECK(read(file).positions == Numbers{0, 0, 0, -1, 0, 0, 0, -1, 0});
}

TEST_CASE("glTF: sparse accessors, over bytes and over nothing") {
  for (const bool bytes : {true, false}) {
    File file;
    const size_t positions = file.add("VEC3", float32, {0, 0, 0, 1, 0, 0, 0, 2, 0, 9, 9, 9});
    const size_t places = file.view((file.put(1, uint8), file.put(3, uint8), file.binary.size() - 2));
    const size_t from = file.binary.size();
    for (const double value : {3, 4, 5, 6, 7, 8}) file.put(value, float32);
    file.document["accessors"][positions]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", places}, {"componentType", uint8}}},
        {"values", {{"bufferView", file.view(from)}}}};
    if (!bytes) file.document["accessors"][positions].erase("bufferView");
    file.mesh(positions)["mode"] = 5;
    CHECK(read(file).positions == (bytes ? Numbers{0, 0, 0, 3, 4, 5, 0, 2, 0, 6, 7, 8}
                                         : Numbers{0, 0, 0, 3, 4, 5, 0, 0, 0, 6, 7, 8}));
  }
}

TEST_CASE("glTF: limits hold for the scene as drawn, and a small file cannot ask for much") {
  File file = triangle();
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = 5;
  CHECK(parse_gltf(file.glb(), "m.glb", &limits).vertex_count() == 3);
  file.document["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}};
  file.document["scenes"][0]["nodes"] = {0, 1};
  CHECK_THROWS_WITH(parse_gltf(file.glb(), "m.glb", &limits),
                    "m.glb: /nodes/1: expected a scene of at most 5 vertices and 8388608 triangles");
  limits.max_vertices = 6;
  CHECK(parse_gltf(file.glb(), "m.glb", &limits).vertex_count() == 6);
  file.document["accessors"][0].erase("bufferView");
  file.document["accessors"][0]["count"] = 4294967295;
  CHECK_THROWS_WITH(read(file), "m.glb: /accessors/0: expected accessors that hold at most 16777216 numbers "
                                "together in buffers of 0 bytes");
}
