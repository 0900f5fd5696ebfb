// tools/capture: capture.json and the files that it names.
#include "fvv_catch.h"

#include "fvv_scene/capture.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

using namespace fvv::scene;
using nlohmann::json;

namespace {

const char *const good = R"({
  "fvv_capture": 1,
  "name": "players",
  "frame_rate": "30000/1001",
  "frames": {"first": 10, "count": 3, "step": 2},
  "units": "millimetres",
  "up": "-y",
  "lattice": {"origin": [-1, 0.5, 2e-3], "step": 0.002},
  "conventions": {"pixel_centre": 0},
  "meshes": {"pattern": "meshes/%04d.ply"},
  "cameras": [
    {"id": 7, "name": "left", "width": 480, "height": 270,
     "intrinsics": {"fx": 375.5, "fy": 376, "cx": 239.5, "cy": 134.25, "skew": 0.125},
     "lens": {"model": "radtan", "coefficients": [-0.1, 0.02, 0.001, -0.002, 0.003]},
     "rotation": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "translation": [100, -200.5, 3000],
     "pictures": "cam/%d%%.png", "masks": "/masks/%03d.png"},
    {"id": 8, "width": 640, "height": 480, "intrinsics": {"fx": 300, "fy": 300, "cx": 320, "cy": 240},
     "lens": {"model": "fisheye", "coefficients": [0.01, 0, 0, 0], "r_max": 1.25},
     "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 0, 0]}
  ]
})";

std::string complaint(const std::string &text) {
  try {
    parse_capture(text, "c.json");
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

// The loader's message if one value of the valid file is replaced; null removes it.
std::string with(const std::string &pointer, const std::string &value) {
  json document = json::parse(good);
  const json::json_pointer place(pointer);
  if (value.empty())
    document[place.parent_pointer()].erase(place.back());
  else
    document[place] = json::parse(value);
  return complaint(document.dump());
}

void check_identical(const fvv_camera &a, const fvv_camera &b) {
  CHECK(std::string(a.name, a.name_size) == std::string(b.name, b.name_size));
  fvv_camera copies[2] = {a, b};
  for (fvv_camera &copy : copies) copy.name = nullptr;
  const auto same = [&](const auto &x, const auto &y) { return !memcmp(&x, &y, sizeof x); };
  CHECK(
      (a.id == b.id && a.lens == b.lens && a.flags == b.flags && a.width == b.width && a.height == b.height));
  CHECK(
      (same(a.fx, b.fx) && same(a.fy, b.fy) && same(a.cx, b.cx) && same(a.cy, b.cy) && same(a.skew, b.skew)));
  CHECK(same(a.distortion, b.distortion));
  CHECK(same(a.r_max, b.r_max));
  CHECK(same(a.rotation, b.rotation));
  CHECK(same(a.translation, b.translation));
}

} // namespace

TEST_CASE("a capture.json gives cameras in metres with pixel centres at 0.5") {
  const Capture capture = parse_capture(good, "in/here/c.json");
  CHECK(capture.name == "players");
  CHECK(capture.frame_duration.numerator == 1001);
  CHECK(capture.frame_duration.denominator == 30000);
  CHECK(capture.frames.numbers() == std::vector<int64_t>{10, 12, 14});
  CHECK(capture.metres_per_unit == 0.001);
  CHECK(!capture.scale_unknown);
  CHECK(capture.up == FVV_UP_MINUS_Y);
  REQUIRE(capture.lattice);
  CHECK((capture.lattice->origin[0] == -1 && capture.lattice->origin[1] == 0.5)); // not scaled by the units
  CHECK((capture.lattice->origin[2] == 0.002 && capture.lattice->step == 0.002));
  REQUIRE(capture.cameras.size() == 2);
  const Camera copy = Capture(capture).cameras[0]; // outlives the capture that it was copied from
  const fvv_camera &left = copy.calibration;
  CHECK(left.id == 7);
  CHECK(std::string(left.name, left.name_size) == "left");
  CHECK(left.width == 480);
  CHECK(left.height == 270);
  CHECK((left.fx == 375.5 && left.fy == 376 && left.cx == 240 && left.cy == 134.75 && left.skew == 0.125));
  CHECK(left.lens == FVV_LENS_RADTAN);
  CHECK(left.distortion[0] == -0.1);
  CHECK(left.distortion[4] == 0.003);
  CHECK(left.distortion[5] == 0);
  CHECK(left.r_max == fvv_camera_r_max(&left));
  CHECK(left.rotation[5] == -1);
  CHECK(left.rotation[7] == 1);
  CHECK((left.translation[0] == 0.1 && left.translation[1] == -200.5 * 0.001 && left.translation[2] == 3));
  const fvv_camera &right = capture.cameras[1].calibration;
  CHECK(right.lens == FVV_LENS_FISHEYE);
  CHECK(right.r_max == 1.25);
  CHECK(right.cx == 320.5);
  CHECK(right.name_size == 0);
  CHECK(!capture.cameras[1].pictures);
  CHECK(capture.mesh_path(12) == "in/here/meshes/0012.ply");
  CHECK(capture.picture_path(copy, 14) == "in/here/cam/14%.png");
  CHECK(capture.mask_path(copy, 1234) == "/masks/1234.png");
}

TEST_CASE("units, axes and frame rates in all their spellings") {
  const auto load = [](const std::string &key, const std::string &value) {
    json document = json::parse(good);
    document[key] = json::parse(value);
    return parse_capture(document.dump(), "c.json");
  };
  for (const auto &[unit, metres] : std::map<std::string, double>{{"\"metres\"", 1},
                                                                  {"\"centimetres\"", 0.01},
                                                                  {"\"inches\"", 0.0254},
                                                                  {"\"feet\"", 0.3048},
                                                                  {"0.9144", 0.9144}}) {
    const Capture capture = load("units", unit);
    CHECK(capture.metres_per_unit == metres);
    CHECK(capture.cameras[0].calibration.translation[2] == 3000 * metres);
    CHECK(!capture.scale_unknown);
  }
  CHECK(load("units", "\"unknown\"").scale_unknown);
  CHECK(load("units", "\"unknown\"").cameras[0].calibration.translation[2] == 3000);
  const std::map<std::string, int> axes = {
      {"+x", FVV_UP_X},       {"+y", FVV_UP_Y},       {"+z", FVV_UP_Z},           {"-x", FVV_UP_MINUS_X},
      {"-y", FVV_UP_MINUS_Y}, {"-z", FVV_UP_MINUS_Z}, {"unknown", FVV_UP_UNKNOWN}};
  for (const auto &[text, up] : axes) CHECK(load("up", json(text).dump()).up == up);
  for (const char *rate : {"25", "\"25\"", "\"50/2\""}) {
    CHECK(load("frame_rate", rate).frame_duration.numerator == 1);
    CHECK(load("frame_rate", rate).frame_duration.denominator == 25);
  }
  CHECK(load("frame_rate", "\"1/4294967295\"").frame_duration.numerator == 4294967295u);
}

TEST_CASE("a faulty value is refused by its JSON pointer") {
  CHECK(with("/fvv_capture", "2") ==
        "c.json: /fvv_capture: expected version 1 of the capture description, found 2");
  CHECK(with("/fvv_capture", "") == R"(c.json: expected key "fvv_capture", found none)");
  CHECK(with("/framerate", "25") ==
        R"(c.json: /framerate: unknown key, the nearest that is allowed here is "frame_rate")");
  CHECK(with("/cameras/1/rotate~1d", "1") ==
        R"(c.json: /cameras/1/rotate~1d: unknown key, the nearest that is allowed here is "rotation")");
  CHECK(with("/name", "5") == "c.json: /name: expected a string, found 5");
  CHECK(with("/name", R"("a\u0000b")") == "c.json: /name: expected text without the character U+0000");
  const std::string rate =
      "c.json: /frame_rate: expected frames per second as an integer > 0 or as text such as "
      "\"30000/1001\", found ";
  for (const char *value : {"29.97", "0", "-25", "\"25/0\"", "\"0\"", "\"\"", "\"25/\"", "\"25 fps\"",
                            "\"+25\"", "\"4294967296\"", "null", "\"25/1/1\""})
    CHECK(with("/frame_rate", value) ==
          (value[0] == '0' || value[0] == '-'
               ? std::string("c.json: /frame_rate: expected an integer from 1 to 4294967295, found ") + value
               : rate + value));
  CHECK(with("/frame_rate", "") == R"(c.json: expected key "frame_rate", found none)");
  CHECK(with("/frames", "50") == "c.json: /frames: expected an object, found 50");
  CHECK(with("/frames/count", "0") ==
        "c.json: /frames/count: expected an integer from 1 to 10000000, found 0");
  CHECK(with("/frames/count", "2.0") ==
        "c.json: /frames/count: expected an integer from 1 to 10000000, found 2.0");
  CHECK(with("/frames/first", "18446744073709551615") ==
        "c.json: /frames/first: expected an integer from 0 to 2147483647, found 18446744073709551615");
  CHECK(with("/frames/step", "2147483647") ==
        "c.json: /frames: expected the last frame number to be at most 2147483647, found 4294967304");
  CHECK(with("/frames/steps", "5") ==
        R"(c.json: /frames/steps: unknown key, the nearest that is allowed here is "step")");
  const std::string units =
      "c.json: /units: expected metres, centimetres, millimetres, inches, feet, unknown or a "
      "number, found ";
  CHECK(with("/units", "\"meters\"") == units + "\"meters\"");
  CHECK(with("/units", "") == R"(c.json: expected key "units", found none)");
  CHECK(with("/units", "0") == "c.json: /units: expected a number > 0, found 0");
  CHECK(with("/units", "true") ==
        "c.json: /units: expected the name of a unit or metres per unit > 0, found true");
  CHECK(with("/up", "\"y\"") == "c.json: /up: expected +x, -x, +y, -y, +z, -z or unknown, found \"y\"");
  CHECK(with("/lattice", "") == "");
  CHECK(with("/lattice/step", "0") == "c.json: /lattice/step: expected a number > 0, found 0");
  CHECK(with("/lattice/origin", "") == R"(c.json: /lattice: expected key "origin", found none)");
  CHECK(with("/lattice/origin", "[0, 0]") == "c.json: /lattice/origin: expected 3 items, found 2");
  CHECK(with("/lattice/step", "1e301") == "c.json: /lattice: expected |origin| + step * 2^28 to be finite");
  CHECK(with("/conventions/pixel_centre", "1") ==
        "c.json: /conventions/pixel_centre: expected 0 or 0.5, found 1");
  CHECK(
      with("/conventions/pixel_center", "0") ==
      R"(c.json: /conventions/pixel_center: unknown key, the nearest that is allowed here is "pixel_centre")");
  CHECK(with("/meshes/pattern", "") == R"(c.json: /meshes: expected key "pattern", found none)");
  CHECK(with("/meshes/pattern", "\"\"") == "c.json: /meshes/pattern: expected a file name, found \"\"");
  const std::string percent =
      "c.json: /meshes/pattern: expected %d, %0Nd (N from 1 to 9) or %% after %, found ";
  for (const char *pattern : {"\"%s.ply\"", "\"%4d.ply\"", "\"%00d\"", "\"%010d\"", "\"%04i\"", "\"a%\"",
                              "\"%04\"", "\"%n%n\"", "\"% d\"", "\"%ld\""})
    CHECK(with("/meshes/pattern", pattern) == percent + pattern);
  CHECK(with("/meshes/pattern", "\"%d/%d.ply\"") ==
        "c.json: /meshes/pattern: expected one %d, not more, found \"%d/%d.ply\"");
  CHECK(with("/meshes/pattern", "\"%%d.ply\"").empty()); // one mesh for all frames
}

TEST_CASE("a faulty camera is refused by its JSON pointer") {
  CHECK(with("/cameras", "{}") == "c.json: /cameras: expected an array, found an object");
  CHECK(with("/cameras/0/id", "65535") ==
        "c.json: /cameras/0/id: expected an integer from 0 to 65534, found 65535");
  CHECK(with("/cameras/1/id", "7") ==
        "c.json: /cameras/1/id: expected an id of its own, found 7 as in /cameras/0");
  CHECK(with("/cameras/0/width", "-1") ==
        "c.json: /cameras/0/width: expected an integer from 1 to 4294967295, found -1");
  CHECK(with("/cameras/0/height", "\"270\"") ==
        "c.json: /cameras/0/height: expected an integer from 1 to 4294967295, found \"270\"");
  CHECK(with("/cameras/0/intrinsics/fx", "") ==
        R"(c.json: /cameras/0/intrinsics: expected key "fx", found none)");
  CHECK(with("/cameras/0/intrinsics/fy", "0") ==
        "c.json: /cameras/0/intrinsics/fy: expected a number > 0, found 0");
  CHECK(with("/cameras/0/intrinsics/cx", "[]") ==
        "c.json: /cameras/0/intrinsics/cx: expected a number, found an array");
  CHECK(with("/cameras/0/lens/model", "\"brown\"") ==
        "c.json: /cameras/0/lens/model: expected none, radtan or fisheye, found \"brown\"");
  CHECK(with("/cameras/0/lens/model", "\"none\"") ==
        "c.json: /cameras/0/lens/coefficients: expected no coefficients for none, found 5");
  CHECK(with("/cameras/0/lens/coefficients", "") ==
        R"(c.json: /cameras/0/lens: expected key "coefficients", found none)");
  CHECK(with("/cameras/0/lens/coefficients", "[1,2]") ==
        "c.json: /cameras/0/lens/coefficients: expected 4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6) coefficients for "
        "radtan, found 2");
  CHECK(with("/cameras/1/lens/coefficients", "[1,2,3,4,5]") ==
        "c.json: /cameras/1/lens/coefficients: expected 4 (k1 k2 k3 k4) coefficients for fisheye, found 5");
  CHECK(with("/cameras/1/lens/r_max", "0") ==
        "c.json: /cameras/1/lens/r_max: expected a number > 0, found 0");
  CHECK(with("/cameras/1/lens/r_max", "\"infinity\"") ==
        "c.json: /cameras/1/lens/r_max: expected a number, found \"infinity\"");
  CHECK(with("/cameras/0/rotation", "[[1,0,0],[0,1,0]]") ==
        "c.json: /cameras/0/rotation: expected 3 items, found 2");
  CHECK(with("/cameras/0/rotation/1", "[0,1]") == "c.json: /cameras/0/rotation/1: expected 3 items, found 2");
  CHECK(with("/cameras/0/rotation/1/2", "\"1\"") ==
        "c.json: /cameras/0/rotation/1/2: expected a number, found \"1\"");
  CHECK(with("/cameras/0/translation", "[0,0,0,1]") ==
        "c.json: /cameras/0/translation: expected 3 items, found 4");
  CHECK(with("/cameras/0/pictures", "") ==
        "c.json: /cameras/0/masks: expected pictures wherever there are masks");
  // What only a whole camera shows comes from fvv_camera_validate.
  for (const auto &[place, value] : std::map<std::string, std::string>{
           {"/cameras/0/rotation/0", "[-1,0,0]"},
           {"/cameras/0/rotation/1", "[0,0,-1.1]"},
           {"/cameras/0/lens", R"({"model": "radtan", "coefficients": [-0.4, 0, 0, 0], "r_max": 1})"}}) {
    const std::string what = with(place, value);
    INFO(what);
    CHECK(what.substr(0, 20) == "c.json: /cameras/0: ");
    CHECK(what.size() > 30);
  }
  json document = json::parse(good);
  document.erase("meshes");
  document["cameras"].erase(0);
  CHECK(complaint(document.dump()) ==
        "c.json: expected meshes, or pictures of at least one camera, found neither");
  document.erase("cameras");
  document["meshes"]["pattern"] = "%d.obj";
  CHECK(complaint(document.dump()).empty());
  for (int i = 0; i < 1025; i++) document["cameras"].push_back(0);
  CHECK(complaint(document.dump()) == "c.json: /cameras: expected at most 1024 cameras, found 1025");
}

TEST_CASE("malformed JSON is refused by line and column, equal keys by pointer") {
  CHECK(complaint("").substr(0, 22) == "c.json:1:1: not JSON: ");
  CHECK(complaint("{\n  \"a\" 1}").substr(0, 22) == "c.json:2:7: not JSON: ");
  CHECK(complaint("{\n  \"a\" 1}").find("expected ':'") != std::string::npos);
  CHECK(complaint("{\"a\": 1,\n\n }").substr(0, 22) == "c.json:3:2: not JSON: ");
  CHECK(complaint("{\"a\": 1e999}").substr(0, 23) == "c.json:1:11: not JSON: ");
  CHECK(complaint("{\"a\": nan}").substr(0, 22) == "c.json:1:8: not JSON: ");
  CHECK(complaint("{\"a\": \"\xff\"}").substr(0, 22) == "c.json:1:8: not JSON: ");
  CHECK(complaint("{} x").substr(0, 22) == "c.json:1:4: not JSON: ");
  CHECK(complaint("5") == "c.json: expected an object, found 5");
  CHECK(complaint("{\"a\": [0, {\"b/c\": 1, \"b/c\": 2}]}") ==
        "c.json: /a/1/b~1c: the key is repeated in its object");
  std::string pointer = "/a";
  for (int i = 0; i < 31; i++) pointer += "/0";
  CHECK(complaint("{\"a\": " + std::string(200000, '[')) ==
        "c.json: " + pointer + ": expected at most 32 arrays and objects inside one another");
}

TEST_CASE("no prefix of a capture.json is accepted, no mutation does harm") {
  const std::string text = good;
  for (size_t size = 0; size < text.size(); size++) CHECK(complaint(text.substr(0, size)) != "");
  CHECK(complaint(text) == "");
  std::mt19937 random(3);
  for (int round = 0; round < 3000; round++) {
    std::string bad = text;
    for (uint32_t changes = 1 + random() % 3; changes; changes--) {
      const size_t at = random() % bad.size();
      if (random() % 2)
        bad[at] = static_cast<char>(random() % 2 ? random() : "0123456789{}[],:\"-.e"[random() % 20]);
      else
        bad.erase(at, 1 + random() % 2);
    }
    const std::string what = complaint(bad);
    CHECK((what.empty() || what.compare(0, 7, "c.json:") == 0));
    CHECK(what.find('\n') == std::string::npos);
  }
}

TEST_CASE("writing and loading gives the same cameras bit for bit") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  Capture capture;
  capture.path = "c.json";
  capture.name = "a \"quoted\" n\xc3\xa4me\n";
  capture.frame_duration = {1001, 30000};
  capture.frames = {0, 1, 1};
  capture.up = FVV_UP_MINUS_Z;
  capture.lattice = Lattice{{-0.1, 1. / 3, -0.0}, 1e-3 / 3};
  capture.meshes = Pattern::parse("m%%/%05d.obj", nullptr);
  for (uint16_t i = 0; i < 200; i++) {
    Camera camera;
    fvv_camera &c = camera.calibration;
    c.id = i;
    c.lens = static_cast<uint8_t>(i % 3);
    c.width = 1920;
    c.height = 1080;
    c.fx = 1500 + number(random);
    c.fy = 1500 + number(random);
    c.cx = 960 + number(random);
    c.cy = i % 2 ? 1e22 : 9007199254740993.;
    c.cy = 540 + c.cy * 1e-20;
    c.skew = i % 5 ? number(random) * 1e-9 : -0.0;
    for (int k = 0; k < (i % 3 == 1 ? 8 : i % 3 == 2 ? 4 : 0); k++) c.distortion[k] = number(random) * 1e-3;
    const double angle = number(random);
    const double rotation[9] = {
        std::cos(angle), -std::sin(angle), -0.0, std::sin(angle), std::cos(angle), 0, 0, 0, 1};
    memcpy(c.rotation, rotation, sizeof rotation);
    for (double &t : c.translation) t = number(random) * 10;
    camera.set_name("camera " + std::to_string(i));
    c.r_max = i % 6 ? fvv_camera_r_max(&c) * 0.99 : std::numeric_limits<double>::infinity();
    if (i % 2) camera.pictures = Pattern::parse("p/%d.png", nullptr);
    if (i % 4 == 3) camera.masks = Pattern::parse("k/%d.png", nullptr);
    capture.cameras.push_back(camera);
  }
  const std::string text = format_capture(capture);
  const Capture again = parse_capture(text, "c.json");
  REQUIRE(again.cameras.size() == capture.cameras.size());
  for (size_t i = 0; i < capture.cameras.size(); i++) {
    check_identical(again.cameras[i].calibration, capture.cameras[i].calibration);
    CHECK(again.cameras[i].pictures.has_value() == (i % 2 == 1));
    CHECK(again.cameras[i].masks.has_value() == (i % 4 == 3));
  }
  CHECK(again.name == capture.name);
  CHECK(again.frame_duration.numerator == 1001);
  CHECK(again.frame_duration.denominator == 30000);
  CHECK(again.up == FVV_UP_MINUS_Z);
  REQUIRE(again.lattice);
  CHECK(memcmp(&*again.lattice, &*capture.lattice, sizeof(Lattice)) == 0);
  CHECK(again.mesh_path(3) == "m%/00003.obj");
  CHECK(format_capture(again) == text);
  capture.cameras[5].calibration.fx = std::nan("");
  CHECK_THROWS_WITH(format_capture(capture), "c.json: camera 5: fx is nan, expected a finite number above 0");
  capture.cameras.clear();
  capture.name = "\xff";
  CHECK_THROWS_WITH(format_capture(capture),
                    "expected UTF-8 to write into a capture description, found \"?\"");
  capture.name = "";
  capture.scale_unknown = true;
  CHECK(parse_capture(format_capture(capture), "c.json").scale_unknown);
  capture.metres_per_unit = 0.001;
  CHECK_THROWS_WITH(format_capture(capture),
                    "c.json: expected a capture in metres to write, found 0.001 metres per unit");
}
