// Streams with several environment tracks: fvvdemux and fvvrender take them all (fvv.md clause 18.1).
#include "demux_fixture.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/environment.h"
#include "fvv_view/frame.h"
#include "fvvdemux/demux.h"

#include <algorithm>

using namespace fvv;
using Catch::Matchers::Contains;

namespace {

// A square of 8 steps a side at a given height, in one colour or with a picture, and a light.
Bytes square(double step, int32_t height, const std::vector<uint8_t> &picture, double intensity) {
  int32_t positions[12] = {0, 0, height, 8, 0, height, 8, 8, height, 0, 8, height};
  uint32_t faces[6] = {0, 1, 2, 0, 2, 3}, texture[8] = {0, 0, 16, 0, 16, 16, 0, 16};
  const bool textured = !picture.empty();
  const fvv_mesh mesh = {positions, faces, 4, 2, textured ? texture : nullptr, uint8_t(textured ? 4 : 0),
                         nullptr,   0,     {}};
  fvv_bytes coded = {}, payload = {};
  REQUIRE(fvv_mesh_encode(&mesh, FVV_MESH_RAW, 7, nullptr, &coded, nullptr) == FVV_OK);
  fvv_environment_part part = {
      coded.data, coded.size, textured ? 0u : uint32_t(FVV_NO_PICTURE), {65535, 0, 65535}, 0, {0, 0}, {1, 1}};
  fvv_environment_picture file = {FVV_PICTURE_PNG, 2, 2, picture.data(), picture.size()};
  fvv_light light = {FVV_LIGHT_POINT, 0, {1, 2, 3}, {0, 0, 0}, {1, 1, 1}, intensity, 0, 0, 0};
  const fvv_environment environment = {{0, 0, 0}, step, &part, 1, &file, textured, &light, 1, nullptr, {}};
  REQUIRE(fvv_environment_encode(&environment, nullptr, &payload, nullptr) == FVV_OK);
  const Bytes out(payload.data, payload.data + payload.size);
  fvv_bytes_free(&coded);
  fvv_bytes_free(&payload);
  return out;
}

std::vector<uint8_t> picture(uint8_t value) {
  return media::encode_png(media::make_image(2, 2, 3, value));
}

StreamOptions stage() {
  StreamOptions options;
  options.cameras = {7, 0, 1};
  options.environments = {square(0.5, 1, picture(10), 5), square(0.07, 3, {}, 6),
                          square(0.25, 7, picture(200), 7)};
  return options;
}

demux::Result unpack(const std::string &input, const std::string &folder) {
  demux::Result result;
  demux::demux(input, folder, {}, result);
  return result;
}

} // namespace

TEST_CASE("fvvdemux: several environments become one environment") {
  const Scratch scratch;
  const demux::Result result = unpack(scratch.file("in.fvv", make_stream(stage())), scratch.path("out"));
  CHECK(result.environment);
  CHECK((result.losses.empty() && result.warnings.empty()));
  const scene::Capture described = scene::load_capture(scratch.path("out/capture.json"));
  REQUIRE(described.environment);
  CHECK(described.environment->lattice->step == 0.07);
  const scene::Environment environment = scene::load_environment(described);
  REQUIRE(environment.parts.size() == 3);
  REQUIRE(environment.pictures.size() == 2);
  CHECK(environment.lights.size() == 3);
  for (const auto &[height, file] : {std::pair(0.5, 10), {0.21, -1}, {1.75, 200}}) {
    INFO(height);
    const auto part = std::find_if(environment.parts.begin(), environment.parts.end(), [&](const auto &p) {
      return std::abs(p.mesh.positions[2] - height) < 1e-6;
    });
    REQUIRE(part != environment.parts.end());
    REQUIRE(part->picture.has_value() == (file >= 0));
    if (file < 0) continue;
    const std::string &bytes = environment.pictures[*part->picture];
    const std::vector<uint8_t> wanted = picture(uint8_t(file));
    CHECK(bytes == std::string(wanted.begin(), wanted.end()));
  }
}

TEST_CASE("fvvrender: several environments are drawn") {
  const Scratch scratch;
  const view::Frame frame = view::load_frame(InputFile(scratch.file("in.fvv", make_stream(stage()))), 4);
  CHECK(frame.losses.empty());
  REQUIRE(frame.environment.size() == 3);
  CHECK(frame.environment[0].picture->pixels[0] == 10);
  CHECK(!frame.environment[1].picture);
  CHECK(std::abs(frame.environment[1].positions[2] - 0.21) < 1e-6);
  CHECK(frame.environment[2].picture->pixels[0] == 200);
}

TEST_CASE("of several environments one is damaged: the others are taken") {
  const Scratch scratch;
  const StreamOptions options = stage();
  Bytes bytes = make_stream(options);
  const Bytes &broken = options.environments[1];
  const auto at = std::search(bytes.begin(), bytes.end(), broken.begin(), broken.end());
  REQUIRE(at != bytes.end());
  at[40] ^= 1;
  const std::string input = scratch.file("in.fvv", bytes);
  const demux::Result result = unpack(input, scratch.path("out"));
  REQUIRE(result.losses.size() == 1);
  CHECK_THAT(result.losses[0], Contains("the environment is lost: track 12: ") && Contains("FVV-1103"));
  const scene::Capture described = scene::load_capture(scratch.path("out/capture.json"));
  CHECK(described.environment->lattice->step == 0.25);
  CHECK(scene::load_environment(described).parts.size() == 2);
  const view::Frame frame = view::load_frame(InputFile(input), 1);
  CHECK(frame.environment.size() == 2);
  REQUIRE(frame.losses.size() == 1);
  CHECK_THAT(frame.losses[0], Contains("no environment: track 12: "));
}
