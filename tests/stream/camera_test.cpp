// Cameras that move, in streams: random access, and what the checker says.
#include "checked.h"

#include <algorithm>
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
