// fvvmux: which cameras go into a stream.
#include "mux_fixture.h"

namespace {

std::vector<uint16_t> ids(const fvv_configuration &configuration) {
  std::vector<uint16_t> out;
  for (size_t i = 0; i < configuration.camera_count; i++) out.push_back(configuration.cameras[i].id);
  return out;
}

} // namespace

TEST_CASE("cameras are taken by identifier, range and name") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  std::vector<uint16_t> all;
  for (const scene::Camera &camera : capture.cameras) all.push_back(camera.calibration.id);
  std::sort(all.begin(), all.end());
  REQUIRE(all.size() == 3);
  FileOptions options = options_for(folder);
  const auto taken = [&](const std::vector<std::string> &wanted) {
    options.cameras = wanted;
    mux_file(options);
    return ids(Stream(options.output).configuration());
  };
  CHECK(taken({}) == all);
  CHECK(taken({std::to_string(all[1])}) == std::vector<uint16_t>{all[1]});
  CHECK(taken({std::to_string(all[0]) + "-" + std::to_string(all[1])}) ==
        std::vector<uint16_t>{all[0], all[1]});
  CHECK(taken({"camera 1"}) == std::vector<uint16_t>{capture.cameras[1].calibration.id});
  CHECK(taken({std::to_string(all[2]), std::to_string(all[0])}) == std::vector<uint16_t>{all[0], all[2]});
  options.cameras = {"camera 9"};
  CHECK_THROWS_WITH(mux_file(options), Catch::Contains("--cameras: expected identifiers") &&
                                           Catch::Contains("found \"camera 9\""));
}

TEST_CASE(
    "a camera whose lens model changes is left out with a warning, one without texture gives no pictures") {
  const Folder folder;
  scene::Capture capture = make_capture(folder);
  for (const int64_t number : capture.frames.numbers())
    capture.cameras[0].per_frame[number] = capture.cameras[0].calibration;
  fvv_camera &last = capture.cameras[0].per_frame.rbegin()->second;
  last.lens = FVV_LENS_RADTAN;
  last.r_max = 1;
  capture.cameras[1].texture = false;
  scene::write_capture(capture, capture.path);
  const Run run = run_tool({folder.path("in"), "-o", folder.path("out.fvv")});
  CHECK(run.exit == 3);
  CHECK(run.err.find("left out, because their lens models change from frame to frame: camera " +
                     std::to_string(capture.cameras[0].calibration.id) + " (camera 0)") != std::string::npos);
  Stream stream(folder.path("out.fvv"));
  const fvv_configuration &configuration = stream.configuration();
  CHECK(configuration.camera_count == 2);
  REQUIRE(configuration.videos[0].tile_count == 1);
  CHECK(configuration.videos[0].tiles[0].camera_id == capture.cameras[2].calibration.id);
}
