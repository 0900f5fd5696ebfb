// fvvmux: which cameras see what, chosen, written, the same for any number of threads, and verified.
#include "mux_fixture.h"

#include "mux/src/choose/decisions.h"
#include "mux/src/visibility.h"

#include "fvv_mux/report.h"
#include "mux/src/stream_writer.h"

namespace {

using mux::Visibility;

// Two balls in line with camera 3: for it the nearer one hides part of the other, for camera 13 nothing does.
geometry::Mesh two_balls(int64_t frame) {
  geometry::Mesh mesh = ball(frame);
  const auto count = uint32_t(mesh.vertex_count());
  const std::vector<double> positions = mesh.positions;
  const std::vector<uint32_t> faces = mesh.faces;
  for (size_t i = 0; i < positions.size(); i++)
    mesh.positions.push_back(positions[i] * 0.6 + (i % 3 == 2 ? -1 : 0));
  for (const uint32_t vertex : faces) mesh.faces.push_back(vertex + count);
  return mesh;
}

FileOptions balls_on_disk(const Folder &folder, Shape shape = {}) {
  const scene::Capture capture = make_capture(folder, shape);
  for (const int64_t number : capture.frames.numbers())
    scene::write_mesh(two_balls(number), {}, capture.mesh_path(number));
  FileOptions options = options_for(folder);
  options.visibility = Visibility::weights;
  options.quality = {false, 30};
  return options;
}

// How many vertices of the first frame are backfacing, hidden and seen for a camera.
std::array<size_t, 3> states_of(const std::string &path, uint16_t camera) {
  Stream stream(path);
  const fvv_visibility *found = stream.visibility(0);
  REQUIRE(found);
  std::array<size_t, 3> out = {};
  const size_t count = found->header.vertex_count;
  for (size_t i = 0; i < found->header.camera_count; i++)
    if (found->cameras[i] == camera)
      for (size_t k = 0; k < count; k++) {
        const uint8_t state = found->states[i * count + k];
        out[!state                      ? FVV_VERTEX_BACKFACING
            : FVV_VERTEX_IS_SEEN(state) ? FVV_VERTEX_SEEN
                                        : FVV_VERTEX_HIDDEN]++;
      }
  return out;
}

} // namespace

TEST_CASE("weights say who is hidden, and are what was read back") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(summary.visibility_choice.sent);
  CHECK(summary.visibility.frames == 5);
  // Groups of 2: the frames after the first have its faces.
  CHECK(summary.visibility.keys == 3);
  CHECK(summary.verdict->visible == 5);
  const auto front = states_of(options.output, 3), side = states_of(options.output, 13);
  // The far ball shows camera 3 a rim of its half alone.
  CHECK(front[FVV_VERTEX_HIDDEN] > 60);
  CHECK(side[FVV_VERTEX_HIDDEN] == 0);
  CHECK(side[FVV_VERTEX_SEEN] > front[FVV_VERTEX_SEEN]);
  const nlohmann::ordered_json json = json_of(summary);
  CHECK(json["visibility"]["bits_per_pair"] < 1.5);
  CHECK(json["visibility"]["bytes"] == summary.visibility.bytes);
  CHECK(json["verified"]["visibility"] == 5);
}

TEST_CASE("a weight that is not what a camera sees is found") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  options.verify = true;
  Encoded encoded = encode_file(options);
  CHECK_NOTHROW(encoded.verify(options.output));
  encoded.plan.visibility.threshold = 0;
  CHECK_THROWS_AS(encoded.verify(options.output), fvv::Error);
}

TEST_CASE("visibility is the same for any number of threads") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  std::string first;
  for (const bool delta : {true, false})
    for (const uint32_t threads : {1u, 2u, 5u}) {
      options.threads = threads;
      options.delta = delta;
      CHECK(mux_file(options).visibility.keys == (delta ? 3u : 5u));
      const std::string bytes = read_bytes(options.output);
      if (threads == 1)
        first = bytes;
      else
        CHECK(bytes == first);
    }
}

TEST_CASE("visibility that does not pay is left out, and the reason is reported") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  options.visibility = Visibility::automatic;
  const auto reason = [&] {
    const mux::Report summary = mux_file(options);
    CHECK(summary.visibility.frames == 0);
    CHECK(summary.visibility.bytes == 0);
    CHECK(json_of(summary)["visibility"]["sent"] == false);
    Stream stream(options.output);
    for (size_t i = 0; i < stream.configuration().track_count; i++)
      CHECK(stream.configuration().tracks[i].kind != FVV_TRACK_VISIBILITY);
    return summary.visibility_choice.reason;
  };
  options.quality = {false, 51};
  CHECK(reason().find("more than 10 %") != std::string::npos);
  options.pictures = false;
  CHECK(reason() == "there are no pictures of cameras");
  options.pictures = true;
  options.cameras = {"3"};
  CHECK(reason() == "one camera alone costs a player one depth map");
  options.cameras.clear();
  options.meshes = false;
  CHECK(reason() == "there are no meshes");
  options.visibility = Visibility::weights;
  CHECK_THROWS_AS(mux_file(options), fvv::Error);
  options.meshes = true;
  options.visibility = Visibility::none;
  CHECK(fvv::spell(reason(), fvv::Spelling::command_line) == "--visibility none");
}

TEST_CASE("visibility pays up to a tenth of the pictures") {
  mux::VisibilityChoice choice;
  choice.on = choice.open = true;
  for (const uint64_t bytes : {100u, 101u})
    CHECK(mux::decide_visibility(choice, bytes, 1000).on == (bytes == 100));
  // Less where bytes have to be seen, and more where few cameras leave much to them.
  choice.by_views = true;
  choice.cameras = {0, 1, 2, 3, 4};
  for (const uint64_t bytes : {150u, 151u})
    CHECK(mux::decide_visibility(choice, bytes, 1000).on == (bytes == 150));
  choice.cameras.push_back(5);
  for (const uint64_t bytes : {20u, 21u})
    CHECK(mux::decide_visibility(choice, bytes, 1000).on == (bytes == 20));
  // Explicit choices stay.
  choice.open = false;
  CHECK(mux::decide_visibility(choice, 5000, 1000).on);
}

TEST_CASE("on request there is visibility of cameras without pictures too") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  options.pictures = false;
  CHECK(mux_file(options).visibility.frames == 5);
  CHECK(states_of(options.output, 23)[FVV_VERTEX_SEEN] > 50);
}

TEST_CASE("a camera that is too far away for the lattice has no weights, and is not counted") {
  const Folder folder;
  Shape shape;
  FileOptions options = balls_on_disk(folder, shape);
  scene::Capture capture = scene::load_capture(folder.path("in/capture.json"));
  capture.cameras[2].calibration.translation[2] = 5e5; // metres; the lattice has 2^28 steps of 1 mm
  scene::write_capture(capture, capture.path);
  options.step = mux::Length{0.001, true};
  options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(mux::make_plan(options, {}).visibility.cameras.size() == 3);
  CHECK(json_of(summary)["visibility"]["cameras"] == 2);
  CHECK(text_of(summary).find("bits a vertex and camera, 2 cameras") != std::string::npos);
  CHECK(summary.verdict->visible == 5);
  CHECK(states_of(options.output, 23) == std::array<size_t, 3>{});
  CHECK(states_of(options.output, 3)[FVV_VERTEX_SEEN] > 50);
}

TEST_CASE("the option --visibility names what it takes") {
  mux::Options options;
  mux::set_option(options, "visibility", "weight");
  CHECK(options.visibility == Visibility::weights);
  for (const std::string former : {"face", "vertex"})
    CHECK_THROWS_WITH(mux::set_option(options, "visibility", former),
                      "visibility: expected auto, weight or none, found \"" + former + "\"");
}

// ---- Colours of vertices.

namespace {

// Of the first frame: mean and distance from the mean, of R, G and B.
std::array<double, 4> colours_of(const std::string &path) {
  const InputFile file(path);
  const fvv_input input = file.input();
  fvv_stream *stream = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &stream, nullptr) == FVV_OK);
  const uint8_t *colours = nullptr;
  uint32_t count = 0;
  REQUIRE(fvv_stream_colours(stream, 0, mux::mesh_track, &colours, &count, nullptr) == FVV_OK);
  std::array<double, 4> out = {};
  for (size_t i = 0; i < 3 * size_t(count); i++) out[i % 3] += colours[i] / double(count);
  for (size_t i = 0; i < 3 * size_t(count); i++)
    out[3] += std::abs(colours[i] - out[i % 3]) / (3 * double(count));
  fvv_stream_close(stream);
  return out;
}

} // namespace

TEST_CASE("colours of vertices are those of the pictures, the same for any number of threads") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  const scene::Capture capture = scene::load_capture(scene::description_file(options.capture));
  for (const scene::Camera &camera : capture.cameras)
    for (const int64_t number : capture.frames.numbers()) {
      media::Image image = media::make_image(camera.calibration.width, camera.calibration.height, 3, 200);
      for (size_t i = 0; i < image.pixels.size(); i += 3) image.pixels[i] = 40;
      write_png(capture.picture_path(camera, number), image);
    }
  std::string first;
  for (const uint32_t threads : {1u, 3u}) {
    options.threads = threads;
    const mux::Report summary = mux_file(options);
    CHECK(summary.colours_choice.sent);
    // Groups of 2: a key mesh each.
    CHECK(summary.colours.track.chunks == 3);
    CHECK(summary.colours.psnr() > 25);
    const nlohmann::ordered_json json = json_of(summary);
    CHECK(json["colours"]["bytes"] == summary.colours.track.payload);
    CHECK(json["colours"]["frames"] == 3);
    const std::array<double, 4> found = colours_of(options.output);
    CHECK(std::abs(found[0] - 40) < 15);
    CHECK(std::abs(found[1] - 200) < 15);
    CHECK(std::abs(found[2] - 200) < 15);
    CHECK(found[3] < 2);
    const std::string bytes = read_bytes(options.output);
    if (first.empty()) first = bytes;
    CHECK(bytes == first);
  }
  options.colour_cells = 40;
  const uint64_t all = mux_file(options).colours.cells;
  options.colour_cells = 400;
  CHECK(mux_file(options).colours.cells > 3 * all);
  options.delta = false;
  CHECK(mux_file(options).colours.track.chunks == 5);
}

TEST_CASE("colours have the time of their mesh after a frame that is left out") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  write_bytes(scene::load_capture(scene::description_file(options.capture)).mesh_path(1), "ply", 3);
  options.skip_bad_frames = options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(summary.left_out.size() == 1);
  CHECK(summary.colours.track.chunks == 3);
}

TEST_CASE("whether colours of vertices are sent") {
  const Folder folder;
  FileOptions options = balls_on_disk(folder);
  const auto sent = [&] {
    const mux::Report summary = mux_file(options);
    CHECK(summary.colours_choice.sent == (summary.colours.track.chunks > 0));
    CHECK(json_of(summary)["colours"]["sent"] == summary.colours_choice.sent);
    Stream stream(options.output);
    size_t tracks = 0;
    for (size_t i = 0; i < stream.configuration().track_count; i++)
      tracks += stream.configuration().tracks[i].kind == FVV_TRACK_COLOURS;
    CHECK(tracks == size_t(summary.colours_choice.sent));
    return summary.colours_choice.sent;
  };
  CHECK(sent());
  // Without weights rays decide.
  options.visibility = Visibility::none;
  CHECK(sent());
  options.texture_unseen = {1, 2, 3};
  CHECK(!sent());
  options.colours = mux::Colours::on;
  CHECK(sent());
  options.colours = mux::Colours::off;
  CHECK(!sent());
  options.colours = mux::Colours::automatic;
  options.texture_unseen.reset();
  options.pictures = false;
  CHECK(!sent());
  options.colours = mux::Colours::on;
  CHECK_THROWS_WITH(mux_file(options), Catch::Contains("colours: there are no pictures of cameras"));
}
