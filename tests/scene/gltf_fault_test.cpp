// tools/capture: malformed and hostile glTF: each fault has one sentence, no prefix passes, no mutation does
// harm.
#include "fvv_catch.h"

#include "gltf_fixture.h"
#include "scene/src/gltf/pose.h"

#include <functional>
#include <random>

extern "C" {
#include "base/memory.h"
}

using namespace fvv::scene;
using namespace gltf_fixture;

namespace {

// In a block of exactly that size, so that a sanitizer sees every byte too many.
std::string complaint(const std::string &bytes) {
  const std::vector<char> exact(bytes.begin(), bytes.end());
  try {
    const gltf::Scene scene = gltf::read_scene(std::string_view(exact.data(), exact.size()), "m.glb",
                                               gltf::OnlyAnimation{}, fvv_limits_or_default(nullptr));
    for (const double time : {0.0, 0.3, 1e9}) {
      const Mesh mesh = gltf::pose(scene, time);
      for (const uint32_t index : mesh.faces) REQUIRE(index < mesh.vertex_count());
    }
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

// The tube after a change, without "m.glb: ".
std::string fault(const std::function<void(File &)> &change) {
  File file = tube();
  change(file);
  const std::string what = complaint(file.glb());
  return what.substr(0, 7) == "m.glb: " ? what.substr(7) : what;
}

// The same with one value of the JSON replaced.
std::string fault(const char *pointer, const json &value) {
  return fault([&](File &file) { file.document[json::json_pointer(pointer)] = value; });
}

} // namespace

TEST_CASE("glTF: a chain of nodes has a greatest length") {
  for (const int length : {1024, 1025, 200'000}) {
    File file = triangle();
    file.document["nodes"] = json::array();
    for (int i = 0; i + 1 < length; i++) file.document["nodes"].push_back({{"children", {i + 1}}});
    file.document["nodes"].push_back({{"mesh", 0}, {"translation", {1, 2, 3}}});
    std::string what;
    try {
      const double x = parse_gltf(file.glb(), "m.glb").positions[0];
      CHECK(x == 1);
    } catch (const fvv::Error &error) {
      what = error.what();
    }
    CHECK(what == (length == 1024
                       ? ""
                       : "m.glb: /nodes/1024: expected at most 1024 nodes one below the other, found more"));
  }
}

TEST_CASE("glTF: a faulty GLB is refused in one sentence") {
  const std::string good = tube().glb();
  REQUIRE(complaint(good).empty());
  const auto changed = [&](size_t at, const std::string &with) {
    return complaint(std::string(good).replace(at, with.size(), with));
  };
  CHECK(complaint("") == "m.glb: 0x0: expected glTF 2.0, which begins with \"glTF\" (GLB) or with { (JSON)");
  CHECK(complaint("ply\n") ==
        "m.glb: 0x0: expected glTF 2.0, which begins with \"glTF\" (GLB) or with { (JSON)");
  CHECK(complaint("glTF\2") == "m.glb: 0x5: the file ends within the GLB header");
  CHECK(changed(4, "\1") == "m.glb: 0x4: expected GLB version 2, found 1: gltf-pipeline converts it "
                            "(gltf-pipeline -i old.gltf -o new.glb)");
  CHECK(complaint(good + "x") == "m.glb: 0x8: expected a file of " + std::to_string(good.size()) +
                                     " bytes, found " + std::to_string(good.size() + 1));
  CHECK(changed(12, "\xff\xff\xff\xff") == "m.glb: 0xc: expected a chunk of at most " +
                                               std::to_string(good.size() - 20) + " bytes, found 4294967295");
  CHECK(changed(16, "JSOM") == "m.glb: 0x10: expected the chunk JSON first");
  CHECK(complaint("glTF" + File::u32(2) + File::u32(12)) == "m.glb: 0xc: expected the chunk JSON first");
  CHECK(complaint("glTF" + File::u32(2) + File::u32(16) + "JSON") ==
        "m.glb: 0xc: the file ends within the header of a chunk");
  CHECK(changed(20, "[") != "");
  CHECK(complaint("{\"asset\": {\"version\": \"2.0\"}, \"asset\": 1}") ==
        "m.glb: /asset: the key is repeated in its object");
}

TEST_CASE("glTF: a faulty description is refused at its place") {
  CHECK(fault("/asset/version", "1.0") == "/asset/version: expected glTF 2, found \"1.0\": gltf-pipeline "
                                          "converts it (gltf-pipeline -i old.gltf -o new.glb)");
  CHECK(fault("/asset/version", "3.0") == "/asset/version: expected glTF 2, found \"3.0\"");
  CHECK(complaint("{\"meshes\": {\"a\": {}}}").find("gltf-pipeline") != std::string::npos);
  CHECK(complaint("glTF" + File::u32(1) + File::u32(12)).find("gltf-pipeline") != std::string::npos);
  CHECK(fault("/asset/minVersion", "2.1") ==
        "/asset/minVersion: expected a file that a reader of glTF 2.0 can read, found \"2.1\"");
  CHECK(fault("/extensionsRequired", {"VENDOR_displacement"}) ==
        "/extensionsRequired/0: expected KHR_mesh_quantization or an extension of "
        "materials, textures or lights, found \"VENDOR_displacement\"");
  CHECK(fault("/scene", 1) == "/scene: expected one of 1 scenes, found 1");
  CHECK(fault([](File &file) { file.document.erase("scenes"); }) == "expected a scene, found none");
  CHECK(fault("/scenes/0/nodes", {1}) == "expected a scene with at least one triangle, found none");
  CHECK(fault("/scenes/0/nodes", {3}) ==
        "/scenes/0/nodes/0: expected a node without parent, found a child of node 2");
  CHECK(fault("/nodes/3/children", {9}) == "/nodes/3/children/0: expected one of 4 nodes, found 9");
  CHECK(fault("/nodes/0/children", {3}) ==
        "/nodes/2/children/0: expected a node with one parent, found 3, which is also a child of node 0");
  CHECK(fault([](File &file) {
          file.document["nodes"][1].erase("children");
          file.document["nodes"][3]["children"] = {2};
        }) == "/nodes/2: expected a tree of nodes, found a cycle");
  CHECK(fault("/nodes/1/translation", {1, 2}) == "/nodes/1/translation: expected 3 items, found 2");
  CHECK(fault("/nodes/1/rotation", {0, 0, 0, 0}) ==
        "/nodes/1/rotation: expected a rotation, found a quaternion without direction");
  CHECK(fault("/nodes/1/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}) ==
        "/nodes/1/matrix: expected 0 0 0 1 as the last row of the matrix");
  CHECK(fault("/nodes/3/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}) ==
        "/animations/0/channels/0/target/node: expected a node without matrix, which cannot be animated");
  CHECK(fault("/nodes/0/mesh", -1) == "/nodes/0/mesh: expected an integer from 0 to 2147483647, found -1");
  CHECK(fault("/meshes/0/primitives/0/mode", 7) ==
        "/meshes/0/primitives/0/mode: expected an integer from 0 to 6, found 7");
  CHECK(fault("/meshes/0/primitives/0/targets/0/POSITION", 1) ==
        "/accessors/1: expected displacements as VEC3 of float32, int8, uint8, int16 or uint16, found "
        "\"SCALAR\" of uint8");
  CHECK(fault("/meshes/0/primitives/0/extensions", {{"KHR_draco_mesh_compression", json::object()}}) ==
        "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: expected key \"attributes\", found "
        "none");
  CHECK(fault([](File &file) {
          file.document["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
        }) ==
        "/meshes/0/primitives/0/attributes: expected JOINTS_0 and WEIGHTS_0 together, found one of them");
  CHECK(fault([](File &file) {
          file.document["meshes"][0]["primitives"][0]["attributes"].erase("JOINTS_0");
          file.document["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
        }) == "/nodes/0: has a skin: expected JOINTS_0 and WEIGHTS_0 in every primitive of its mesh");
  CHECK(fault("/skins/0/joints", {2}) == "/nodes/0: joint 1 moves its mesh, its skin has 1 joints");
  CHECK(fault("/skins/0/joints", {2, 3, 1}) ==
        "/accessors/4: expected a matrix for each of 3 joints, found 2");
  CHECK(fault("/skins/0/joints", json::array()) ==
        "/skins/0/joints: expected at least one joint, found none");
}

TEST_CASE("glTF: faulty buffers, views and accessors are refused at their place") {
  const auto uri = [](const char *text) {
    File file = triangle();
    const std::string what = complaint(file.text(text));
    return what.substr(what.find(' ') + 1);
  };
  for (const char *outside : {"../m.bin", "/etc/passwd", "a/../../m.bin", "%2e%2e/m.bin", "http://host/m.bin",
                              "file:m.bin", "a\\b", "a%00b", "a%2", "C:m.bin"})
    CHECK(uri(outside).substr(0, 80) ==
          "/buffers/0/uri: expected a data: URI or a file below the folder of this one, fou");
  for (const char *bad : {"data:,abc", "data:x/y;base64,A", "data:x/y;base64,A===", "data:x/y;base64,AA*A"})
    CHECK(uri(bad).substr(0, 50) == "/buffers/0/uri: expected base64 in a data: URI, fo");
  CHECK(uri("") == "/buffers/0: expected a uri, or the chunk BIN for buffer 0 of a GLB, found neither");
  const std::string size = std::to_string(tube().binary.size());
  CHECK(fault("/buffers", {{{"byteLength", 1000000}}}) ==
        "/buffers/0: expected 1000000 bytes, found " + size);
  CHECK(fault("/bufferViews/0/buffer", 2) == "/bufferViews/0/buffer: expected one of 1 buffers, found 2");
  CHECK(fault("/bufferViews/0/byteLength", 9223372036854775807) ==
        "/bufferViews/0: expected bytes 0 to 9223372036854775807 in a buffer of " + size);
  CHECK(fault("/bufferViews/0/byteOffset", 9223372036854775807) ==
        "/bufferViews/0: expected bytes 9223372036854775807 to 9223372036854776207 in a buffer of " + size);
  CHECK(fault("/bufferViews/0/byteStride", 8) ==
        "/accessors/0: expected a byteStride of at least 12, found 8");
  CHECK(fault("/accessors/0/bufferView", 99) ==
        "/accessors/0/bufferView: expected one of 7 bufferViews, found 99");
  CHECK(fault("/accessors/0/count", 21) ==
        "/accessors/0: expected 412 bytes from byte 0 of a bufferView of 400");
  CHECK(fault("/accessors/0/count", 4294967295) ==
        "/accessors/0: expected 85899345892 bytes from byte 0 of a bufferView of 400");
  CHECK(fault("/accessors/0/byteOffset", 9223372036854775807) ==
        "/accessors/0: expected 392 bytes from byte 9223372036854775807 of a bufferView of 400");
  CHECK(fault("/accessors/0/componentType", 5124) ==
        "/accessors/0/componentType: expected 5120 to 5123, 5125 or 5126, found 5124");
  CHECK(fault("/accessors/0/normalized", true) ==
        "/accessors/0: expected positions as VEC3 of float32, int8, uint8, int16 or uint16, found normalised "
        "\"VEC3\" of float32");
  CHECK(fault("/accessors/0/normalized", 1) == "/accessors/0/normalized: expected true or false, found 1");
  CHECK(fault("/accessors/1/count", 95) ==
        "/meshes/0/primitives/0: expected a multiple of 3 corners, found 95");
  CHECK(fault("/accessors/2/count", 19) ==
        "/accessors/2: expected an element for each of 20 vertices, found 19");
  CHECK(fault([](File &file) { file.binary[400] = 20; }) ==
        "/accessors/1: element 0: index 20 of 20 vertices");
  CHECK(fault([](File &file) { memcpy(&file.binary[4], "\0\0\xc0\x7f", 4); }) ==
        "/accessors/0: element 0: expected finite numbers, found nan or inf");
  const json sparse = {{"count", 2},
                       {"indices", {{"bufferView", 1}, {"componentType", 5121}}},
                       {"values", {{"bufferView", 0}}}};
  CHECK(fault([&](File &file) {
          file.document["accessors"][0]["sparse"] = sparse;
          file.binary[400] = 4;
        }) == "/accessors/0/sparse/indices: expected indices that increase and stay below 20, index 1 is 4");
  CHECK(fault([&](File &file) {
          file.document["accessors"][0]["sparse"] = sparse;
          file.document["accessors"][0]["sparse"]["count"] = 21;
        }) == "/accessors/0/sparse/count: expected an integer from 1 to 20, found 21");
}

TEST_CASE("glTF: a faulty animation is refused at its place") {
  CHECK(fault("/animations/0/channels/0/sampler", 1) ==
        "/animations/0/channels/0/sampler: expected one of 1 samplers, found 1");
  CHECK(fault("/animations/0/channels/0/target/path", "pointer") ==
        "/animations/0/channels/0/target/path: expected translation, rotation, scale or weights, found "
        "\"pointer\"");
  CHECK(fault("/animations/0/channels/0/target", {{"path", "pointer"}}) ==
        "/animations/0: expected an animation that moves something, found none");
  CHECK(fault("/animations/0/channels/0/target", {{"path", "weights"}, {"node", 0}}) ==
        "/animations/0/channels/0/target/path: expected a node whose mesh has morph targets");
  CHECK(fault("/animations/0/samplers/0/interpolation", "SMOOTH") ==
        "/animations/0/samplers/0/interpolation: expected STEP, LINEAR or CUBICSPLINE, found \"SMOOTH\"");
  CHECK(fault("/animations/0/samplers/0/interpolation", "CUBICSPLINE") ==
        "/accessors/6: expected 24 numbers for 2 times, found 8");
  CHECK(fault("/animations/0/samplers/0/input", 6) ==
        "/accessors/6: expected times as SCALAR of float32, found \"VEC4\" of float32");
  CHECK(fault([](File &file) {
          const size_t at = file.document["bufferViews"][5]["byteOffset"];
          memset(&file.binary[at + 4], 0, 4);
        }) == "/accessors/5: expected times that begin at 0 or later and increase, element 1 does not");
  CHECK(fault([](File &file) {
          const size_t at = file.document["bufferViews"][6]["byteOffset"];
          memset(&file.binary[at], 0, 16);
        }) == "/accessors/6: element 0: expected a rotation, found a quaternion of length 0");
}

TEST_CASE("glTF: no prefix is taken for a whole file, no mutation does harm") {
  const std::string glb = tube().glb(), text = tube().text(tube().data_uri());
  for (size_t size = 0; size < glb.size(); size++) CHECK(complaint(glb.substr(0, size)) != "");
  for (size_t size = 0; size < text.size(); size++) CHECK(complaint(text.substr(0, size)) != "");
  std::mt19937 random(11);
  size_t passed = 0;
  for (const std::string &bytes : {glb, text})
    for (int round = 0; round < 3000; round++) {
      std::string bad = bytes;
      for (uint32_t changes = 1 + random() % 3; changes; changes--) {
        // Digits of the description give more new paths than anything else.
        const size_t place = random() % bad.size();
        const bool digit = bad[place] >= '0' && bad[place] <= '9';
        bad[place] = digit ? static_cast<char>('0' + random() % 10) : static_cast<char>(random());
      }
      const std::string what = complaint(bad);
      passed += what.empty();
      CHECK((what.empty() || what.compare(0, 5, "m.glb") == 0));
    }
  CHECK(passed > 100); // the others were not all stopped at the door
}
