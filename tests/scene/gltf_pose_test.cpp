// tools/capture: glTF in motion: skins, morph targets, interpolation, and animated files in a capture.
#include "fvv_catch.h"

#include "fvv_scene/capture.h"
#include "gltf_fixture.h"
#include "scene/src/gltf/pose.h"

#include <algorithm>
#include <filesystem>
#include <thread>
#include <unistd.h>

extern "C" {
#include "base/memory.h"
}

using namespace fvv::scene;
using namespace gltf_fixture;
namespace fs = std::filesystem;

namespace {

using Numbers = std::vector<double>;

gltf::Scene scene_of(const File &file, const gltf::AnimationChoice &choice = gltf::OnlyAnimation{}) {
  return gltf::read_scene(file.glb(), "m.glb", choice, fvv_limits_or_default(nullptr));
}

Numbers at(const File &file, double time) {
  return gltf::pose(scene_of(file), time).positions;
}

double distance(const Numbers &a, const Numbers &b) {
  REQUIRE(a.size() == b.size());
  double most = 0;
  for (size_t i = 0; i < a.size(); i++) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

// The triangle, moved by the first channel of node 0.
File moving(const char *path, const std::string &type, const Numbers &times, const Numbers &values,
            const char *interpolation) {
  File file = triangle();
  const size_t input = file.add("SCALAR", float32, times);
  file.channel(0, path, input, file.add(type, float32, values), interpolation);
  return file;
}

struct Folder {
  const fs::path root = fs::temp_directory_path() / ("fvv_gltf_pose_test_" + std::to_string(getpid()));
  Folder() { fs::create_directories(root); }
  ~Folder() { fs::remove_all(root); }
  std::string path(const std::string &name) const { return (root / name).string(); }
  Capture capture(const std::string &meshes,
                  const std::string &frames = R"({"first": 5, "count": 4, "step": 2})") const {
    return parse_capture(R"({"fvv_capture": 1, "frame_rate": 4, "units": "centimetres", "frames": )" +
                             frames + R"(, "meshes": )" + meshes + "}",
                         path("capture.json"));
  }
};

} // namespace

TEST_CASE("glTF: a skinned tube bends as sines and cosines say") {
  const File file = tube();
  const gltf::Scene scene = scene_of(file);
  const Mesh rest = gltf::pose(scene, std::nullopt);
  REQUIRE(rest.vertex_count() == 20);
  CHECK(rest.face_count() == 32);
  const double pi = std::acos(-1.0);
  for (const double time : {-1.0, 0.0, 0.001, 0.25, 1.0 / 3, 0.5, 0.875, 1.0, 7.0}) {
    const Mesh mesh = gltf::pose(scene, time);
    CHECK(mesh.faces == rest.faces);
    Numbers expected;
    for (size_t i = 0; i < rest.positions.size(); i += 3) {
      // At rest the tube is straight, doubled and moved by 5.
      const double corner[3] = {(rest.positions[i] - 5) / 2, rest.positions[i + 1] / 2,
                                rest.positions[i + 2] / 2};
      double bent[3];
      bend(pi / 2 * std::clamp(time, 0.0, 1.0), corner, bent);
      expected.insert(expected.end(), bent, bent + 3);
    }
    INFO(time);
    CHECK(distance(mesh.positions, expected) < 1e-12);
  }
}

TEST_CASE("glTF: further sets of joints, quantised weights, no inverse bind matrices") {
  File file = tube();
  json &attributes = file.document["meshes"][0]["primitives"][0]["attributes"];
  Numbers joints, weights;
  for (int i = 0; i < 20; i++) {
    joints.insert(joints.end(), {1, 0, 0, 0});
    weights.insert(weights.end(), {51, 0, 0, 0});
  }
  // Half of every vertex's weight of 2 goes to joint 1 besides: 0.2 of 2.2 in all.
  attributes["JOINTS_1"] = file.add("VEC4", uint16, joints);
  attributes["WEIGHTS_1"] = file.add("VEC4", uint8, weights, true);
  file.document["skins"][0].erase("inverseBindMatrices");
  const Numbers positions = at(file, 0);
  // Vertex 0 at (0.25, 0, 0.25): joint 1, at y = 1, lifts it by 1 with a weight of 0.2 / 2.2.
  CHECK(distance({positions[0], positions[1], positions[2]}, {5.5, 2 * 0.2 / 2.2, 0.5}) < 1e-12);
}

TEST_CASE("glTF: morph targets by weights of mesh, node and animation, added before the node's transform") {
  File file = triangle();
  json &primitive = file.document["meshes"][0]["primitives"][0];
  primitive["targets"] = {{{"POSITION", file.add("VEC3", float32, {0, 0, 1, 0, 0, 2, 0, 0, 3})}},
                          json::object(),
                          {{"POSITION", file.add("VEC3", int8, {10, 0, 0, 0, 10, 0, 0, 0, 0}, false, 4)}}};
  file.document["nodes"][0]["scale"] = {1, 1, 2};
  const size_t times = file.add("SCALAR", float32, {0, 2});
  file.channel(0, "weights", times, file.add("SCALAR", int8, {0, 0, 0, 127, 127, -127}, true));
  const auto rest = [&] { return parse_gltf(file.glb(), "m.glb").positions; };
  CHECK(rest() == Numbers{0, 0, 0, 1, 0, 0, 0, 2, 0});
  file.document["meshes"][0]["weights"] = {0.5, 1, 0};
  CHECK(rest() == Numbers{0, 0, 1, 1, 0, 2, 0, 2, 3});
  file.document["nodes"][0]["weights"] = {0, 1, 0.25};
  CHECK(rest() == Numbers{2.5, 0, 0, 1, 2.5, 0, 0, 2, 0});
  CHECK(at(file, 0) == Numbers{0, 0, 0, 1, 0, 0, 0, 2, 0});
  CHECK(at(file, 1) == Numbers{-5, 0, 1, 1, -5, 2, 0, 2, 3});
}

TEST_CASE("glTF: step, linear and cubic spline") {
  const Numbers times = {0.5, 0.7f, 1.5}, values = {1, 0, 0, 3, 0, 0, 5, 0, 8};
  const File step = moving("translation", "VEC3", times, values, "STEP");
  CHECK(at(step, 0)[0] == 1);
  CHECK(at(step, 0.69)[0] == 1);
  CHECK(at(step, 0.7)[0] == 3); // the keyframe is 0.699999988 or so
  CHECK(at(step, 1.4999)[0] == 3);
  CHECK(at(step, 1.5)[0] == 5);
  const File linear = moving("scale", "VEC3", {0, 2}, {1, 1, 1, 3, 1, 1}, "LINEAR");
  CHECK(at(linear, 0.5)[3] == 1.5);
  CHECK(at(linear, 9)[3] == 3);
  // x(t) = t^3 - t and y = 2 t^2 over 1 to 3: a cubic spline with their derivatives is exact. Tangents at the
  // ends that nothing uses are 99.
  const auto x = [](double t) { return t * t * t - t; };
  const File cubic =
      moving("translation", "VEC3", {1, 3},
             {99, 99, 99, x(1), 2, 0, 2, 4, 0, 26, 12, 0, x(3), 18, 0, 99, 99, 99}, "CUBICSPLINE");
  for (const double t : {1.0, 1.25, 2.0, 2.7, 3.0})
    CHECK(distance({at(cubic, t)[0], at(cubic, t)[1]}, {x(t), 2 * t * t}) < 1e-12);
  CHECK(at(cubic, 0)[0] == x(1));
  CHECK(at(cubic, 4)[0] == x(3));
  // Cubic rotations are made as long as 1: half way between z 0 and 180 degrees with flat tangents is 90.
  const File turn =
      moving("rotation", "VEC4", {0, 1},
             {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}, "CUBICSPLINE");
  CHECK(distance(at(turn, 0.5), {0, 0, 0, 0, 1, 0, -2, 0, 0}) < 1e-12);
  // From a rotation to its opposite: somewhere there is no direction.
  const File lost =
      moving("rotation", "VEC4", {0, 1},
             {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0}, "CUBICSPLINE");
  CHECK_THROWS_WITH(at(lost, 0.5),
                    "m.glb: /animations/0/channels/0: the rotation at 0.500000 s has no direction");
}

TEST_CASE("glTF: which animation, by index, by name, or the only one") {
  File file = moving("translation", "VEC3", {0, 1}, {0, 0, 0, 1, 0, 0}, "LINEAR");
  const auto why = [&](const gltf::AnimationChoice &choice) -> std::string {
    try {
      scene_of(file, choice);
      return "";
    } catch (const fvv::Error &error) {
      return error.what();
    }
  };
  json &animations = file.document["animations"];
  animations.push_back(animations[0]);
  animations[1]["name"] = "jump";
  CHECK(why(int64_t(1)) == "");
  CHECK(why(std::string("jump")) == "");
  CHECK(why(gltf::OnlyAnimation{}) ==
        "m.glb: /animations: expected the index or name of one of 2 animations: 0, \"jump\"");
  CHECK(why(int64_t(2)) == "m.glb: /animations: expected animation 2, found 2 (they count from 0)");
  CHECK(why(std::string("run")) ==
        "m.glb: /animations: expected an animation called \"run\", found 0, \"jump\"");
  animations[0]["name"] = "jump";
  CHECK(why(std::string("jump")) ==
        "m.glb: /animations: two animations are called \"jump\": name it by its index");
  file.document.erase("animations");
  CHECK(why(gltf::OnlyAnimation{}) == "m.glb: expected an animation, found none");
  CHECK(why(gltf::NoAnimation{}) == "");
}

TEST_CASE("a capture takes all meshes from one animated file, from several threads as from one") {
  const Folder folder;
  write_file(folder.path("50% tube.glb"), tube().glb());
  const Capture capture = folder.capture(R"({"file": "50% tube.glb", "start": "1/4"})");
  CHECK(capture.mesh_path(7) == folder.path("50% tube.glb"));
  const gltf::Scene scene = scene_of(tube());
  std::vector<Mesh> meshes(4);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < 4; i++)
    threads.emplace_back([&, i] { meshes[i] = load_mesh(capture, capture.frames.number(int64_t(i))); });
  for (std::thread &thread : threads) thread.join();
  for (size_t i = 0; i < 4; i++) {
    Numbers expected = gltf::pose(scene, 0.25 + double(i) * 0.25).positions;
    for (double &coordinate : expected) coordinate *= 0.01;
    CHECK(meshes[i].positions == expected);
    CHECK(meshes[i].faces == meshes[0].faces);
  }
  CHECK(meshes[0].positions != meshes[1].positions);
  // A part of the frames keeps its times.
  Capture part = capture;
  part.frames = {9, 1, 2};
  CHECK(load_mesh(part, 9).positions == meshes[2].positions);
  CHECK_THROWS_WITH(format_capture(folder.capture(R"({"file": "a.glb"})")),
                    folder.path("capture.json") +
                        ": expected a capture in metres to write, found 0.01 metres per unit");
}

TEST_CASE("an animated file is read before work starts, and frames after its end give a warning") {
  const Folder folder;
  write_file(folder.path("m.glb"), tube().glb());
  const auto findings = [&](const char *meshes, const char *frames) {
    return check_files(folder.capture(meshes, frames), nullptr);
  };
  const char *four = R"({"first": 0, "count": 4})", *eight = R"({"first": 10, "count": 8})";
  CHECK(findings(R"({"file": "m.glb"})", four).problems.empty());
  CHECK(findings(R"({"file": "m.glb", "start": "1/4"})", four).warnings.empty());
  CHECK(findings(R"({"file": "m.glb", "animation": 0})", eight).warnings ==
        std::vector<std::string>{
            "meshes: the animation ends at 1.000 s, the last 3 of 8 frames, from 15, repeat its end"});
  CHECK(findings(R"({"file": "m.glb", "animation": "x"})", four).problems ==
        std::vector<std::string>{"meshes: " + folder.path("m.glb") +
                                 ": /animations: expected an animation called \"x\", found 0"});
  CHECK(findings(R"({"file": "absent.glb"})", four).problems ==
        std::vector<std::string>{"meshes: " + folder.path("absent.glb") +
                                 ": cannot be opened: No such file or directory"});
}

TEST_CASE("capture.json names an animated file strictly, and is written as it was read") {
  const Folder folder;
  const auto why = [&](const char *meshes) -> std::string {
    try {
      folder.capture(meshes);
      return "";
    } catch (const fvv::Error &error) {
      return std::string(error.what()).substr(folder.path("capture.json").size() + 2);
    }
  };
  CHECK(why(R"({"file": "a.glb", "pattern": "%d.ply"})") ==
        "/meshes/pattern: unknown key, the nearest that is allowed here is \"start\"");
  CHECK(why(R"({"file": ""})") == "/meshes/file: expected a file name, found \"\"");
  CHECK(why(R"({"file": "a.glb", "start": "-1"})") ==
        "/meshes/start: expected seconds as an integer or as text such as \"3/2\", found \"-1\"");
  CHECK(why(R"({"file": "a.glb", "start": "1/0"})") ==
        "/meshes/start: expected seconds as an integer or as text such as \"3/2\", found \"1/0\"");
  CHECK(why(R"({"file": "a.glb", "animation": -1})") ==
        "/meshes/animation: expected an integer from 0 to 2147483647, found -1");
  CHECK(why(R"({"file": "a.glb", "animation": 1.5})") == "/meshes/animation: expected a string, found 1.5");
  CHECK(why(R"({"files": "a.glb"})") ==
        "/meshes/files: unknown key, the nearest that is allowed here is \"file\"");
  for (const char *animation : {R"(, "animation": 3)", R"(, "animation": "run")", ""}) {
    Capture capture =
        folder.capture((std::string(R"({"file": "a%d.glb", "start": "6/4")") + animation + "}").c_str());
    capture.metres_per_unit = 1;
    const std::string text = format_capture(capture);
    const Capture again = parse_capture(text, capture.path);
    CHECK(format_capture(again) == text);
    REQUIRE(again.animation);
    CHECK(again.animation->name == capture.animation->name);
    CHECK((again.animation->start.numerator == 3 && again.animation->start.denominator == 2));
    CHECK(again.mesh_path(5) == folder.path("a%d.glb"));
    capture.frames.first = 6;
    CHECK_THROWS_WITH(format_capture(capture),
                      capture.path +
                          ": expected a capture that begins with frame 5 as its animation does, found 6");
  }
}
