// The capture folder: read back with other means than it was written with.
#include "fvv_catch.h"

#include "fvv_media/image.h"
#include "fvvsynth/capture_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <unistd.h>

using namespace fvv::synth;
namespace fs = std::filesystem;

namespace {

// A folder that goes with the test.
struct Scratch {
  fs::path path = fs::temp_directory_path() / ("fvv_capture_test_" + std::to_string(getpid()));
  Scratch() { fs::create_directories(path); }
  ~Scratch() { fs::remove_all(path); }
};

std::string contents(const fs::path &path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::map<std::string, std::string> write(const Settings &settings, uint32_t frames, const std::string &rate,
                                         uint32_t threads, const fs::path &to, Recording recording = {}) {
  Settings wanted = settings;
  wanted.threads = recording.threads = threads;
  recording.rate = parse_frame_rate(rate);
  recording.frames = frames;
  fvv::cli::OutputFolder folder(to.string(), false);
  write_capture(Scene(wanted), recording, folder);
  folder.commit();
  std::map<std::string, std::string> files;
  for (const auto &entry : fs::recursive_directory_iterator(to))
    if (entry.is_regular_file() && entry.path().filename() != ".fvv-output")
      files[fs::relative(entry.path(), to).string()] = contents(entry.path());
  return files;
}

struct Ply {
  std::vector<float> positions;
  std::vector<int32_t> faces;
};

Ply parse(const std::string &bytes) {
  const size_t body = bytes.find("end_header\n") + 11;
  const auto count = [&](const std::string &element) {
    return size_t(std::stoul(bytes.substr(bytes.find("element " + element) + 9 + element.size())));
  };
  Ply ply;
  ply.positions.resize(count("vertex") * 3);
  ply.faces.resize(count("face") * 3);
  REQUIRE(bytes.size() == body + ply.positions.size() * 4 + ply.faces.size() / 3 * 13);
  std::memcpy(ply.positions.data(), bytes.data() + body, ply.positions.size() * 4);
  const char *at = bytes.data() + body + ply.positions.size() * 4;
  for (size_t i = 0; i < ply.faces.size(); i += 3, at += 13) {
    REQUIRE(int(at[0]) == 3);
    std::memcpy(&ply.faces[i], at + 1, 12);
  }
  return ply;
}

// The silhouette by projecting many points of every face into a picture of six times the resolution.
std::vector<bool> silhouette(const Ply &mesh, const fvv_camera &camera) {
  constexpr int fine = 6;
  const int w = int(camera.width), h = int(camera.height);
  std::vector<bool> hit(size_t(w * h * fine * fine));
  for (size_t i = 0; i < mesh.faces.size(); i += 3) {
    const auto corner = [&](size_t c, int axis) {
      return double(mesh.positions[size_t(3 * mesh.faces[i + c] + axis)]);
    };
    // As many points that no fine pixel within the face goes without.
    double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
    for (size_t c = 0; c < 3; c++) {
      const double world[3] = {corner(c, 0), corner(c, 1), corner(c, 2)};
      double pixel[2];
      if (!fvv_camera_project(&camera, world, pixel, nullptr)) continue;
      for (int axis = 0; axis < 2; axis++) {
        low[axis] = std::min(low[axis], pixel[axis]);
        high[axis] = std::max(high[axis], pixel[axis]);
      }
    }
    const int steps =
        1 + int(fine * 1.2 * std::clamp(std::max(high[0] - low[0], high[1] - low[1]), 0.0, 50.0));
    for (int a = 0; a <= steps; a++)
      for (int b = 0; a + b <= steps; b++) {
        double world[3], pixel[2];
        for (int axis = 0; axis < 3; axis++)
          world[axis] =
              (corner(0, axis) * a + corner(1, axis) * b + corner(2, axis) * (steps - a - b)) / steps;
        if (!fvv_camera_project(&camera, world, pixel, nullptr)) continue;
        const int x = int(std::floor(pixel[0] * fine)), y = int(std::floor(pixel[1] * fine));
        if (x >= 0 && y >= 0 && x < w * fine && y < h * fine) hit[size_t(y * w * fine + x)] = true;
      }
  }
  std::vector<bool> covered(size_t(w * h));
  for (int y = 0; y < h; y++)
    for (int x = 0; x < w; x++) {
      int n = 0;
      for (int j = 0; j < fine; j++)
        for (int k = 0; k < fine; k++) n += hit[size_t((y * fine + j) * w * fine + x * fine + k)];
      covered[size_t(y * w + x)] = 2 * n >= fine * fine;
    }
  return covered;
}

fvv_camera read_camera(const nlohmann::json &json) {
  fvv_camera camera = {};
  camera.lens = FVV_LENS_NONE;
  camera.width = json["width"];
  camera.height = json["height"];
  camera.fx = json["intrinsics"]["fx"];
  camera.fy = json["intrinsics"]["fy"];
  camera.cx = json["intrinsics"]["cx"];
  camera.cy = json["intrinsics"]["cy"];
  camera.r_max = INFINITY;
  if (json["lens"]["model"] == "radtan") {
    camera.lens = FVV_LENS_RADTAN;
    for (size_t i = 0; i < 4; i++) camera.distortion[i] = json["lens"]["coefficients"][i];
    camera.r_max = json["lens"]["r_max"];
  }
  for (int i = 0; i < 9; i++) camera.rotation[i] = json["rotation"][size_t(i / 3)][size_t(i % 3)];
  for (int i = 0; i < 3; i++) camera.translation[i] = json["translation"][size_t(i)];
  return camera;
}

// A silhouette against the mask that was written, and the picture within the mask.
struct Overlap {
  size_t both = 0, either = 0;
  size_t grey = 0;  // values of the mask that are neither 0 nor 255
  double light = 0; // mean sample
  double share() const { return double(both) / double(either); }
};

Overlap compare(const std::vector<bool> &expected, const fvv::media::Image &mask,
                const fvv::media::Image &picture) {
  Overlap result;
  REQUIRE(mask.pixels.size() == expected.size());
  REQUIRE(picture.pixels.size() == expected.size() * 3);
  for (size_t i = 0; i < expected.size(); i++) {
    result.both += expected[i] && mask.pixels[i];
    result.either += expected[i] || mask.pixels[i];
    result.grey += mask.pixels[i] != 0 && mask.pixels[i] != 255;
    if (mask.pixels[i])
      result.light += picture.pixels[3 * i] + picture.pixels[3 * i + 1] + picture.pixels[3 * i + 2];
  }
  result.light /= 3 * double(result.both);
  return result;
}

} // namespace

TEST_CASE("a capture has the same bytes for any number of threads") {
  const Scratch scratch;
  Settings settings;
  settings.rig = RigKind::small;
  settings.cameras = 2;
  settings.width = 96;
  settings.height = 54;
  const auto one = write(settings, 3, "25", 1, scratch.path / "one"),
             three = write(settings, 3, "25", 3, scratch.path / "three");
  CHECK(one.size() == 1 + 3 + 2 * 2 * 3);
  CHECK(one == three);
}

TEST_CASE("hulls are the same for any number of threads, and their grid is written beside them") {
  const Scratch scratch;
  Settings settings;
  settings.rig = RigKind::small;
  settings.cameras = 3;
  settings.width = 96;
  settings.height = 54;
  Recording recording;
  recording.meshes = Meshes::hull;
  recording.hull_cells = 48;
  const auto one = write(settings, 2, "25", 1, scratch.path / "one", recording),
             three = write(settings, 2, "25", 3, scratch.path / "three", recording);
  CHECK(one == three);
  const auto grid = nlohmann::json::parse(one.at("hull.json"));
  CHECK(grid["cell"].get<double>() == Approx(0.1));
  CHECK(grid["dimensions"] == nlohmann::json({49, 25, 25}));
  const Ply mesh = parse(one.at("meshes/0001.ply"));
  REQUIRE(mesh.positions.size() > 300);
  // Each vertex lies on an edge of the grid: two of its coordinates are those of a grid point.
  size_t off = 0;
  for (size_t i = 0; i < mesh.positions.size(); i += 3) {
    int whole = 0;
    for (size_t axis = 0; axis < 3; axis++) {
      const double at = (double(mesh.positions[i + axis]) - grid["origin"][axis].get<double>()) / 0.1;
      whole += std::abs(at - std::round(at)) < 1e-5;
    }
    off += whole != 2;
  }
  CHECK(off == 0);
}

TEST_CASE("capture.json describes the folder, and meshes project onto masks", "[slow]") {
  const Scratch scratch;
  Settings settings;
  settings.rig = RigKind::small;
  settings.width = 480;
  settings.height = 270;
  settings.cameras = 2;
  const auto files = write(settings, 2, "30000/1001", 2, scratch.path / "capture");
  const auto json = nlohmann::json::parse(files.at("capture.json"));
  CHECK(json["fvv_capture"] == 1);
  CHECK(json["frame_rate"] == "30000/1001");
  CHECK(json["frames"] == nlohmann::json({{"first", 0}, {"count", 2}}));
  CHECK(json["units"] == "metres");
  CHECK(json["up"] == "+y");
  CHECK(json["conventions"]["pixel_centre"] == 0.5);
  CHECK(json["meshes"]["pattern"] == "meshes/%04d.ply");
  REQUIRE(json["cameras"].size() == 2);
  const Scene scene(settings);
  for (const int frame : {0, 1}) {
    const std::string number = frame == 0 ? "0000" : "0001";
    const Ply mesh = parse(files.at("meshes/" + number + ".ply"));
    for (const auto &entry : json["cameras"]) {
      const fvv_camera camera = read_camera(entry);
      const size_t id = entry["id"];
      CHECK(std::memcmp(camera.rotation, scene.cameras()[id].rotation, sizeof camera.rotation) ==
            0); // 17 digits
      CHECK(entry["pictures"] == "cam" + std::to_string(id) + "/%04d.png");
      CHECK(entry["masks"] == "cam" + std::to_string(id) + "/mask_%04d.png");
      const std::string folder = (scratch.path / "capture" / entry["name"].get<std::string>()).string() + "/";
      const auto mask = fvv::media::read_image(folder + "mask_" + number + ".png", 1);
      const auto picture = fvv::media::read_image(folder + number + ".png", 3);
      const Overlap overlap = compare(silhouette(mesh, camera), mask, picture);
      INFO("camera " << id << " frame " << frame << ": " << overlap.both << " of " << overlap.either);
      CHECK(overlap.grey == 0);
      CHECK(overlap.either > 5000);
      CHECK(overlap.share() > 0.97);
      CHECK(overlap.light > 40); // not black
    }
  }
}

TEST_CASE("in the studio meshes project onto masks through the lenses, and not without them", "[nightly]") {
  const Scratch scratch;
  Settings settings;
  settings.rig = RigKind::studio;
  settings.width = 960;
  settings.height = 540;
  const auto files = write(settings, 1, "25", 2, scratch.path / "capture");
  const auto json = nlohmann::json::parse(files.at("capture.json"));
  const Ply mesh = parse(files.at("meshes/0000.ply"));
  REQUIRE(json["cameras"].size() == 13);
  int lenses = 0;
  for (const auto &entry : json["cameras"]) {
    fvv_camera camera = read_camera(entry);
    fvv_diagnostic diagnostic = {};
    REQUIRE(fvv_camera_validate(&camera, &diagnostic) == FVV_OK);
    const std::string folder = (scratch.path / "capture" / entry["name"].get<std::string>()).string() + "/";
    const auto mask = fvv::media::read_image(folder + "mask_0000.png", 1),
               picture = fvv::media::read_image(folder + "0000.png", 3);
    REQUIRE(mask.width == camera.width);
    REQUIRE(mask.height == camera.height);
    const Overlap overlap = compare(silhouette(mesh, camera), mask, picture);
    INFO(entry["name"] << ": " << overlap.both << " of " << overlap.either);
    CHECK(overlap.either > 3000);
    CHECK(overlap.share() > 0.97);
    lenses += camera.lens == FVV_LENS_RADTAN;
    if (std::abs(camera.distortion[0]) < 0.1) continue;
    camera.lens = FVV_LENS_NONE;
    camera.r_max = INFINITY;
    CHECK(compare(silhouette(mesh, camera), mask, picture).share() < overlap.share() - 0.005);
  }
  CHECK(lenses == 7);
}

TEST_CASE("the camera that moves is described frame by frame, and its pictures are those of the frame",
          "[long]") {
  const Scratch scratch;
  Settings settings;
  settings.width = 480;
  settings.height = 270;
  const auto files = write(settings, 3, "1", 2, scratch.path / "capture"); // at 0, 1 and 2 s
  const auto json = nlohmann::json::parse(files.at("capture.json"));
  const Scene scene(settings);
  int moving = 0;
  for (const auto &entry : json["cameras"]) {
    CHECK(entry.value("texture", true) == (entry["name"] != "overhead"));
    if (!entry.contains("per_frame")) continue;
    moving++;
    REQUIRE(entry["per_frame"].size() == 3);
    double widest = 1e9, longest = 0, place[3][3];
    for (size_t frame = 0; frame < 3; frame++) {
      nlohmann::json own = entry;
      own.update(entry["per_frame"][frame]);
      CHECK(own["frame"] == frame);
      const fvv_camera camera = read_camera(own), first = read_camera(entry);
      fvv_diagnostic diagnostic = {};
      REQUIRE(fvv_camera_validate(&camera, &diagnostic) == FVV_OK);
      widest = std::min(widest, camera.fx);
      longest = std::max(longest, camera.fx);
      fvv_camera_centre(&camera, place[frame]);
      const std::string number = "000" + std::to_string(frame),
                        folder = (scratch.path / "capture" / entry["name"].get<std::string>()).string() + "/";
      const Ply mesh = parse(files.at("meshes/" + number + ".ply"));
      const auto mask = fvv::media::read_image(folder + "mask_" + number + ".png", 1),
                 picture = fvv::media::read_image(folder + number + ".png", 3);
      const Overlap overlap = compare(silhouette(mesh, camera), mask, picture);
      INFO("frame " << frame << ": " << overlap.both << " of " << overlap.either);
      CHECK(overlap.share() > 0.97);
      if (frame > 0) CHECK(compare(silhouette(mesh, first), mask, picture).share() < 0.7);
      const Vec3 ball = scene.action().ball_position(double(frame));
      const double world[3] = {ball.x, ball.y, ball.z};
      double pixel[2];
      REQUIRE(fvv_camera_project(&camera, world, pixel, nullptr) == 1);
      CHECK(mask.pixels[size_t(pixel[1]) * 480 + size_t(pixel[0])] == 255);
    }
    CHECK(longest / widest > 1.5);
    for (size_t frame = 1; frame < 3; frame++)
      for (size_t axis = 0; axis < 3; axis++)
        CHECK(place[frame][axis] == Approx(place[0][axis]).margin(1e-9));
  }
  CHECK(moving == 1);
}

TEST_CASE("pictures with all that makes them real have the same bytes for any number of threads",
          "[nightly]") {
  const Scratch scratch;
  Settings settings;
  settings.width = 96;
  settings.height = 54;
  Recording recording;
  recording.realism = {1, 0.3, 0.5, true};
  const auto one = write(settings, 3, "25", 1, scratch.path / "one", recording),
             three = write(settings, 3, "25", 3, scratch.path / "three", recording);
  CHECK(one == three);
  const auto plain = write(settings, 1, "25", 2, scratch.path / "plain");
  for (const auto &[name, bytes] : plain) {
    INFO(name);
    const bool picture = name.find("/0000.png") != std::string::npos;
    if (name != "capture.json") CHECK((one.at(name) != bytes) == picture); // masks and meshes stay
  }
}

TEST_CASE("frame rates are numbers or fractions in lowest terms") {
  CHECK(parse_frame_rate("25").numerator == 25);
  CHECK(parse_frame_rate("25").denominator == 1);
  CHECK(parse_frame_rate("30000/1001").denominator == 1001);
  CHECK(parse_frame_rate("50/2").numerator == 25);
  for (const char *bad : {"", "0", "25/", "/2", "25/0", "2.5", "-1", "25/1/1", "5000000000", " 25"}) {
    INFO(bad);
    CHECK_THROWS_AS(parse_frame_rate(bad), fvv::Error);
  }
}
