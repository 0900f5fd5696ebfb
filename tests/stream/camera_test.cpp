// Cameras that move, in streams: random access, the checker, and the conformance vector.
#include "stream_fixture.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>

namespace {

fvv_camera camera_at(uint16_t id, double focal) {
  fvv_camera camera = {};
  camera.id = id;
  camera.flags = FVV_CAMERA_MOVES;
  camera.width = 32;
  camera.height = 16;
  camera.fx = camera.fy = focal;
  camera.cx = 16;
  camera.cy = 8;
  camera.r_max = 2;
  for (const int i : {0, 4, 8}) camera.rotation[i] = 1;
  return camera;
}

Chunk moving_camera_chunk(uint16_t id) {
  return camera_chunk(camera_at(id, 20));
}

// Camera 1 has the focal length 20 + number of the frame; there is no calibration in each group's second
// frame and no entry in its third.
Stream moving_stream(int groups) {
  Stream out = good_stream(groups);
  out.configuration.insert(out.configuration.begin() + 3, track_chunk(3, FVV_TRACK_CALIBRATION));
  for (Chunk &chunk : out.configuration)
    if (chunk.type == FVV_CHUNK_CAMERA && chunk.payload[0] == 1) chunk = moving_camera_chunk(1);
  const fvv_camera base = camera_at(1, 20);
  fvv_calibration *created = nullptr;
  REQUIRE(fvv_calibration_create(&base, 1, nullptr, &created) == FVV_OK);
  const std::unique_ptr<fvv_calibration, void (*)(fvv_calibration *)> calibration(created,
                                                                                  fvv_calibration_destroy);
  const fvv_calibration_bits bits = {20, 10, 4, 20};
  for (Group &group : out.groups) {
    // Two frames more, so that there is something to follow.
    group.end += 4;
    for (const int64_t time : {group.end - 4, group.end - 2}) group.chunks.push_back(mesh_chunk(time, 1));
    std::vector<Chunk> chunks;
    int64_t last = INT64_MIN;
    int frame = 0;
    for (const Chunk &chunk : group.chunks) {
      chunks.push_back(chunk);
      if (chunk.time == last) continue;
      last = chunk.time;
      const int number = frame++;
      if (number == 1) continue;
      const fvv_camera now = camera_at(1, 20 + number);
      fvv_bytes payload = {};
      REQUIRE(fvv_calibration_encode(calibration.get(), &bits, &now, number != 2, number == 0, &payload,
                                     nullptr) == FVV_OK);
      chunks.push_back({FVV_CHUNK_CALIBRATION, 3, uint8_t(number ? 0 : FVV_FLAG_KEY), chunk.time,
                        Bytes(payload.data, payload.data + payload.size)});
      fvv_bytes_free(&payload);
    }
    group.chunks = chunks;
  }
  for (size_t g = 0; g < out.groups.size(); g++) {
    out.groups[g].start += 4 * int64_t(g);
    out.groups[g].end += 4 * int64_t(g);
    for (Chunk &chunk : out.groups[g].chunks) chunk.time += 4 * int64_t(g);
  }
  return out;
}

// The chunk of a group's list that is the n-th calibration.
Chunk &calibration_of(Group &group, size_t n) {
  for (Chunk &chunk : group.chunks)
    if (chunk.type == FVV_CHUNK_CALIBRATION && !n--) return chunk;
  FAIL("no such chunk");
  return group.chunks[0];
}

uint32_t first_issue(const Bytes &bytes) {
  const Checked checked(bytes);
  return fvv_checker_problem_count(checked.checker) ? fvv_checker_problem(checked.checker, 0)->issue : 0;
}

} // namespace

TEST_CASE("a camera that moves is found by frame, in any order") {
  for (const bool repeat : {false, true}) {
    Stream source = moving_stream(3);
    source.repeat = repeat;
    Opened opened(write(source));
    REQUIRE(opened.stream);
    REQUIRE(fvv_stream_frame_count(opened.stream) == 15);
    for (const size_t frame : {0, 1, 2, 3, 4, 5, 6, 14, 13, 8, 9, 3, 3, 7, 0, 12, 11, 10, 4}) {
      INFO("frame " << frame);
      fvv_camera camera = {};
      fvv_diagnostic diagnostic = {};
      const fvv_status status = fvv_stream_camera(opened.stream, frame, 1, &camera, &diagnostic);
      const size_t number = frame % 5;
      REQUIRE(status == (number == 1 || number == 2 ? FVV_END : FVV_OK));
      if (status == FVV_OK) CHECK(camera.fx == double(20 + number));
      CHECK(fvv_stream_camera(opened.stream, frame, 0, &camera, nullptr) == FVV_OK);
      CHECK(camera.fx == 20);
      CHECK(fvv_stream_camera(opened.stream, frame, 9, &camera, &diagnostic) == FVV_ERROR_ARGUMENT);
      fvv_mesh mesh;
      if (fvv_stream_mesh(opened.stream, frame, 1, &mesh, nullptr) == FVV_OK) fvv_mesh_free(&mesh);
    }
  }
}

TEST_CASE("the checker is content with cameras that move and counts their chunks") {
  const Bytes bytes = write(moving_stream(3));
  const Checked checked(bytes);
  INFO(checked.report());
  CHECK(checked.summary().problems == 0);
  CHECK(checked.summary().whole_frames == 15);
  bool found = false;
  for (size_t i = 0; i < fvv_checker_track_count(checked.checker); i++) {
    const fvv_track_summary *track = fvv_checker_track(checked.checker, i);
    if (track->track != 3) continue;
    found = true;
    CHECK((track->kind == FVV_TRACK_CALIBRATION && track->chunks == 12 && track->key_chunks == 3));
  }
  CHECK(found);
}

TEST_CASE("a calibration that is wrong is one problem, and the frames that follow it are not whole") {
  Stream source = moving_stream(2);
  calibration_of(source.groups[0], 1).payload[0] = 7; // numbered 7, expected 1
  const Bytes bytes = write(source);
  const Checked checked(bytes);
  INFO(checked.report());
  CHECK(checked.summary().problems == 1);
  CHECK(first_issue(bytes) == FVV_ISSUE_CALIBRATION_NUMBER);
  CHECK(checked.summary().whole_frames == 7); // lost: frames 2, 3 and 4 of 10
  Opened opened(bytes);
  fvv_camera camera;
  fvv_diagnostic diagnostic = {};
  for (const size_t frame : {0, 4, 3, 0, 5}) {
    const fvv_status status = fvv_stream_camera(opened.stream, frame, 1, &camera, &diagnostic);
    CHECK(status == (frame % 5 ? FVV_ERROR_INVALID : FVV_OK));
    if (status < 0) CHECK(diagnostic.issue == FVV_ISSUE_CALIBRATION_NUMBER);
  }
}

TEST_CASE("each rule of calibration chunks is found by the checker") {
  const auto with = [](size_t at, uint8_t value) {
    Stream source = moving_stream(1);
    calibration_of(source.groups[0], 0).payload[at] = value;
    return first_issue(write(source));
  };
  CHECK(with(2, 3) == FVV_ISSUE_CALIBRATION_PAYLOAD);
  CHECK(with(8, 0) == FVV_ISSUE_CALIBRATION_CAMERA); // camera 0 does not move
  CHECK(with(0, 1) == FVV_ISSUE_CALIBRATION_NUMBER);
  CHECK(with(12, 4) == FVV_ISSUE_CALIBRATION_RANGE);     // q0 is 4
  CHECK(with(19, 0x81) == FVV_ISSUE_CALIBRATION_RESULT); // fx is negative
}

TEST_CASE("a block has a calibration track exactly when a camera moves") {
  Stream without = moving_stream(1), idle = moving_stream(1), two = moving_stream(1);
  const auto leave_out = [](Stream &stream) {
    std::vector<Chunk> &chunks = stream.groups[0].chunks;
    chunks.erase(std::remove_if(chunks.begin(), chunks.end(),
                                [](const Chunk &c) { return c.type == FVV_CHUNK_CALIBRATION; }),
                 chunks.end());
  };
  leave_out(without);
  without.configuration.erase(without.configuration.begin() + 3);
  CHECK(first_issue(write(without)) == FVV_ISSUE_CONFIGURATION_CALIBRATION);
  leave_out(idle);
  for (Chunk &chunk : idle.configuration)
    if (chunk.type == FVV_CHUNK_CAMERA) chunk = camera_chunk(chunk.payload[0]);
  CHECK(first_issue(write(idle)) == FVV_ISSUE_CONFIGURATION_CALIBRATION);
  two.configuration.insert(two.configuration.begin() + 3, track_chunk(4, FVV_TRACK_CALIBRATION));
  CHECK(first_issue(write(two)) == FVV_ISSUE_CONFIGURATION_CALIBRATION);
}

TEST_CASE("calibrations survive the failure of any allocation, and any changed byte is noticed") {
  const Bytes bytes = write(moving_stream(2));
  for (int64_t left = 0; left < 200; left++) {
    with_failing_memory(left, [&](const fvv_allocator *allocator) {
      Opened opened(bytes, allocator);
      fvv_camera camera;
      for (const size_t frame : {4, 8})
        if (opened.stream) (void)!fvv_stream_camera(opened.stream, frame, 1, &camera, nullptr);
      Check how;
      how.allocator = allocator;
      const Checked checked(bytes, how);
    });
  }
  for (size_t at = 24; at < bytes.size(); at += 3) {
    Bytes bad = bytes;
    bad[at] ^= 0x10;
    const Checked checked(bad);
    CHECK(checked.summary().problems > 0);
  }
}

// ---- The conformance vector of cameras that move: how it is made, and that libfvv reads it as the decoder
// does that was written from the specification.

namespace {

constexpr int frames = 8, groups = 2;

// One that turns about an axis by an angle, at a place. Nothing here comes from sin and cos: the quaternion
// is made of integers, so that every machine makes the same vector.
fvv_camera placed(fvv_camera camera, double a, double b, double c, double d, double x, double y, double z) {
  const double n = a * a + b * b + c * c + d * d;
  const double r[9] = {(a * a + b * b - c * c - d * d) / n,
                       2 * (b * c - a * d) / n,
                       2 * (b * d + a * c) / n,
                       2 * (b * c + a * d) / n,
                       (a * a - b * b + c * c - d * d) / n,
                       2 * (c * d - a * b) / n,
                       2 * (b * d - a * c) / n,
                       2 * (c * d + a * b) / n,
                       (a * a - b * b - c * c + d * d) / n};
  for (int i = 0; i < 9; i++) camera.rotation[i] = r[i];
  for (int i = 0; i < 3; i++) camera.translation[i] = -(r[3 * i] * x + r[3 * i + 1] * y + r[3 * i + 2] * z);
  return camera;
}

// Cameras 2 (pinhole, turns through 180 degrees), 300 (radtan, zooms tenfold) and 9 (fisheye, travels).
fvv_camera camera_at(uint16_t id, int frame) {
  fvv_camera camera = {};
  camera.id = id;
  camera.flags = FVV_CAMERA_MOVES;
  camera.lens = id == 2 ? FVV_LENS_NONE : id == 300 ? FVV_LENS_RADTAN : FVV_LENS_FISHEYE;
  camera.width = 1920;
  camera.height = 1080;
  camera.fx = camera.fy = 1000;
  camera.cx = 960.25;
  camera.cy = 540.75;
  const double t = frame;
  if (id == 2) {
    camera.skew = -0.5;
    camera.r_max = frame % 2 ? 1.5 : INFINITY;
    return placed(camera, 4 - t, 0.25, 3, 0.125, 1, 2, -3);
  }
  if (id == 300) {
    camera.fx = camera.fy = 1000 * std::ldexp(1 + t / 8, frame / 3);
    const double coefficients[8] = {-0.1, 0.02, 0.0005, -0.0003, 0.001, 0.01, 0, 0};
    for (int i = 0; i < 8; i++) camera.distortion[i] = coefficients[i] * (1 - t / 40);
    camera.r_max = 0.75;
    return placed(camera, 7, t, -2, 1, -120.5, 1.625, 33);
  }
  camera.distortion[0] = 0.01;
  camera.distortion[1] = -0.002;
  camera.r_max = 1.25;
  return placed(camera, 1, 1, 1, 1, t / 7, 1 - t / 9, 4 + t / 11);
}

// Camera 9 is lost in frames 2 and 3 of each group, and comes back; frame 5 has no calibration at all.
Bytes vector_stream() {
  Stream stream;
  stream.configuration = {scene_chunk(), track_chunk(1, FVV_TRACK_MESH),
                          track_chunk(3, FVV_TRACK_CALIBRATION)};
  std::vector<fvv_camera> constant;
  for (const uint16_t id : {300, 2, 9}) {
    constant.push_back(camera_at(id, 0));
    stream.configuration.push_back(camera_chunk(constant.back()));
  }
  fvv_calibration *created = nullptr;
  REQUIRE(fvv_calibration_create(constant.data(), constant.size(), nullptr, &created) == FVV_OK);
  const std::unique_ptr<fvv_calibration, void (*)(fvv_calibration *)> calibration(created,
                                                                                  fvv_calibration_destroy);
  for (int g = 0; g < groups; g++) {
    const fvv_calibration_bits bits = {uint8_t(g ? 25 : 16), uint8_t(g ? 40 : 9), uint8_t(g ? 36 : 3),
                                       uint8_t(g ? 38 : 18)};
    Group group = {2 * frames * g, 2 * frames * (g + 1), {}};
    for (int f = 0; f < frames; f++) {
      if (f == 5) continue;
      std::vector<fvv_camera> cameras;
      for (const uint16_t id : {2, 9, 300})
        if (id != 9 || (f != 2 && f != 3)) cameras.push_back(camera_at(id, f));
      fvv_bytes payload = {};
      REQUIRE(fvv_calibration_encode(calibration.get(), &bits, cameras.data(), cameras.size(), f == 0,
                                     &payload, nullptr) == FVV_OK);
      group.chunks.push_back(mesh_chunk(group.start + 2 * f, 1));
      group.chunks.push_back({FVV_CHUNK_CALIBRATION, 3, uint8_t(f ? 0 : FVV_FLAG_KEY), group.start + 2 * f,
                              Bytes(payload.data, payload.data + payload.size)});
      fvv_bytes_free(&payload);
    }
    stream.groups.push_back(group);
  }
  return write(stream);
}

uint32_t crc_of(const fvv_camera &c) {
  std::vector<double> numbers = {c.fx, c.fy, c.cx, c.cy, c.skew};
  numbers.insert(numbers.end(), c.distortion, c.distortion + 8);
  numbers.push_back(c.r_max);
  numbers.insert(numbers.end(), c.rotation, c.rotation + 9);
  numbers.insert(numbers.end(), c.translation, c.translation + 3);
  REQUIRE(numbers.size() == 26);
  return fvv_crc32c(0, numbers.data(), numbers.size() * sizeof(double));
}

} // namespace

// Not run by default: test_stream '[make]' writes the vector again, after a change of the format.
TEST_CASE("write the vector of cameras that move", "[.][make]") {
  write_vector(FVV_CASES "/vector_calibration_moving/input.fvv", vector_stream());
}

TEST_CASE(
    "the vector of cameras that move is written as it was, and its cameras are those of the plain decoder") {
  std::ifstream file(FVV_CASES "/vector_calibration_moving/input.fvv", std::ios::binary),
      list(FVV_LISTINGS "/calibration_moving.crc");
  const Opened opened(Bytes(std::istreambuf_iterator<char>(file), {}));
  CHECK(opened.bytes == vector_stream());
  REQUIRE(opened.status == FVV_OK);
  fvv_stream *stream = opened.stream;
  int64_t time;
  uint16_t id;
  std::string crc;
  size_t listed = 0, found = 0;
  while (list >> time >> id >> crc) {
    listed++;
    for (size_t f = 0; f < fvv_stream_frame_count(stream); f++) {
      fvv_frame frame;
      REQUIRE(fvv_stream_frame(stream, f, &frame, nullptr) == FVV_OK);
      if (frame.time != time) continue;
      fvv_camera camera;
      REQUIRE(fvv_stream_camera(stream, f, id, &camera, nullptr) == FVV_OK);
      CHECK(crc_of(camera) == std::stoul(crc, nullptr, 16));
    }
  }
  for (size_t f = 0; f < fvv_stream_frame_count(stream); f++)
    for (const uint16_t which : {2, 9, 300}) {
      fvv_camera camera;
      found += fvv_stream_camera(stream, f, which, &camera, nullptr) == FVV_OK;
    }
  CHECK(listed == 38);
  CHECK(found == listed);
}
