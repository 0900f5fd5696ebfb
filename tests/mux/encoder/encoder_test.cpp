// Frames from memory: what the encoder writes is whole, holds what was pushed, and comes a group at a time.
#include "../mux_fixture.h"

#include "fvv_cxx/owned.h"
#include "fvv_demux/frame_plan.h"
#include "fvv_mux/encoder.h"
#include "mux/src/stream_writer.h"

namespace {

fvv_camera camera_of(uint16_t id, double x) {
  fvv_camera camera = {};
  camera.id = id;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 60;
  camera.cx = 32;
  camera.cy = 24;
  for (int i = 0; i < 9; i += 4) camera.rotation[i] = 1;
  camera.translation[0] = x;
  camera.translation[2] = 3;
  camera.r_max = fvv_camera_r_max(&camera);
  return camera;
}

mux::Configuration two_cameras() {
  mux::Configuration configuration;
  configuration.name = "pushed";
  for (const uint16_t id : {3, 1}) {
    mux::CameraInput camera;
    camera.calibration = camera_of(id, id * 0.1);
    camera.name = "camera " + std::to_string(id);
    camera.masks = true;
    configuration.cameras.push_back(camera);
  }
  return configuration;
}

// A tetrahedron that moves; its mask is a square that grows, so that later groups need more room.
mux::Frame frame_of(int i, uint32_t side) {
  mux::Frame frame;
  const double x = 0.01 * i;
  frame.mesh.positions = {x, 0, 0, x + 0.5, 0, 0, x, 0.5, 0, x, 0, 0.5};
  frame.mesh.faces = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  for (int k = 0; k < 2; k++) {
    frame.pictures.push_back(media::make_image(64, 48, 3, uint8_t(60 + 40 * k)));
    media::Image mask = media::make_image(64, 48, 1, 0);
    for (uint32_t y = 24 - side; y < 24 + side; y++)
      for (uint32_t c = 32 - side; c < 32 + side; c++) mask.pixels[y * 64 + c] = 255;
    frame.masks.push_back(mask);
  }
  return frame;
}

// 1 m wide and high, 20 by 20 squares.
geometry::Mesh wavy_sheet() {
  geometry::Mesh mesh;
  const uint32_t side = 21;
  for (uint32_t y = 0; y < side; y++)
    for (uint32_t x = 0; x < side; x++) {
      mesh.positions.insert(mesh.positions.end(), {x * 0.05 - 0.5, y * 0.05 - 0.5, 0.02 * std::sin(x * 0.5)});
      if (!x || !y) continue;
      const uint32_t last = y * side + x, above = last - side;
      for (const uint32_t corner : {last, last - 1, above, above, last - 1, above - 1})
        mesh.faces.push_back(corner);
    }
  return mesh;
}

mux::Options jpeg_options() {
  mux::Options options;
  options.codec = FVV_CODEC_JPEG;
  options.quality = {false, 90};
  options.group = 4;
  options.keep_geometry = true;
  return options;
}

std::string encoded(const mux::Options &options, int count, std::vector<size_t> *sizes = nullptr) {
  std::string bytes;
  mux::Encoder encoder(two_cameras(), options, [&](const void *part, size_t size) {
    bytes.append(static_cast<const char *>(part), size);
  });
  for (int i = 0; i < count; i++) {
    encoder.add(frame_of(i, uint32_t(4 + i)));
    if (sizes) sizes->push_back(bytes.size());
  }
  encoder.finish();
  return bytes;
}

std::string refusal(const std::function<void(mux::Frame &)> &spoil) {
  mux::Encoder encoder(two_cameras(), jpeg_options(), [](const void *, size_t) {});
  mux::Frame frame = frame_of(0, 4);
  spoil(frame);
  try {
    encoder.add(std::move(frame));
  } catch (const fvv::Error &error) {
    return error.what();
  }
  return "";
}

} // namespace

TEST_CASE("pushed frames are a whole stream with their meshes and pictures") {
  const Folder folder;
  const std::string bytes = encoded(jpeg_options(), 10);
  write_bytes(folder.path("out.fvv"), bytes.data(), bytes.size());
  Stream stream(folder.path("out.fvv"));
  const fvv_configuration &configuration = stream.configuration();
  REQUIRE(configuration.camera_count == 2);
  CHECK(configuration.cameras[0].id == 1); // by rising identifier
  REQUIRE(stream.frames() == 10);
  for (size_t i = 0; i < 10; i++) {
    OwnedMesh mesh;
    stream.mesh(i, mesh);
    CHECK(mesh.vertex_count == 4);
  }
  for (const media::Image &picture : stream.pictures()) {
    const fvv_rect &tile = configuration.videos[0].tiles[1].destination;
    const uint8_t grey =
        picture.pixels[3 * ((tile.y + tile.height / 2) * size_t(picture.width) + tile.x + tile.width / 2)];
    CHECK(std::abs(grey - 60) < 4); // camera 3, which was pushed first
  }
}

TEST_CASE("bytes come when a group is complete, and do not depend on threads") {
  std::vector<size_t> sizes;
  const std::string bytes = encoded(jpeg_options(), 9, &sizes);
  for (const int i : {0, 1, 2}) CHECK(sizes[size_t(i)] == 0);
  CHECK(sizes[3] > 0);
  for (const int i : {4, 5, 6}) CHECK(sizes[size_t(i)] == sizes[3]);
  CHECK(sizes[7] > sizes[3]);
  CHECK(bytes.size() > sizes[8]);
  mux::Options options = jpeg_options();
  options.threads = 3;
  CHECK(encoded(options, 9) == bytes);
}

TEST_CASE("a frame that does not fit the configuration is refused by its number") {
  CHECK(refusal([](mux::Frame &f) { f.mesh.faces.clear(); }) == "frame 0: expected a mesh with faces");
  CHECK(refusal([](mux::Frame &f) { f.pictures.pop_back(); }) ==
        "frame 0: expected 2 pictures, one for each camera, found 1");
  CHECK(refusal([](mux::Frame &f) { f.pictures[1] = media::make_image(60, 48, 3, uint8_t(1)); }) ==
        "frame 0: camera 1: expected a picture of 64x48 pixels, found 60x48");
  CHECK(refusal([](mux::Frame &f) { f.masks.clear(); }) == "frame 0: expected masks");
}

namespace {

// "0..4 2": a group of ticks 0 to 3 with 2 frames.
std::string groups_in(const fvv_stream *file) {
  std::string out;
  for (size_t g = 0; g < fvv_stream_group_count(file); g++) {
    const fvv_group_info &group = *fvv_stream_group(file, g);
    out += (g ? ", " : "") + std::to_string(group.start) + ".." + std::to_string(group.end) + " " +
           std::to_string(group.frame_count);
  }
  return out;
}

// stage: a mesh for each x, and a frame that is missing for each dot. Options::group is 4.
std::string staged(const std::string &stage, bool pictures, const std::string &path) {
  std::string bytes;
  mux::Configuration configuration = two_cameras();
  for (mux::CameraInput &camera : configuration.cameras) camera.pictures = camera.masks = pictures;
  mux::Options options = jpeg_options();
  if (!pictures) options.step = mux::Length{0.001, true};
  mux::Encoder encoder(configuration, options, [&](const void *part, size_t size) {
    bytes.append(static_cast<const char *>(part), size);
  });
  for (size_t i = 0; i < stage.size(); i++) {
    if (stage[i] == '.') {
      encoder.skip();
      continue;
    }
    mux::Frame frame = frame_of(int(i), 4);
    if (stage[i] != 'x') frame.mesh = {};
    if (!pictures) frame.pictures.clear();
    if (!pictures) frame.masks.clear();
    encoder.add(std::move(frame));
  }
  encoder.finish();
  write_bytes(path, bytes.data(), bytes.size());
  const fvv::InputFile file(path);
  const fvv::demux::Stream stream = fvv::demux::open_stream(file);
  std::string out = groups_in(stream.get()) + ":";
  for (size_t i = 0; i < fvv_stream_frame_count(stream.get()); i++) {
    OwnedMesh mesh;
    fvv_frame frame;
    REQUIRE(fvv_stream_frame(stream.get(), i, &frame, nullptr) == FVV_OK);
    const fvv_status status = fvv_stream_mesh(stream.get(), i, 1, &mesh, nullptr);
    REQUIRE(status >= 0);
    out += " " + std::to_string(frame.time) + (status == FVV_OK ? "x" : "");
  }
  return out;
}

} // namespace

TEST_CASE("frames without a mesh: the stage is empty, and nothing before it lasts") {
  const Folder folder;
  const std::string path = folder.path("out.fvv");
  SECTION("their pictures stay; the group ends where the stage becomes empty") {
    CHECK(staged("xx-x", true, path) == "0..2 2, 2..4 2: 0x 1x 2 3x");
    CHECK(staged("xxxx--xx-", true, path) == "0..4 4, 4..8 4, 8..9 1: 0x 1x 2x 3x 4 5 6x 7x 8");
    CHECK(staged("-----x", true, path) == "0..4 4, 4..6 2: 0 1 2 3 4 5x");
  }
  SECTION("without pictures they are no frames") {
    CHECK(staged("xx-x", false, path) == "0..2 2, 2..4 1: 0x 1x 3x");
    CHECK(staged("xxxx--xx-", false, path) == "0..4 4, 4..8 2, 8..9 0: 0x 1x 2x 3x 6x 7x");
    CHECK(staged("-----x", false, path) == "0..6 1: 5x");
    CHECK(staged("x---------x", false, path) == "0..1 1, 1..11 1: 0x 10x");
  }
  SECTION("there has to be one") {
    CHECK_THROWS_WITH(staged("---", true, path),
                      "encoder: expected a frame with a mesh before finish(), found none");
  }
}

TEST_CASE("frames that are missing take their time, and nothing else") {
  const Folder folder;
  const std::string path = folder.path("out.fvv");
  CHECK(staged("xx.xx.x", true, path) == "0..4 3, 4..7 2: 0x 1x 3x 4x 6x");
  CHECK(staged("xxx.x", true, path) == "0..4 3, 4..5 1: 0x 1x 2x 4x"); // a group of three ends in time
  // Of the time between two groups nothing is known, unless the stage is known to be empty.
  CHECK(staged("xxxx..xx", true, path) == "0..4 4, 6..8 2: 0x 1x 2x 3x 6x 7x");
  CHECK(staged("xxxx-.xx", false, path) == "0..4 4, 4..8 2: 0x 1x 2x 3x 6x 7x");
  CHECK(staged("....xx", true, path) == "0..6 2: 4x 5x");
  CHECK_THROWS_WITH(staged("...", true, path),
                    "encoder: expected a frame with a mesh before finish(), found none");
  mux::Configuration pictures = two_cameras();
  pictures.meshes = false;
  mux::Encoder encoder(pictures, jpeg_options(), [](const void *, size_t) {});
  encoder.skip();
  CHECK_THROWS_WITH(encoder.finish(), "encoder: expected at least one frame before finish()");
}

TEST_CASE("effort falls between groups, and the stream stays one") {
  const Folder folder;
  const auto bytes_with = [&](std::initializer_list<size_t> efforts, uint32_t codec) {
    mux::Options options = jpeg_options();
    options.codec = codec;
    options.preset = mux::Preset::live;
    options.quality = {false, codec == FVV_CODEC_JPEG ? 90.0 : 20.0};
    std::string bytes;
    mux::Encoder encoder(two_cameras(), options, [&](const void *part, size_t size) {
      bytes.append(static_cast<const char *>(part), size);
    });
    std::vector<size_t> groups;
    int frame = 0;
    for (const size_t effort : efforts) {
      encoder.set_effort(effort);
      const size_t before = bytes.size();
      for (int i = 0; i < 4; i++, frame++) {
        mux::Frame next = frame_of(frame, 20);
        for (media::AnyImage &picture : next.pictures) { // something to code
          std::vector<uint8_t> &pixels = std::get<media::Image>(picture).pixels;
          for (size_t p = 0; p < pixels.size(); p++) pixels[p] = uint8_t(p * p / 7 + size_t(frame));
        }
        encoder.add(std::move(next));
      }
      groups.push_back(bytes.size() - before);
    }
    encoder.finish();
    const std::string path = folder.path("out.fvv");
    write_bytes(path, bytes.data(), bytes.size());
    CHECK(Stream(path).frames() == size_t(frame));
    return groups;
  };
  for (const uint32_t codec : {FVV_CODEC_AVC1, FVV_CODEC_JPEG}) {
    const std::vector<size_t> groups = bytes_with({0, 0, 1, 2, 3, 0}, codec);
    CHECK(groups[3] < groups[1]);
    CHECK(groups[4] < groups[3]);
    CHECK(groups[5] > groups[3]);
  }
}

TEST_CASE("an index out of range is refused with frame and element, and no stream is finished") {
  mux::Encoder encoder(two_cameras(), jpeg_options(), [](const void *, size_t) {});
  for (int i = 0; i < 3; i++) encoder.add(frame_of(i, 4));
  mux::Frame bad = frame_of(3, 4);
  bad.mesh.faces[4] = 9;
  CHECK_THROWS_WITH(encoder.add(std::move(bad)), Catch::Contains("frame 3") && Catch::Contains("9"));
}

TEST_CASE("samples that were encoded before are sent as they are, with the meshes beside them") {
  const Folder folder;
  mux::Options options = jpeg_options();
  options.codec = FVV_CODEC_AVC1;
  options.quality = {false, 20};
  const std::string once = encoded(options, 6);
  write_bytes(folder.path("once.fvv"), once.data(), once.size());
  Stream first(folder.path("once.fvv"));
  const auto &video = first.configuration().videos[0];

  mux::Configuration configuration = two_cameras();
  for (mux::CameraInput &camera : configuration.cameras) camera.pictures = camera.masks = false;
  mux::EncodedTrack track;
  track.config = video.config;
  track.record.assign(video.config.record, video.config.record + video.config.record_size);
  track.tiles.assign(video.tiles, video.tiles + video.tile_count);
  configuration.encoded = {track};
  std::string twice;
  const auto sink = [&](const void *part, size_t size) {
    twice.append(static_cast<const char *>(part), size);
  };
  mux::Encoder encoder(configuration, options, sink);
  for (size_t i = 0; i < 6; i++) {
    mux::Frame frame = frame_of(int(i), 4);
    frame.pictures.clear();
    frame.masks.clear();
    int key = 0;
    frame.samples = {first.sample(i, key)};
    encoder.add(std::move(frame));
  }
  const mux::Report summary = encoder.finish();
  CHECK(mux::report_text(summary, "twice.fvv").find("encoded before") != std::string::npos);
  CHECK(summary.match.reason == "pictures that come encoded stay as they are");
  CHECK(summary.inset.reason == "pictures that come encoded are not decoded");
  write_bytes(folder.path("twice.fvv"), twice.data(), twice.size());
  Stream second(folder.path("twice.fvv"));
  REQUIRE(second.frames() == 6);
  for (size_t i = 0; i < 6; i++) {
    int key = 0, key_before = 0;
    CHECK(second.sample(i, key) == first.sample(i, key_before));
    CHECK(key == key_before);
  }
  CHECK(second.configuration().videos[0].tile_count == 2);
  CHECK(std::string(second.configuration().videos[0].config.codec_string,
                    second.configuration().videos[0].config.codec_string_size) ==
        std::string(video.config.codec_string, video.config.codec_string_size));
}

TEST_CASE("encoded samples that do not fit are refused") {
  mux::Configuration configuration = two_cameras();
  mux::EncodedTrack track;
  track.config.codec = FVV_CODEC_JPEG;
  track.config.width = track.config.height = 64;
  track.config.bit_depth = 8;
  track.tiles = {{3, {0, 0, 64, 48}, {0, 0, 64, 48}}};
  configuration.encoded = {track};
  const auto open = [&] { mux::Encoder(configuration, jpeg_options(), [](const void *, size_t) {}); };
  CHECK_THROWS_WITH(open(), Catch::Contains("camera 3 has pictures besides"));
  configuration.cameras[0].pictures = configuration.cameras[0].masks = false;
  configuration.encoded[0].tiles[0].source.width = 65;
  CHECK_THROWS_WITH(open(), Catch::Contains("not inside"));
  configuration.encoded[0].tiles[0].source.width = 64;
  configuration.encoded[0].tiles[0].camera_id = 9;
  CHECK_THROWS_WITH(open(), Catch::Contains("camera 9 is not configured"));
  configuration.encoded[0].tiles[0].camera_id = 3;
  mux::Encoder encoder(configuration, jpeg_options(), [](const void *, size_t) {});
  mux::Frame frame = frame_of(0, 4);
  CHECK_THROWS_WITH(encoder.add(frame), Catch::Contains("expected 1 encoded sample, found 0"));
  frame.samples = {{1, 2, 3}};
  CHECK_THROWS_WITH(encoder.add(frame), Catch::Contains("frame 0: encoded track 0"));
}

TEST_CASE("a camera that moves in every frame keeps its calibrations over all groups") {
  const Folder folder;
  mux::Configuration configuration = two_cameras();
  configuration.cameras[1].moves = true;
  std::string bytes;
  std::vector<fvv_camera> pushed;
  mux::Encoder encoder(configuration, jpeg_options(), [&](const void *part, size_t size) {
    bytes.append(static_cast<const char *>(part), size);
  });
  for (int i = 0; i < 10; i++) {
    mux::Frame frame = frame_of(i, 4);
    fvv_camera camera = configuration.cameras[1].calibration;
    const double angle = 0.02 * i; // to the side, and later groups zoom in
    camera.rotation[0] = camera.rotation[8] = std::cos(angle);
    camera.rotation[2] = std::sin(angle);
    camera.rotation[6] = -std::sin(angle);
    camera.translation[0] += 0.02 * i;
    camera.fx = camera.fy = 60 + 2 * i;
    frame.calibrations = {configuration.cameras[0].calibration, camera};
    pushed.push_back(camera);
    encoder.add(std::move(frame));
  }
  encoder.finish();
  write_bytes(folder.path("out.fvv"), bytes.data(), bytes.size());
  Stream stream(folder.path("out.fvv"));
  REQUIRE(stream.frames() == 10);
  for (size_t i = 0; i < 10; i++) {
    const fvv_camera got = stream.camera(i, pushed[i].id);
    const double at[3] = {0.1, 0.2, 0.3};
    double wanted[2], found[2];
    REQUIRE(fvv_camera_project(&pushed[i], at, wanted, nullptr) == 1);
    REQUIRE(fvv_camera_project(&got, at, found, nullptr) == 1);
    CAPTURE(i);
    CHECK(std::hypot(wanted[0] - found[0], wanted[1] - found[1]) < 0.05);
  }
}

TEST_CASE("a mesh is decimated for where a moving camera is in its group") {
  mux::Configuration configuration = two_cameras();
  configuration.cameras[1].moves = true;
  mux::Options options = jpeg_options();
  options.keep_geometry = false;
  for (const int group : {1, 3, 25}) {
    options.group = group;
    std::string bytes;
    mux::Encoder encoder(configuration, options, [&](const void *part, size_t size) {
      bytes.append(static_cast<const char *>(part), size);
    });
    for (int i = 0; i < 7; i++) {
      mux::Frame frame = frame_of(i, 4);
      frame.mesh = i == 4 ? geometry::Mesh() : wavy_sheet();
      fvv_camera camera = configuration.cameras[1].calibration;
      camera.translation[2] += i;
      frame.calibrations = {configuration.cameras[0].calibration, camera};
      encoder.add(std::move(frame));
    }
    CAPTURE(group);
    CHECK(encoder.finish().frames == 7);
  }
}

TEST_CASE("a cancelled encoder says so") {
  mux::Observer observer;
  bool stop = false;
  observer.is_cancelled = [&] { return stop; };
  size_t done = 0;
  observer.on_progress = [&](size_t frames) { done += frames; };
  mux::Encoder encoder(
      two_cameras(), jpeg_options(), [](const void *, size_t) {}, observer);
  for (int i = 0; i < 4; i++) encoder.add(frame_of(i, 4));
  CHECK(done == 4);
  stop = true;
  try {
    encoder.add(frame_of(4, 4));
    FAIL("expected an exception");
  } catch (const fvv::Error &error) {
    CHECK(error.kind == fvv::Error::cancelled);
  }
}

TEST_CASE("finishing without a frame is an error") {
  mux::Encoder encoder(two_cameras(), jpeg_options(), [](const void *, size_t) {});
  CHECK_THROWS_WITH(encoder.finish(), Catch::Contains("at least one frame"));
}

TEST_CASE("a name that readers refuse is refused before a byte is written") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  for (const bool camera : {true, false}) {
    mux::Configuration configuration = two_cameras();
    (camera ? configuration.cameras[0].name : configuration.name).assign(size_t(limits.max_text) + 1, 'n');
    size_t written = 0;
    std::string message;
    try {
      mux::Encoder encoder(configuration, jpeg_options(),
                           [&](const void *, size_t size) { written += size; });
      for (int i = 0; i < 5; i++) encoder.add(frame_of(i, 4));
      encoder.finish();
    } catch (const fvv::Error &error) {
      message = error.what();
    }
    INFO(message);
    CHECK(message.find(camera
                           ? "camera 3: CAMR: 1048577 bytes of a camera name, readers accept at most 1048576"
                           : "bytes of metadata, readers accept at most 1048576") != message.npos);
    CHECK(written == 0);
  }
}

TEST_CASE("groups that readers refuse are refused before a byte is written") {
  mux::Plan plan;
  plan.capture.path = "capture.json";
  std::string what;
  plan.capture.meshes = scene::Pattern::parse("%d.ply", &what);
  plan.meshes.resize(1);
  plan.meshes[0].id = mux::mesh_track;
  const auto refusal_of = [&](int64_t frames, uint32_t group) {
    plan.capture.frames.count = frames;
    plan.group_size = group;
    plan.groups = mux::groups_of(plan.capture, group);
    size_t written = 0;
    std::string message;
    try {
      const mux::Sink sink = [&](const void *, size_t size) { written += size; };
      const mux::Decisions decisions = {{}, {{}}, {}, {}};
      mux::StreamWriter writer(plan, decisions, sink);
    } catch (const fvv::Error &error) {
      message = error.what();
    }
    CHECK(written == 0);
    return message;
  };
  CHECK(refusal_of(2'000'000, 1'048'576) ==
        "capture.json: 1048577 chunks in a group of 1048576 frames, readers accept at most 1048576: choose "
        "fewer frames in a group");
  CHECK(refusal_of(4'194'305, 1) ==
        "capture.json: 4194305 groups, readers accept at most 4194304: choose more frames in a group");
}

TEST_CASE("cameras are matched by the frames of the first group") {
  mux::Configuration configuration = two_cameras();
  for (mux::CameraInput &camera : configuration.cameras) camera.masks = false;
  mux::Encoder encoder(configuration, jpeg_options(), [](const void *, size_t) {});
  for (int i = 0; i < 8; i++) {
    mux::Frame frame;
    frame.mesh = ball(0);
    // The second group has no part in it.
    for (const int value : {100, i < 4 ? 140 : 100})
      frame.pictures.push_back(media::make_image(64, 48, 3, uint8_t(value)));
    encoder.add(frame);
  }
  const mux::Report summary = encoder.finish();
  const mux::MatchReport &match = summary.match;
  CHECK(match.applied);
  CHECK(match.frames == 4);
  // By identifier: camera 1 was given second. Linear light of 100 and 140 is 0.1274 and 0.2623.
  REQUIRE(match.cameras.size() == 2);
  for (size_t k = 0; k < 3; k++) {
    CHECK(std::abs(match.cameras[0].gains[k] - std::sqrt(0.1274 / 0.2623)) < 0.002);
    CHECK(std::abs(match.cameras[1].gains[k] - std::sqrt(0.2623 / 0.1274)) < 0.002);
  }
}

TEST_CASE("what views lose is measured on pushed frames") {
  for (const bool plain : {false, true}) {
    mux::Configuration configuration = two_cameras();
    for (mux::CameraInput &camera : configuration.cameras) {
      camera.masks = false;
      camera.calibration.width *= 4;
      camera.calibration.height *= 4;
      for (double *value :
           {&camera.calibration.fx, &camera.calibration.fy, &camera.calibration.cx, &camera.calibration.cy})
        *value *= 4;
    }
    mux::Options options;
    options.codec = FVV_CODEC_JPEG;
    options.group = 4;
    options.view_loss = 0.1;
    mux::Encoder encoder(configuration, options, [](const void *, size_t) {});
    for (int i = 0; i < 4; i++) {
      mux::Frame frame;
      frame.mesh = ball(i);
      for (int k = 0; k < 2; k++) {
        media::Image picture = media::make_image(256, 192, 3, 100);
        for (size_t at = 0; !plain && at < picture.pixels.size(); at++)
          picture.pixels[at] =
              uint8_t(128 + 60 * std::sin(double(at / 3 % 256) / 5) + 30 * std::sin(double(at / 768) / 3));
        frame.pictures.push_back(std::move(picture));
      }
      encoder.add(frame);
    }
    const mux::Report summary = encoder.finish();
    REQUIRE(summary.view);
    INFO(summary.view->reason);
    CHECK(summary.view->is_measured == !plain);
    CHECK(summary.view->reason.empty() == !plain);
    CHECK(summary.view->loss <= 0.1);
    CHECK(*summary.target_psnr == (plain ? 42 : summary.view->psnr));
    CHECK(summary.view->psnr < 42);
  }
}

TEST_CASE("pushed frames are not looked at beforehand unless an option asks for it") {
  mux::Options options;
  options.codec = FVV_CODEC_JPEG;
  mux::Encoder encoder(two_cameras(), options, [](const void *, size_t) {});
  for (int i = 0; i < 2; i++) encoder.add(frame_of(i, 4));
  const mux::Report summary = encoder.finish();
  REQUIRE(summary.view);
  CHECK(!summary.view->is_measured);
  CHECK(summary.view->reason.find("view-loss") != std::string::npos);
  CHECK(summary.target_psnr == 42);
}

TEST_CASE("cameras that share too little surface are not matched, and the summary says so") {
  mux::Encoder encoder(two_cameras(), jpeg_options(), [](const void *, size_t) {});
  for (int i = 0; i < 4; i++) encoder.add(frame_of(i, 4));
  const mux::Report summary = encoder.finish();
  CHECK(!summary.match.applied);
  CHECK(summary.match.reason == "no two cameras share enough surface");
}

namespace {

// A ball of which camera 1 is said to see the part with y > 0.1; what camera 3 sees is found by rays.
mux::Frame half_seen(int i) {
  mux::Frame frame;
  frame.mesh = ball(i);
  for (const int value : {100, 140}) frame.pictures.push_back(media::make_image(64, 48, 3, uint8_t(value)));
  frame.visibility.resize(2);
  for (size_t k = 1; k < frame.mesh.positions.size(); k += 3)
    frame.visibility[1].push_back(frame.mesh.positions[k] > 0.1 ? 255 : 0);
  return frame;
}

mux::Configuration half_seen_cameras() {
  mux::Configuration configuration = two_cameras();
  for (mux::CameraInput &camera : configuration.cameras) camera.masks = false;
  configuration.cameras[1].visibility = true;
  return configuration;
}

// By height: y of a vertex, and whether a camera sees it. Only those that face it.
std::multimap<double, bool> seen_by_height(const std::string &path, size_t frame, uint16_t camera) {
  Stream stream(path);
  OwnedMesh mesh;
  stream.mesh(frame, mesh);
  const fvv_scene &scene = stream.configuration().scene;
  const auto height = [&](uint32_t v) {
    return scene.lattice_origin[1] + scene.lattice_step * mesh.lattice[3 * size_t(v) + 1];
  };
  std::multimap<double, bool> out;
  const fvv_visibility *found = stream.visibility(frame);
  REQUIRE(found);
  for (size_t c = 0; c < found->header.camera_count; c++)
    for (uint32_t k = 0; k < found->header.vertex_count && found->cameras[c] == camera; k++) {
      const uint8_t state = found->states[c * found->header.vertex_count + k];
      if (state != FVV_VERTEX_BACKFACING) out.emplace(height(k), FVV_VERTEX_IS_SEEN(state));
    }
  return out;
}

} // namespace

TEST_CASE("visibility that comes with frames is sent, and rays find that of the other cameras") {
  const Folder folder;
  for (const mux::Visibility wanted : {mux::Visibility::weights, mux::Visibility::automatic})
    for (const bool keep : {true, false}) {
      CAPTURE(int(wanted), keep);
      mux::Options options = jpeg_options();
      options.visibility = wanted;
      options.keep_geometry = keep;
      if (!keep) options.triangles = 200;
      std::string bytes;
      mux::Encoder encoder(half_seen_cameras(), options, [&](const void *part, size_t size) {
        bytes.append(static_cast<const char *>(part), size);
      });
      for (int i = 0; i < 5; i++) encoder.add(half_seen(i));
      const mux::Report summary = encoder.finish();
      CHECK(summary.visibility_choice.sent);
      write_bytes(folder.path("out.fvv"), bytes.data(), bytes.size());
      for (const size_t frame : {0u, 3u, 4u}) {
        size_t wrong = 0, far = 0, hidden = 0;
        for (const auto &[y, seen] : seen_by_height(folder.path("out.fvv"), frame, 1)) {
          if (std::abs(y - 0.1) < 0.12) continue; // vertices of the decimated mesh lie between
          far++;
          wrong += seen != (y > 0.1);
        }
        for (const auto &[y, seen] : seen_by_height(folder.path("out.fvv"), frame, 3)) hidden += !seen;
        CHECK(far > 20);
        CHECK(wrong == 0);
        CHECK(hidden <= 1); // all of a ball that faces a camera is seen, but for its rim
      }
    }
}

TEST_CASE("visibility that does not fit the mesh is refused") {
  const auto refusal_of = [](const std::function<void(mux::Configuration &, mux::Frame &)> &spoil) {
    mux::Configuration configuration = half_seen_cameras();
    mux::Frame frame = half_seen(0);
    spoil(configuration, frame);
    try {
      mux::Encoder encoder(configuration, jpeg_options(), [](const void *, size_t) {});
      encoder.add(frame);
    } catch (const fvv::Error &error) {
      return error.in(fvv::Spelling::command_line);
    }
    return std::string();
  };
  using C = mux::Configuration;
  using F = mux::Frame;
  CHECK(refusal_of([](C &, F &) {}).empty());
  CHECK(refusal_of([](C &, F &f) { f.visibility[1].pop_back(); }) ==
        "frame 0: camera 1: expected the visibility of 178 vertices, found 177");
  CHECK(refusal_of([](C &, F &f) { f.visibility.clear(); }) ==
        "frame 0: camera 1: expected the visibility of 178 vertices, found 0");
  CHECK(refusal_of([](C &, F &f) { f.visibility.pop_back(); }) ==
        "frame 0: expected 2 visibility arrays, one for each camera, found 1");
  CHECK(refusal_of([](C &c, F &) { c.meshes = false; }) == "encoder: camera 1: visibility needs meshes");
  // An empty stage has nothing to see.
  CHECK(refusal_of([](C &, F &f) { f.mesh = {}, f.visibility.clear(); }).empty());
}

TEST_CASE("sound of the configuration is in the groups that it falls into") {
  const Folder folder;
  mux::Configuration configuration = two_cameras();
  std::vector<float> samples(48000);
  for (size_t i = 0; i < samples.size(); i++) samples[i] = float(0.5 * std::sin(double(i) * 0.05));
  configuration.sounds.push_back({mux::sound_of_samples(samples, 1, 0.16).packets, "tone", "en"});
  configuration.sounds.push_back({configuration.sounds[0].packets, "", "", std::array<double, 3>{1, 2, 3}});
  std::string bytes;
  std::vector<std::string> warnings;
  mux::Observer observer;
  observer.on_warning = [&](const std::string &text) { warnings.push_back(text); };
  const auto run = [&](int count) {
    bytes.clear();
    mux::Encoder encoder(
        configuration, jpeg_options(),
        [&](const void *part, size_t size) { bytes.append(static_cast<const char *>(part), size); },
        observer);
    for (int i = 0; i < count; i++) encoder.add(frame_of(i, 4));
    return encoder.finish();
  };
  const mux::Report summary = run(10);
  REQUIRE(summary.sounds.size() == 2);
  CHECK(summary.sounds[0].chunks == 3); // the packet before the sound begins in tick 3
  CHECK(warnings.size() == 2);          // both go on after the last frame
  CHECK(warnings[1] == "encoder: audio: sound 1: its sound goes on after the last frame and is cut there");
  CHECK(summary.warned);
  write_bytes(folder.path("out.fvv"), bytes.data(), bytes.size());
  Stream stream(folder.path("out.fvv"));
  CHECK(stream.configuration().sound_count == 2);
  warnings.clear();
  run(40);
  CHECK(warnings.empty());
  configuration.sounds[0].packets = nullptr;
  CHECK_THROWS_WITH(run(1), "encoder: sound 0: expected packets, found none");
  configuration.sounds.erase(configuration.sounds.begin());
  configuration.sounds[0].per_frame = {{0, 0, 0}};
  CHECK_THROWS_WITH(run(2), "frame 1: sound 0 moves, and has no position here");
}
