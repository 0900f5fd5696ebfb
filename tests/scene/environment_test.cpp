// fvv_scene: environments from and to glTF, and the environment of capture.json.
#include "fvv_catch.h"

#include "fvv_scene/environment.h"

#include "fvv_scene/capture.h"
#include "gltf_fixture.h"

#include <cmath>

using namespace fvv::scene;
using gltf_fixture::File;
using nlohmann::json;

namespace {

constexpr int float32 = gltf_fixture::float32, uint16 = gltf_fixture::uint16;

// A triangle that is drawn twice, at (0 0 0) and moved by 10 along x, with a material of its own beside it:
// two parts. A spot above, turned by 90 degrees about x so that it looks along +y, and a sun in another
// scene.
File stage() {
  File file = gltf_fixture::triangle();
  json &first = file.document["meshes"][0]["primitives"][0];
  first["attributes"]["TEXCOORD_0"] = file.add("VEC2", float32, {-1, 0, 3, 0, 3, 2.5});
  first["attributes"]["NORMAL"] = file.add("VEC3", float32, {0, 0, 1, 0, 0, 1, 0, 0, 1});
  first["material"] = 1;
  json second = first;
  second["material"] = 0;
  second["attributes"].erase("TEXCOORD_0");
  file.document["meshes"][0]["primitives"].push_back(second);
  const size_t from = file.binary.size();
  file.binary += "PICTURE";
  file.document["images"] = {{{"bufferView", file.view(from)}, {"mimeType", "image/png"}}};
  file.document["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33071}}};
  file.document["textures"] = {{{"source", 0}}, {{"source", 0}, {"sampler", 0}}};
  file.document["materials"] = {
      {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0, 0.5}}}}, {"doubleSided", true}},
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}},
       {"extensions", {{"KHR_materials_unlit", json::object()}}}}};
  file.document["extensions"] = {{"KHR_lights_punctual",
                                  {{"lights",
                                    {{{"type", "spot"},
                                      {"intensity", 12.5},
                                      {"range", 7},
                                      {"color", {1, 0.5, 0}},
                                      {"spot", {{"innerConeAngle", 0.25}}}},
                                     {{"type", "directional"}, {"extras", {{"casts_shadows", false}}}}}}}}};
  const double half = std::sqrt(0.5);
  file.document["nodes"] = {{{"mesh", 0}},
                            {{"mesh", 0}, {"translation", {10, 0, 0}}},
                            {{"translation", {1, 2, 3}},
                             {"rotation", {half, 0, 0, half}},
                             {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
                            {{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}}};
  file.document["scenes"] = {{{"nodes", {0, 1, 2}}}, {{"nodes", {3}}}};
  return file;
}

std::string failure(const File &file) {
  try {
    parse_environment(file.glb(), "room.glb");
  } catch (const fvv::Error &error) {
    return error.what();
  }
  return "";
}

} // namespace

TEST_CASE("an environment has a part for each material and the lights of its scene") {
  const Environment found = parse_environment(stage().glb(), "room.glb");
  REQUIRE(found.parts.size() == 2);
  const EnvironmentPart &pictured = found.parts[0], &plain = found.parts[1];
  CHECK(pictured.picture == 0u);
  CHECK(found.pictures == std::vector<std::string>{"PICTURE"});
  CHECK(pictured.clamped);
  CHECK(pictured.unlit);
  CHECK(!pictured.double_sided);
  CHECK(pictured.mesh.texture == std::vector<double>{-1, 0, 3, 0, 3, 2.5, -1, 0, 3, 0, 3, 2.5});
  CHECK(pictured.mesh.positions[9] == 10);
  CHECK(pictured.mesh.faces == std::vector<uint32_t>{0, 1, 2, 3, 4, 5});
  CHECK(plain.double_sided);
  CHECK(!plain.picture);
  CHECK(plain.mesh.texture.empty());
  CHECK(plain.mesh.normals.size() == 18);
  CHECK(plain.colour[1] == 0.25);
  REQUIRE(found.lights.size() == 1);
  const fvv_light &spot = found.lights[0];
  CHECK(spot.type == FVV_LIGHT_SPOT);
  CHECK(spot.flags == FVV_LIGHT_CASTS_SHADOWS);
  CHECK(spot.position[2] == 3);
  CHECK(std::abs(spot.direction[1] - 1) < 1e-12);
  CHECK(spot.intensity == 12.5);
  CHECK(spot.range == 7);
  CHECK(spot.inner_cone == 0.25);
  CHECK(std::abs(spot.outer_cone - 0.785398163) < 1e-8);
}

TEST_CASE("an environment comes back from the GLB that is made of it") {
  const Lattice lattice = {{0, 0, 0}, 0.125};
  Environment in = parse_environment(stage().glb(), "room.glb");
  in.lights.push_back({FVV_LIGHT_DIRECTIONAL, 0, {0, 0, 0}, {0, 0, -1}, {1, 1, 1}, 3, 0, 0, 0});
  in.lights.push_back({FVV_LIGHT_DIRECTIONAL, 0, {0, 0, 0}, {0, 0, 1}, {1, 1, 1}, 3, 0, 0, 0});
  in.lights.push_back({FVV_LIGHT_POINT, 1, {1, -2, 3}, {0, 0, 0}, {1, 1, 0.5}, 3, 0, 0, 0});
  const std::string glb = format_environment(in, lattice, "out.glb");
  const Environment out = parse_environment(glb, "out.glb");
  REQUIRE(out.parts.size() == in.parts.size());
  CHECK(out.pictures == in.pictures);
  for (size_t i = 0; i < in.parts.size(); i++) {
    const EnvironmentPart &a = in.parts[i], &b = out.parts[i];
    CHECK(a.mesh.positions == b.mesh.positions);
    CHECK(a.mesh.faces == b.mesh.faces);
    CHECK(a.mesh.texture == b.mesh.texture);
    CHECK(a.mesh.normals == b.mesh.normals);
    CHECK(a.picture == b.picture);
    CHECK(std::equal(a.colour, a.colour + 3, b.colour));
    CHECK(std::tie(a.unlit, a.double_sided, a.clamped) == std::tie(b.unlit, b.double_sided, b.clamped));
  }
  REQUIRE(out.lights.size() == in.lights.size());
  for (size_t i = 0; i < in.lights.size(); i++) {
    const fvv_light &a = in.lights[i], &b = out.lights[i];
    CHECK(a.type == b.type);
    CHECK(a.flags == b.flags);
    for (int k = 0; k < 3; k++) {
      CHECK(a.position[k] == b.position[k]);
      CHECK(std::abs(a.direction[k] - b.direction[k]) < 1e-12);
      CHECK(a.colour[k] == b.colour[k]);
    }
    CHECK(std::tie(a.intensity, a.range, a.inner_cone, a.outer_cone) ==
          std::tie(b.intensity, b.range, b.inner_cone, b.outer_cone));
  }
}

TEST_CASE("coordinates that float32 would move off the lattice are refused") {
  Environment far = parse_environment(stage().glb(), "room.glb");
  far.parts[0].mesh.positions[3] = 100000.001; // and others near the origin
  CHECK_THROWS_WITH(format_environment(far, {{0, 0, 0}, 0.001}, "far.glb"),
                    "far.glb: vertex 1 lies too far out for float32, the numbers of glTF, on a lattice of "
                    "this step: PLY has float64");
}

TEST_CASE("an environment is moved with its lights, and turned round by a mirror") {
  Environment moved = parse_environment(stage().glb(), "room.glb");
  fvv::scene::gltf::Transform by;
  by.m = {-2, 0, 0, 1, 0, 0, 2, 0, 0, 2, 0, 5}; // x mirrored; y and z exchanged: no mirror in all
  moved.transform(by);
  CHECK(moved.parts[0].mesh.positions[3] == -1); // (1, 0, 0)
  CHECK(moved.parts[0].mesh.positions[8] == 9);  // (0, 2, 0)
  CHECK(moved.parts[0].mesh.faces[1] == 1);
  CHECK(moved.lights[0].position[0] == -1);
  CHECK(moved.lights[0].position[1] == 6);
  CHECK(std::abs(moved.lights[0].direction[2] - 1) < 1e-12);
  CHECK(std::abs(moved.lights[0].range - 14) < 1e-9);
  by.m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0};
  moved.transform(by);
  CHECK(moved.parts[0].mesh.faces[1] == 2);
}

TEST_CASE("what is wrong with an environment is named") {
  File file = stage();
  file.document["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 7;
  CHECK(failure(file).find("/materials/1/pbrMetallicRoughness/baseColorTexture/index") != std::string::npos);
  file = stage();
  file.document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][1] = 2;
  CHECK(failure(file) ==
        "room.glb: /materials/0/pbrMetallicRoughness/baseColorFactor/1: expected 0 to 1, found 2");
  json *lights = &(file = stage()).document["extensions"]["KHR_lights_punctual"]["lights"];
  (*lights)[0]["type"] = "area";
  CHECK(failure(file).find("expected directional, point or spot, found \"area\"") != std::string::npos);
  lights = &(file = stage()).document["extensions"]["KHR_lights_punctual"]["lights"];
  (*lights)[0]["spot"]["innerConeAngle"] = 1;
  CHECK(failure(file).find("expected innerConeAngle below outerConeAngle") != std::string::npos);
  file = stage();
  file.document["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 2;
  CHECK(failure(file).find("expected one of 2 lights, found 2") != std::string::npos);
  file = stage();
  file.document["materials"][0]["alphaMode"] = "BLEND";
  CHECK(parse_environment(file.glb(), "room.glb").notes ==
        std::vector<std::string>{"transparency and cut-outs are left out"});
}

TEST_CASE("capture.json names an environment, its place in the world and its lattice") {
  const auto with = [](const std::string &environment) {
    return R"({"fvv_capture": 1, "frame_rate": 25, "units": "metres", "frames": {"first": 0, "count": 1},)"
           R"( "meshes": {"pattern": "%d.ply"}, "environment": )" +
           environment + "}";
  };
  const Capture plain = parse_capture(with(R"({"file": "room.glb"})"), "c.json");
  CHECK(plain.environment->file == "room.glb");
  CHECK(!plain.environment->lattice);
  const Capture placed =
      parse_capture(with(R"({"file": "a/room.gltf", "lattice": {"origin": [1, 2, 3], "step": 0.5},)"
                         R"( "transform": [[0, 0, 1, 4], [1, 0, 0, 5], [0, 1, 0, 6]]})"),
                    "c.json");
  CHECK(placed.environment->transform.m[7] == 5);
  CHECK(placed.environment->lattice->step == 0.5);
  for (const Capture &capture : {plain, placed}) {
    const std::string text = format_capture(capture);
    CHECK(format_capture(parse_capture(text, "c.json")) == text);
  }
  CHECK_THROWS_WITH(parse_capture(with(R"({"file": "room.obj"})"), "c.json"),
                    "c.json: /environment/file: expected a .glb or .gltf file, found \"room.obj\"");
  CHECK_THROWS_WITH(
      parse_capture(with(R"({"file": "room.glb", "transform": [[1, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0]]})"),
                    "c.json"),
      "c.json: /environment/transform: expected a transform that keeps volume, found one with the "
      "determinant 0");
  const Findings findings = check_files(plain, {});
  CHECK(std::find(findings.problems.begin(), findings.problems.end(), "environment: room.glb: is missing") !=
        findings.problems.end());
}

TEST_CASE("capture.json: background is the former name of environment, read with a warning") {
  const std::string before = R"({"fvv_capture": 1, "frame_rate": 25, "units": "metres",)"
                             R"( "frames": {"first": 0, "count": 1}, "meshes": {"pattern": "%d.ply"},)";
  const Capture former = parse_capture(before + R"( "background": {"file": "room.glb"}})", "c.json");
  CHECK(former.environment->file == "room.glb");
  const std::string warning = "\"background\" is now \"environment\"; this version reads both";
  CHECK(former.notes == std::vector<std::string>{warning});
  const std::vector<std::string> warnings = check_files(former, {}).warnings;
  CHECK(std::find(warnings.begin(), warnings.end(), warning) != warnings.end());
  CHECK(format_capture(former).find("background") == std::string::npos);
  CHECK_THROWS_WITH(
      parse_capture(before + R"( "background": {"file": "a.glb"}, "environment": {"file": "b.glb"}})",
                    "c.json"),
      "c.json: expected \"environment\" alone, found also \"background\", its former name");
}
