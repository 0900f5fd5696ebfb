// fvv_scene: the files that a capture names are checked before any work starts.
#include "fvv_catch.h"

#include "fvv_cxx/input_file.h"
#include "fvv_scene/capture.h"

#include <filesystem>
#include <functional>
#include <map>
#include <sys/stat.h>
#include <unistd.h>

using namespace fvv::scene;
namespace fs = std::filesystem;

namespace {

// Pictures of these tests are text: "WIDTH HEIGHT".
PictureSize probe(const std::string &path) {
  const std::string text = read_file(path, 100);
  PictureSize size;
  if (sscanf(text.c_str(), "%u %u", &size.width, &size.height) != 2)
    throw fvv::Error(path + ": is no picture");
  return size;
}

// Two cameras with five frames each, all files there.
struct Folder {
  const fs::path root = fs::temp_directory_path() / ("fvv_capture_check_test_" + std::to_string(getpid()));
  Capture capture;

  Folder() {
    fs::remove_all(root);
    capture.path = (root / "capture.json").string();
    capture.frames = {10, 5, 2};
    capture.meshes = pattern("meshes/%04d.ply");
    for (uint16_t i = 0; i < 2; i++) {
      Camera camera;
      camera.calibration.id = static_cast<uint16_t>(3 + i);
      camera.calibration.width = 480;
      camera.calibration.height = 270;
      camera.pictures = pattern(i ? "frames/%04d/b.png" : "a_%d.png");
      if (i) camera.masks = pattern("frames/%04d/mask.png");
      capture.cameras.push_back(camera);
    }
    for (const int64_t frame : capture.frames.numbers()) {
      write(capture.meshes->file(frame), "mesh");
      for (const Camera &camera : capture.cameras) write(camera.pictures->file(frame), "480 270");
      write(capture.cameras[1].masks->file(frame), "480 270");
    }
  }
  ~Folder() { fs::remove_all(root); }

  static std::optional<Pattern> pattern(const char *text) {
    std::string what;
    return Pattern::parse(text, &what);
  }
  void write(const std::string &file, const std::string &text) const {
    fs::create_directories((root / file).parent_path());
    write_file((root / file).string(), text);
  }
};

using Sentences = std::vector<std::string>;

} // namespace

TEST_CASE("a complete capture gives neither problem nor warning") {
  const Folder folder;
  const Findings findings = check_files(folder.capture, probe);
  CHECK(findings.problems == Sentences{});
  CHECK(findings.warnings == Sentences{});
  CHECK(findings.unused == Sentences{});
}

TEST_CASE("all missing, empty, unreadable and unlike files are reported at once, in order") {
  const Folder folder;
  fs::remove(folder.root / "a_12.png");
  fs::remove(folder.root / "a_18.png");
  folder.write("a_10.png", "960 540");
  folder.write("meshes/0014.ply", "");
  folder.write("frames/0016/b.png", "JFIF");
  fs::remove(folder.root / "frames/0018/mask.png");
  fs::create_directory(folder.root / "frames/0018/mask.png");
  folder.write("frames/0010/mask.png", "480 271");
  const Findings findings = check_files(folder.capture, probe);
  CHECK(findings.problems ==
        Sentences{
            "1 of 5 meshes is empty, first: meshes/0014.ply",
            "camera 3: 2 of 5 pictures are missing: 12, 18 (first: a_12.png)",
            "camera 3: 1 of 5 pictures is not 480 x 270, first: a_10.png is 960 x 540",
            "camera 4: 1 of 5 pictures is unreadable, first: " +
                (folder.root / "frames/0016/b.png").string() + ": is no picture",
            "camera 4: 1 of 5 masks is unreadable, first: frames/0018/mask.png: is a folder",
            "camera 4: 1 of 5 masks is not 480 x 270, first: frames/0010/mask.png is 480 x 271"
            " (cut or padded? state \"place\": [x, y] with the pixel of the calibrated picture at which it "
            "begins, [0, 0] if it was cut or padded at the right and at the bottom)"});
  CHECK(findings.warnings == Sentences{});
  // Without a probe sizes are not checked.
  CHECK(check_files(folder.capture, nullptr).problems.size() == 3);
}

TEST_CASE("gaps are named as ranges, the first eight of them") {
  Folder folder;
  folder.capture.cameras.clear();
  folder.capture.frames = {1, 50, 1};
  const auto missing = [&](const std::function<bool(int64_t)> &gone) {
    for (const int64_t frame : folder.capture.frames.numbers()) {
      const std::string file = folder.capture.meshes->file(frame);
      folder.write(file, "mesh");
      if (gone(frame)) fs::remove(folder.root / file);
    }
    const Sentences problems = check_files(folder.capture, probe).problems;
    return problems.empty() ? "" : problems.at(0);
  };
  CHECK(missing([](int64_t i) { return i == 3 || (i >= 17 && i <= 27); }) ==
        "12 of 50 meshes are missing: 3, 17 to 27 (first: meshes/0003.ply)");
  CHECK(missing([](int64_t i) { return i >= 49; }) ==
        "2 of 50 meshes are missing: 49 to 50 (first: meshes/0049.ply)");
  const auto odd = [](int64_t most) { return [most](int64_t i) { return i % 2 && i <= most; }; };
  CHECK(missing(odd(15)) == "8 of 50 meshes are missing: 1, 3, 5, 7, 9, 11, 13, 15 (first: meshes/0001.ply)");
  CHECK(missing(odd(17)) ==
        "9 of 50 meshes are missing: 1, 3, 5, 7, 9, 11, 13, 15, ... (first: meshes/0001.ply)");
  // Neighbours are those of the capture: 1, 4, 7 follow one another in steps of 3.
  folder.capture.frames = {1, 10, 3};
  CHECK(missing([](int64_t i) { return i <= 7 || i == 16; }) ==
        "4 of 10 meshes are missing: 1 to 7, 16 (first: meshes/0001.ply)");
}

TEST_CASE("frames around the chosen ones are warned of, frames between them are not") {
  const Folder folder;
  folder.write("meshes/0011.ply", "between");
  folder.write("meshes/00019.ply", "not by this pattern");
  folder.write("meshes/0020.txt", "not by this pattern");
  folder.write("a_9.png", "480 270");
  folder.write("a_20.png", "480 270");
  folder.write("a_100.png", "480 270");
  folder.write("frames/0003/b.png", "480 270");
  const Findings findings = check_files(folder.capture, probe);
  CHECK(findings.problems == Sentences{});
  CHECK(findings.unused ==
        Sentences{"camera 3: pictures reach from frame 9 to 100, the capture takes 10 to 18 (3 not used)",
                  "camera 4: pictures reach from frame 3 to 18, the capture takes 10 to 18 (1 not used)"});
}

TEST_CASE("a folder that is not there, a single file and shared pictures") {
  Folder folder;
  folder.capture.meshes = Folder::pattern("nowhere/%d.ply");
  folder.capture.cameras[1].pictures = folder.capture.cameras[0].pictures;
  CHECK(check_files(folder.capture, probe).problems ==
        Sentences{"5 of 5 meshes are missing: 10 to 18 (first: nowhere/10.ply)",
                  "camera 4: has the pictures of camera 3: a_%d.png"});
  folder.capture.frames = {0, 1, 1};
  folder.capture.cameras.clear();
  folder.capture.meshes = Folder::pattern("meshes/0010.ply");
  CHECK(check_files(folder.capture, probe).problems == Sentences{});
  CHECK(check_files(folder.capture, probe).unused == Sentences{});
}

TEST_CASE("meshes of a capture come in metres, a written capture loads from its file") {
  Folder folder;
  folder.write("meshes/0010.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\n"
                                  "property int z\nelement face 1\nproperty list int int vertex_index\n"
                                  "end_header\n0 0 0\n254 0 0\n0 127 0\n3 0 1 2\n");
  folder.capture.cameras.clear();
  write_capture(folder.capture, folder.capture.path);
  Capture capture = load_capture(folder.capture.path);
  CHECK(capture.frames.numbers() == folder.capture.frames.numbers());
  capture.metres_per_unit = 0.0254;
  CHECK(load_mesh(capture, 10).positions ==
        std::vector<double>{0, 0, 0, 254 * 0.0254, 0, 0, 0, 127 * 0.0254, 0});
  const std::string absent = (folder.root / "absent.json").string();
  CHECK_THROWS_WITH(load_capture(absent), absent + ": cannot be opened: No such file or directory");
}

TEST_CASE("Exif orientation is a warning unless rotate is stated, which swaps the sides") {
  Folder folder;
  const auto turned = [](const std::string &path) {
    PictureSize size = probe(path);
    if (path.find("a_") != path.npos) size = {270, 480, 6};
    return size;
  };
  folder.capture.cameras[0].pictures->rotate = 90;
  CHECK(check_files(folder.capture, turned).problems == Sentences{});
  CHECK(check_files(folder.capture, turned).warnings == Sentences{});
  folder.capture.cameras[0].pictures->rotate.reset();
  CHECK(check_files(folder.capture, turned).warnings ==
        Sentences{"camera 3: 5 of 5 pictures are turned by their Exif orientation, which is ignored unless "
                  "\"rotate\" is stated, first: a_10.png has orientation 6"});
}

TEST_CASE("a video is refused where it is missing, is none, or has another size") {
  Folder folder;
  VideoSource video;
  video.file = "a.mp4";
  video.first = 10;
  folder.capture.cameras[0].pictures = video;
  const auto found = [&](const VideoProbe &video_probe) {
    return check_files(folder.capture, probe, video_probe).problems;
  };
  const VideoFacts facts = {480, 270, 90, {{1, 25}, {0, 1, 2, 3, 4}}, {}, {}};
  CHECK(found({}) == Sentences{"camera 3: pictures a.mp4: is missing"});
  folder.write("a.mp4", "video");
  CHECK(found([](const auto &, auto) -> VideoFacts { throw fvv::Error("a.mp4: is no video"); }) ==
        Sentences{"camera 3: pictures: a.mp4: is no video"});
  CHECK(found([&](const auto &, auto) { return facts; }) ==
        Sentences{"camera 3: pictures a.mp4: is 270 x 480, turned by 90 degrees, the camera is 480 x 270"
                  " (turned? state \"rotate\": 90 or 270)"});
  folder.capture.cameras[0].pictures->rotate = 0;
  CHECK(found([&](const auto &, auto) { return facts; }) == Sentences{});
}

TEST_CASE("videos and turned stills are read and written") {
  const std::string text = R"({"fvv_capture": 1, "frame_rate": 25, "frames": {"first": 3, "count": 2},
    "units": "metres", "cameras": [{"id": 1, "width": 4, "height": 4,
    "intrinsics": {"fx": 1, "fy": 1, "cx": 2, "cy": 2}, "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "translation": [0, 0, 0], "pictures": )";
  const auto source = [&](const std::string &value) {
    return parse_capture(text + value + "}]}", "c.json").cameras[0].pictures.value();
  };
  const Capture capture =
      parse_capture(text + R"({"video": "a%d.mp4", "stream": 2, "start": "-6/4", "place": [0, -2]}, )"
                           R"("masks": {"pattern": "%d.png", "rotate": 270, "place": [3, 0]}}]})",
                    "c.json");
  const Capture again = parse_capture(format_capture(capture), "c.json");
  for (const Capture &one : {capture, again}) {
    const VideoSource &video = *one.cameras[0].pictures->video;
    CHECK((video.file == "a%d.mp4" && video.stream == 2u && video.first == 3));
    CHECK((video.start.numerator == -3 && video.start.denominator == 2));
    CHECK(!one.cameras[0].pictures->rotate);
    CHECK((one.cameras[0].masks->pattern->text() == "%d.png" && one.cameras[0].masks->rotate == 270));
    const Placement in_pictures = one.cameras[0].pictures->place.value(),
                    in_masks = one.cameras[0].masks->place.value();
    CHECK(
        (in_pictures.x == 0 && in_pictures.y == -2 && in_pictures.width == one.cameras[0].calibration.width));
    CHECK((in_masks.x == 3 && in_masks.y == 0 && in_masks.height == one.cameras[0].calibration.height));
  }
  CHECK(source(R"({"video": "v", "start": -2, "rotate": 0})").video->start.numerator == -2);
  const std::string place = "c.json: /cameras/0/pictures";
  for (const auto &[value, message] : std::map<std::string, std::string>{
           {"3", ": expected a pattern as text, or an object with a pattern or a video, found 3"},
           {R"({"video": "v", "rotate": 45})", "/rotate: expected 0, 90, 180 or 270, found 45"},
           {R"({"video": ""})", "/video: expected a file name, found \"\""},
           {R"({"video": "v", "place": [1]})", "/place: expected 2 items, found 1"},
           {R"({"video": "v", "place": [0, 0.5]})",
            "/place/1: expected an integer from -65535 to 65535, found 0.5"},
           {R"({"video": "v", "start": "--1"})",
            "/start: expected seconds as an integer or as text such as \"3/2\" or \"-3/2\", found \"--1\""}})
    CHECK_THROWS_WITH(source(value), place + message);
}

TEST_CASE("stills may be counted from another number than frames") {
  const Pattern plain = Pattern::parse("a/%03d.png", nullptr).value();
  Pattern pattern = plain;
  pattern.offset = 3;
  CHECK(pattern.file(10) == "a/013.png");
  CHECK(pattern.frame("a/013.png") == 10);
  CHECK(!pattern.frame("a/002.png")); // of no frame
  pattern.offset = -3;
  CHECK((pattern.file(10) == "a/007.png" && pattern.frame("a/000.png") == 3));
  const std::string text = R"({"fvv_capture": 1, "frame_rate": 25, "frames": {"first": 3, "count": 2},
    "units": "metres", "cameras": [{"id": 1, "width": 4, "height": 4,
    "intrinsics": {"fx": 1, "fy": 1, "cx": 2, "cy": 2}, "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "translation": [0, 0, 0], "pictures": )";
  const auto parse = [&](const std::string &value) { return parse_capture(text + value + "}]}", "c.json"); };
  const Capture again =
      parse_capture(format_capture(parse(R"({"pattern": "%d.png", "offset": -3})")), "c.json");
  CHECK(again.cameras[0].pictures->file(4) == "1.png");
  CHECK_THROWS_WITH(
      parse(R"({"pattern": "%d.png", "offset": -4})"),
      "c.json: /cameras/0/pictures/offset: expected at least -3, because frame 3 has no file otherwise, "
      "found -4");
  CHECK_THROWS_WITH(parse(R"({"video": "v", "offset": 1})"), Catch::Contains("offset"));
}

TEST_CASE("an atlas picture for all frames is one file") {
  Folder folder;
  folder.capture.atlas = Atlas{folder.pattern("atlas.png").value(), {}};
  CHECK(check_files(folder.capture, probe).problems ==
        Sentences{"atlas: 1 of 1 pictures is missing, first: atlas.png"});
  folder.write("atlas.png", "");
  CHECK(check_files(folder.capture, probe).problems ==
        Sentences{"atlas: 1 of 1 pictures is empty, first: atlas.png"});
  folder.write("atlas.png", "64 32");
  folder.write("atlas2.png", "64 31");
  const Findings findings = check_files(folder.capture, probe);
  CHECK((findings.problems.empty() && findings.warnings.empty() && findings.unused.empty()));
}

TEST_CASE("atlas pictures have one size, whichever way they are turned") {
  Folder folder;
  folder.capture.atlas = Atlas{folder.pattern("atlas_%d.png").value(), {}};
  for (const int64_t frame : folder.capture.frames.numbers())
    folder.write("atlas_" + std::to_string(frame) + ".png", "64 32");
  folder.capture.atlas->pictures->rotate = 90;
  CHECK(check_files(folder.capture, probe).problems == Sentences{});
  folder.write("atlas_14.png", "32 64");
  CHECK(check_files(folder.capture, probe).problems ==
        Sentences{"atlas: 1 of 5 pictures is not 64 x 32, first: atlas_14.png is 32 x 64"
                  " (turned? state \"rotate\": 90 or 270)"});
}

TEST_CASE("folders, pipes and files without permission are called what they are") {
  Folder folder;
  const auto replace = [&](const char *file) {
    fs::remove(folder.root / file);
    return (folder.root / file).string();
  };
  fs::create_directory(replace("meshes/0012.ply"));
  REQUIRE(mkfifo(replace("a_10.png").c_str(), 0600) == 0);
  fs::create_symlink("nowhere", replace("a_18.png"));
  VideoSource video;
  video.file = "frames";
  folder.capture.cameras[1].masks = video;
  folder.capture.environment.emplace().file = "meshes";
  Sentences expected = {"1 of 5 meshes is unreadable, first: meshes/0012.ply: is a folder",
                        "camera 3: 1 of 5 pictures is missing: 18 (first: a_18.png)",
                        "camera 3: 1 of 5 pictures is unreadable, first: a_10.png: is a pipe",
                        "camera 4: masks frames: is a folder", "environment: meshes: is a folder"};
  if (geteuid() != 0) { // root may read everything
    fs::permissions(folder.root / "frames/0012/b.png", fs::perms::none);
    expected.insert(expected.begin() + 3,
                    "camera 4: 1 of 5 pictures is unreadable, first: frames/0012/b.png: permission denied");
  }
  CHECK(check_files(folder.capture, probe).problems == expected);
  const std::string pipe = (folder.root / "a_10.png").string(), meshes = (folder.root / "meshes").string();
  CHECK_THROWS_WITH(read_file(pipe, 1), pipe + ": is a pipe, expected a file");
  CHECK_THROWS_WITH(fvv::InputFile(pipe), pipe + ": is a pipe, expected a file");
  CHECK_THROWS_WITH(fvv::InputFile(meshes), meshes + ": is a folder, expected a file");
}

TEST_CASE("a wrong number of frames costs no time: the check stops after a hundred faults of a sequence") {
  Folder folder;
  folder.capture.frames.count = 1'000'000;
  folder.capture.cameras.pop_back();
  int probes = 0;
  const auto counting = [&](const std::string &path) {
    probes++;
    return probe(path);
  };
  CHECK(check_files(folder.capture, counting).problems ==
        Sentences{"at least 100 of 1000000 meshes are missing: 20 to 218 (first: meshes/0020.ply)",
                  "camera 3: at least 100 of 1000000 pictures are missing: 20 to 218 (first: a_20.png)"});
  CHECK(probes == 0);
}
