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
  CHECK_THROWS_WITH(mux_file(options), Catch::Contains("cameras: expected identifiers") &&
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
  const ToolResult run = run_tool({folder.path("in"), "-o", folder.path("out.fvv")});
  CHECK(run.exit == 3);
  CHECK(run.err.find("left out, because their lens models change from frame to frame: camera " +
                     std::to_string(capture.cameras[0].calibration.id) + " (camera 0)") != std::string::npos);
  Stream stream(folder.path("out.fvv"));
  const fvv_configuration &configuration = stream.configuration();
  CHECK(configuration.camera_count == 2);
  REQUIRE(configuration.videos[0].tile_count == 1);
  CHECK(configuration.videos[0].tiles[0].camera_id == capture.cameras[2].calibration.id);
}

TEST_CASE("options are set by the names of the command line, and refused by them") {
  mux::Options options;
  const auto set = [&](const char *name, const char *text) { mux::set_option(options, name, text); };
  set("codec", "av1");
  set("bit-depth", "10");
  set("max-error", "0.3px");
  set("group", "7");
  set("texture-threshold", "0.25");
  set("texture-blend", "paper");
  set("no-delta", "on");
  set("keep-geometry", "off");
  CHECK_THROWS_WITH(set("max_error", "1"), "there is no option max_error");
  CHECK_THROWS_WITH(set("group", "0"), "group: expected a whole number from 1 to 100000, found \"0\"");
  CHECK_THROWS_WITH(set("mesh-level", "1.5"),
                    "mesh-level: expected a whole number from 0 to 10, found \"1.5\"");
  CHECK_THROWS_WITH(set("texture-threshold", "nan"),
                    "texture-threshold: expected a number from 0 to 1, found \"nan\"");
  CHECK_THROWS_WITH(set("live", "1"), "live: expected on or off, found \"1\"");
  CHECK_THROWS_WITH(set("tile", ""), "tile: expected a value, found \"\"");
  options = mux::settled(options);
  CHECK(options.codec == FVV_CODEC_AV01);
  CHECK(options.bit_depth == 10);
  CHECK(options.max_error->value == 0.3);
  CHECK(options.max_error->unit == mux::MaxError::pixels);
  CHECK(options.group == 7);
  CHECK(options.texture_threshold == 0.25);
  CHECK(options.texture_blend == uint32_t(FVV_BLEND_PAPER));
  CHECK(!options.delta);
  CHECK(!options.keep_geometry);
  // The command line excludes these as it parses, other programs do not.
  const std::vector<std::vector<std::pair<const char *, const char *>>> wrong = {
      {{"quality", "30"}, {"bitrate", "1M"}},
      {{"tile", "64x48"}, {"scale", "0.5"}},
      {{"video-tracks", "2"}, {"video-pixels", "2M"}},
      {{"video-size", "640x480"}, {"video-pixels", "2M"}},
      {{"triangles", "100"}, {"keep-geometry", "on"}},
      {{"mesh-ladder", "on"}},
      {{"undistort-alpha", "1"}},
      {{"sound-bitrate", "96k"}, {"no-sound", "on"}},
  };
  for (const auto &pairs : wrong) {
    options = {};
    for (const auto &[name, text] : pairs) set(name, text);
    CHECK_THROWS_WITH(mux::settled(options), Catch::Contains(pairs[0].first));
  }
}
