// fvvmux, then fvvdemux: cameras that move.
#include "mux_fixture.h"

#include "fvvdemux/demux.h"

namespace {

// Camera 1 pans, walks and zooms, with a lens that breathes; camera 2 is a pinhole that zooms.
scene::Capture moving_capture(const Folder &folder) {
  scene::Capture capture = make_capture(folder);
  for (const int64_t number : capture.frames.numbers()) {
    const double t = double(number);
    fvv_camera one = capture.cameras[1].calibration, two = capture.cameras[2].calibration;
    one.name = two.name = nullptr;
    one.name_size = two.name_size = 0;
    one.fx *= 1 + 0.3 * t;
    one.fy *= 1 + 0.3 * t;
    one.lens = FVV_LENS_RADTAN;
    one.distortion[0] = -0.1 + 0.01 * t;
    one.r_max = 0.75;
    const double a = M_PI / 2 + 0.02 * t;
    const double rotation[9] = {std::cos(a), 0, -std::sin(a), 0, -1, 0, -std::sin(a), 0, -std::cos(a)};
    std::memcpy(one.rotation, rotation, sizeof rotation);
    one.translation[1] = 0.1 * t;
    two.fx *= 1 + 0.1 * t;
    capture.cameras[1].per_frame[number] = one;
    capture.cameras[2].per_frame[number] = two;
  }
  const fvv_camera &first = capture.cameras[1].per_frame.begin()->second;
  fvv_camera &base = capture.cameras[1].calibration;
  base.lens = first.lens;
  std::copy(first.distortion, first.distortion + 8, base.distortion);
  base.r_max = first.r_max;
  scene::write_capture(capture, capture.path);
  return capture;
}

// Pixels between where two cameras see a point of the ball, at most.
double difference(const fvv_camera &a, const fvv_camera &b, int64_t frame) {
  const geometry::Mesh mesh = ball(frame);
  double worst = 0;
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    double p[2], q[2];
    if (!fvv_camera_project(&a, &mesh.positions[3 * v], p, nullptr)) continue;
    REQUIRE(fvv_camera_project(&b, &mesh.positions[3 * v], q, nullptr));
    worst = std::max(worst, std::hypot(p[0] - q[0], p[1] - q[1]));
  }
  return worst;
}

fvv_status append(void *user, const void *data, size_t size) {
  static_cast<std::string *>(user)->append(static_cast<const char *>(data), size);
  return FVV_OK;
}

// The stream without the first entry of the calibration at a time, where nothing else may change.
std::string without_first_camera(const std::string &stream, int64_t time) {
  std::string out;
  const fvv_output output = {append, &out};
  fvv_writer *writer = nullptr;
  fvv_reader *reader = nullptr;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK);
  REQUIRE(fvv_reader_create(nullptr, nullptr, 0, &reader) == FVV_OK);
  REQUIRE(fvv_reader_push(reader, stream.data(), stream.size()) == FVV_OK);
  fvv_reader_finish(reader);
  fvv_event event;
  while (fvv_reader_next(reader, &event, nullptr) == FVV_OK) {
    if (event.kind != FVV_EVENT_CHUNK) continue;
    const fvv_chunk_header &h = event.chunk;
    std::vector<uint8_t> payload(event.payload, event.payload + h.size);
    if (h.type == FVV_CHUNK_CALIBRATION && h.time == time) {
      REQUIRE(payload[6] == 2);
      // One entry, of camera 23 with lens model none: 13 values, all as before.
      payload[6] = 1;
      payload.resize(8);
      payload.push_back(23);
      payload.insert(payload.end(), 13, 0);
    }
    fvv_status status = FVV_OK;
    int64_t range[2];
    if (h.type == FVV_CHUNK_GROUP) {
      std::memcpy(range, payload.data() + 8, sizeof range);
      status = fvv_writer_begin_group(writer, range[0], range[1], nullptr);
    } else if (h.type == FVV_CHUNK_GROUP_END) {
      status = fvv_writer_end_group(writer, nullptr);
    } else if (h.type == FVV_CHUNK_INDEX) {
      status = fvv_writer_finish(writer, nullptr);
    } else if (h.type == FVV_CHUNK_MESH || h.type == FVV_CHUNK_VIDEO_PACKET ||
               h.type == FVV_CHUNK_CALIBRATION || h.type == FVV_CHUNK_COLOURS) {
      status = fvv_writer_chunk(writer, h.type, h.track, h.flags & FVV_FLAG_KEY, h.time, payload.data(),
                                payload.size(), nullptr);
    } else if (h.type != FVV_CHUNK_FOOTER) {
      status = fvv_writer_configuration(writer, h.type, h.track, 0, payload.data(), payload.size(), nullptr);
    }
    REQUIRE(status == FVV_OK);
  }
  fvv_reader_destroy(reader);
  fvv_writer_destroy(writer);
  return out;
}

} // namespace

TEST_CASE("cameras that move go into a stream and come out of it within a twentieth of a pixel") {
  const Folder folder;
  const scene::Capture source = moving_capture(folder);
  FileOptions options = options_for(folder);
  options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(!summary.warned);
  CHECK(summary.calibration.chunks == 5);
  REQUIRE(summary.verdict);
  CHECK(summary.verdict->cameras == 3);
  CHECK((summary.verdict->moving_reprojection > 0 && summary.verdict->moving_reprojection < 0.05));
  CHECK(summary.verdict->max_reprojection == 0);
  demux::Options all;
  demux::Result result;
  demux::demux(options.output, folder.path("back"), all, result);
  CHECK(result.warnings.empty());
  const scene::Capture back = scene::load_capture(folder.path("back/capture.json"));
  REQUIRE(back.cameras.size() == 3);
  CHECK_FALSE(back.cameras[0].moves());
  for (const size_t k : {1, 2}) {
    REQUIRE(back.cameras[k].moves());
    CHECK(back.cameras[k].per_frame.size() == 5);
    for (const int64_t number : source.frames.numbers()) {
      const fvv_camera found = back.cameras[k].calibration_at(number);
      CHECK(difference(source.cameras[k].calibration_at(number), found, number) < 0.05);
      CHECK(found.fx > 0.9 * source.cameras[k].calibration_at(number).fx);
    }
    CHECK(back.cameras[k].calibration_at(4).fx > 1.3 * back.cameras[k].calibration_at(0).fx);
  }
  CHECK(std::isinf(back.cameras[2].calibration_at(3).r_max));
  // What came out goes in again.
  options.capture = folder.path("back");
  options.output = folder.path("again.fvv");
  CHECK(mux_file(options).verdict->moving_reprojection < 0.05);
}

TEST_CASE("streams with cameras that move are the same bytes for any number of threads") {
  const Folder folder;
  moving_capture(folder);
  FileOptions options = options_for(folder);
  options.threads = 1;
  mux_file(options);
  const std::string one = read_bytes(options.output);
  options.threads = 4;
  mux_file(options);
  CHECK(read_bytes(options.output) == one);
}

TEST_CASE("verification notices a camera that moves elsewhere") {
  const Folder folder;
  moving_capture(folder);
  FileOptions options = options_for(folder);
  options.verify = true; // Encoded::origins
  Encoded written = encode_file(options);
  CHECK_NOTHROW(written.verify(options.output));
  written.plan.capture.cameras[1].per_frame.at(3).cx += 0.1;
  CHECK_THROWS_WITH(written.verify(options.output),
                    Catch::Contains("frame 3: camera 13 is not the camera of the capture"));
}

TEST_CASE(
    "a camera that another writer left without calibration in a frame comes out as one that is lost there") {
  const Folder folder;
  moving_capture(folder);
  FileOptions options = options_for(folder);
  mux_file(options);
  const std::string cut = without_first_camera(read_bytes(options.output), 3);
  write_bytes(options.output, cut.data(), cut.size());
  demux::Options all;
  demux::Result result;
  demux::demux(options.output, folder.path("back"), all, result);
  CHECK(result.losses.empty());
  CHECK(result.warnings.empty());
  const scene::Capture back = scene::load_capture(folder.path("back/capture.json"));
  REQUIRE(back.cameras.size() == 3);
  CHECK(back.cameras[1].lost == std::set<int64_t>{3});
  CHECK(back.cameras[1].per_frame.size() == 4);
  CHECK(back.cameras[2].per_frame.size() == 5);
}

TEST_CASE("cameras that are not calibrated in the first frame have neighbours and a share of pixels") {
  const Folder folder;
  scene::Capture source = moving_capture(folder);
  source.cameras[1].per_frame.erase(0);
  source.cameras[1].lost.insert(0);
  scene::write_capture(source, source.path);
  FileOptions options = options_for(folder);
  options.crop = mux::Crop::automatic;
  options.video_tracks = 2;
  CHECK(mux::make_plan(options, {}).tile_track_count() == 2);
  options.video_tracks = 1;
  options.video_pixels = 6000;
  CHECK(mux::make_plan(options, {}).tile_track_count() == 1);
}

TEST_CASE("frames in which a camera lost its calibration are frames without it, there and back") {
  const Folder folder;
  scene::Capture source = moving_capture(folder);
  for (const int64_t frame : {0, 1, 3}) { // the first of all, the first of a group, and one between
    source.cameras[1].per_frame.erase(frame);
    source.cameras[1].lost.insert(frame);
  }
  scene::write_capture(source, source.path);
  FileOptions options = options_for(folder);
  options.verify = true;
  options.group = 2;
  Encoded encoded = encode_file(options);
  CHECK(!encoded.report.warned);
  CHECK(encoded.verify(options.output).moving_reprojection < 0.05);
  demux::Options all;
  demux::Result result;
  demux::demux(options.output, folder.path("back"), all, result);
  CHECK((result.losses.empty() && result.warnings.empty()));
  const scene::Capture back = scene::load_capture(folder.path("back/capture.json"));
  REQUIRE(back.cameras.size() == 3);
  CHECK(back.cameras[1].lost == std::set<int64_t>{0, 1, 3});
  CHECK(difference(source.cameras[1].calibration_at(4), back.cameras[1].calibration_at(4), 4) < 0.05);
  // A stream that calibrates it nevertheless is detected.
  encoded.plan.capture.cameras[1].lost.insert(2);
  CHECK_THROWS_WITH(encoded.verify(options.output),
                    Catch::Contains("frame 2: camera 13 is calibrated, and lost in the capture"));
  options.capture = folder.path("back");
  options.output = folder.path("again.fvv");
  options.undistort = true;
  CHECK(mux_file(options).verdict->moving_reprojection < 0.05);
}
