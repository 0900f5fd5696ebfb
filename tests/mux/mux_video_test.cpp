// fvvmux: captures whose pictures are videos.
#include "mux_fixture.h"

#include "make_video.h"
#include "scene/src/video/video_match.h"

#include <nlohmann/json.hpp>

namespace {

// Two cameras of 64 x 48 with a video each, clip for both; 20 frames of 30 a second, from number 100 in steps
// of 5.
struct Scene {
  Folder folder;
  scene::Capture capture;

  explicit Scene(const Clip &clip, const char *name = "a.mp4",
                 std::vector<std::array<uint32_t, 2>> sizes = {{64, 48}, {64, 48}}) {
    Shape shape;
    shape.first = 100;
    shape.count = 20;
    shape.step = 5;
    shape.duration = {1, 30};
    shape.sizes = sizes;
    capture = make_capture(folder, shape);
    for (size_t k = 0; k < 2; k++) {
      scene::VideoSource video;
      video.file = std::to_string(k) + name;
      video.first = 100;
      write_video(folder.path("in/" + video.file), clip);
      capture.cameras[k].pictures = video;
    }
  }
  scene::VideoSource &video(size_t k) { return *capture.cameras[k].pictures->video; }
  // Writes capture.json, packs, and returns which picture each frame shows at a corner of each camera's tile.
  std::vector<std::vector<int>> numbers(mux::Report &summary, uint32_t x, uint32_t y, unsigned threads = 2) {
    scene::write_capture(capture, capture.path);
    FileOptions options = options_for(folder);
    options.quality = {false, 4};
    options.verify = true;
    options.threads = threads;
    summary = mux_file(options);
    Stream stream(options.output);
    std::vector<std::vector<int>> out;
    for (const media::Image &image : stream.pictures()) {
      out.emplace_back();
      for (size_t k = 0; k < 2; k++)
        out.back().push_back(
            number_in(media::extract(image, stream.configuration().videos[0].tiles[k]), x, y));
    }
    return out;
  }
};

} // namespace

TEST_CASE("every frame gets its own picture of a video with B-frames, with any number of threads") {
  Clip clip;
  clip.times = steady(40, 3000);
  clip.b_frames = 3;
  Scene scene(clip);
  scene.video(1).start = {1, 3};
  mux::Report summary;
  const auto numbers = scene.numbers(summary, 60, 44);
  REQUIRE(numbers.size() == 20);
  for (int i = 0; i < 20; i++) CHECK(numbers[size_t(i)] == std::vector<int>{i, i + 10});
  const std::string bytes = read_bytes(scene.folder.path("out.fvv"));
  scene.numbers(summary, 60, 44, 5);
  CHECK(read_bytes(scene.folder.path("out.fvv")) == bytes);
  REQUIRE(summary.sources.size() == 2);
  const mux::SourceReport &report = summary.sources[1];
  CHECK((report.met == 20 && report.unmet.empty() && report.used_again == 0 && report.constant_rate));
  CHECK((report.before == 10 && report.between == 0 && report.behind == 10));
  CHECK(std::fabs(report.largest_offset) < 1e-9);
}

TEST_CASE("dropped pictures and offsets are reported with the frames that they concern") {
  Clip clip;
  // 30 a second, 1 ms late but for the first; pictures 5 to 7 were never taken.
  for (int i = 0; i < 20; i++)
    if (i < 5 || i > 7) clip.times.push_back(i * 3000 + (i ? 90 : 0));
  Scene scene(clip);
  mux::Report summary;
  const auto numbers = scene.numbers(summary, 60, 44);
  const std::vector<int> expected = {0, 1, 2, 3, 4, 4, 4, 5, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
  for (size_t i = 0; i < 20; i++) CHECK(numbers[i][0] == expected[i]);
  const mux::SourceReport &report = summary.sources[0];
  CHECK((report.pictures == 17 && report.met == 17 && !report.constant_rate && report.used_again == 3));
  REQUIRE(report.unmet.size() == 1);
  CHECK((report.unmet[0].first == 125 && report.unmet[0].last == 135));
  CHECK(std::fabs(report.largest_offset - 0.001) < 1e-9);
  CHECK(std::fabs(report.mean_offset - 0.016 / 17) < 1e-9);
  CHECK(summary.warned);
  const ToolResult run =
      run_tool({scene.capture.path, "-o", scene.folder.path("x.fvv"), "--quality", "30", "--json"});
  CHECK(run.exit == 3);
  CHECK(run.err.find(
            "camera 3: pictures 0a.mp4: 3 of 20 frames have no picture within half a frame and take the "
            "nearest: 125 to 135\n") != run.err.npos);
  CHECK(nlohmann::json::parse(run.out)["sources"][0]["unmet"] == nlohmann::json::parse("[[125, 135]]"));
}

TEST_CASE("offsets that are all alike suggest a start") {
  Clip clip;
  clip.times = steady(40, 3000);
  Scene scene(clip);
  scene.video(0).start = {1, 100};
  mux::Report summary;
  scene.numbers(summary, 60, 44);
  const mux::SourceReport &report = summary.sources[0];
  REQUIRE(report.better_start);
  CHECK((report.better_start->numerator == 0 && report.better_start->denominator == 1));
  CHECK(std::fabs(report.mean_offset + 0.01) < 1e-9);
  CHECK(!summary.sources[1].better_start);
}

TEST_CASE("pictures that were cut are put in their place in the calibrated picture") {
  Clip clip;
  clip.times = steady(20, 3000);
  Scene scene(clip, "a.mp4", {{64, 48}, {72, 40}});
  const ToolResult refused = [&] {
    scene::write_capture(scene.capture, scene.capture.path);
    return run_tool({scene.capture.path, "-o", scene.folder.path("x.fvv")});
  }();
  CHECK(refused.err.find("is 64 x 48, the camera is 72 x 40 (cut or padded? state \"place\": [x, y]") !=
        refused.err.npos);
  scene.capture.cameras[1].pictures->place = scene::Placement{8, -4};
  mux::Report summary;
  // The bright quarter, 32 x 24, begins 8 columns further to the right and lost its first 4 rows.
  CHECK(scene.numbers(summary, 14, 22)[7] == std::vector<int>{13, 7});
  CHECK(scene.numbers(summary, 38, 10)[7][1] == 13);
  CHECK(scene.numbers(summary, 60, 10)[7] == std::vector<int>{7, 7});
  // There is nothing at the left: the edge goes on.
  CHECK(scene.numbers(summary, 2, 2)[7] == std::vector<int>{13, 13});
}

TEST_CASE("pictures are turned by the video's matrix, unless the capture overrides it") {
  Clip clip;
  clip.times = steady(20, 3000);
  clip.display_rotation = 90;
  Scene scene(clip, "a.mp4", {{48, 64}, {64, 48}});
  scene.capture.cameras[1].pictures->rotate = 180;
  mux::Report summary;
  // Turned by 90 the bright quarter is at the top right, by 180 at the bottom right.
  CHECK(scene.numbers(summary, 4, 4)[7] == std::vector<int>{7, 7});
  CHECK(scene.numbers(summary, 44, 4)[7][0] == 13); // 7 and bright
  scene.capture.cameras[1].pictures->rotate.reset();
  scene::write_capture(scene.capture, scene.capture.path);
  const ToolResult run = run_tool({scene.capture.path, "-o", scene.folder.path("x.fvv")});
  CHECK(run.exit == 1);
  CHECK(run.err ==
        "fvvmux: " + scene.capture.path +
            ": camera 13: pictures 1a.mp4: is 48 x 64, turned by 90 degrees, the camera is 64 x 48 "
            "(turned? state \"rotate\": 90 or 270)\n");
}
