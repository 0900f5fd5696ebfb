// The conformance vector of cameras that move: how it is made, and that libfvv reads it as the decoder does
// that was written from the specification.
#include "stream_fixture.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>

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
  stream.configuration = {scene_chunk(), track_chunk(3, FVV_TRACK_CALIBRATION)};
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

// Not run by default: test_stream '[make]' writes the vector anew, where the format has changed.
TEST_CASE("write the vector of cameras that move", "[.][make]") {
  write_vector(FVV_CALIBRATION_VECTORS "/moving.fvv", vector_stream());
}

TEST_CASE(
    "the vector of cameras that move is written as it was, and its cameras are those of the plain decoder") {
  std::ifstream file(FVV_CALIBRATION_VECTORS "/moving.fvv", std::ios::binary),
      list(FVV_CALIBRATION_VECTORS "/moving.crc");
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
