// Visibility of cameras that move: their centres come from the calibration of the same time, and without one
// they have no bits.
#include "checked.h"
#include "visibility_fixture.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>

namespace {

constexpr int frames = 5;
constexpr uint16_t mesh_track = 1, face_track = 2, calibration_track = 4;
const fvv_calibration_bits bits = {16, 9, 3, 18};

// Camera 2 stands still, 7 travels and turns, 9 travels and is lost in frame 2.
fvv_camera camera_at(uint16_t id, int t) {
  fvv_camera camera = upright_camera(id);
  camera.flags = id == 2 ? 0 : FVV_CAMERA_MOVES;
  if (id == 7) {
    // The quaternion (2, 0, 0, t) turns about z; from integers, as every machine has them.
    const double n = 4 + t * t;
    camera.rotation[0] = camera.rotation[4] = (4 - t * t) / n;
    camera.rotation[3] = 4 * t / n;
    camera.rotation[1] = -camera.rotation[3];
  }
  camera.translation[0] = id == 2 ? -0.25 : id == 7 ? 0.5 - 0.5 * t : 1.25;
  camera.translation[1] = id == 9 ? 0.75 * t - 1.5 : -0.125;
  camera.translation[2] = id == 2 ? -0.625 : 0.5 + 0.25 * t;
  return camera;
}

std::vector<uint16_t> cameras_in(int t) {
  return t == 2 ? std::vector<uint16_t>{2, 7} : std::vector<uint16_t>{2, 7, 9};
}

std::unique_ptr<fvv_calibration, void (*)(fvv_calibration *)> calibration() {
  const fvv_camera cameras[] = {camera_at(7, 0), camera_at(9, 0)};
  fvv_calibration *created = nullptr;
  REQUIRE(fvv_calibration_create(cameras, 2, nullptr, &created) == FVV_OK);
  return {created, fvv_calibration_destroy};
}

// As decoders have it, which know its values to steps.
fvv_camera decoded_camera(uint16_t id, int t) {
  fvv_camera camera = camera_at(id, t);
  if (!camera.flags) return camera;
  const auto encoder = calibration();
  fvv_bytes payload = {};
  REQUIRE(fvv_calibration_encode(encoder.get(), &bits, &camera, 1, 1, &payload, nullptr) == FVV_OK);
  fvv_bytes_free(&payload);
  REQUIRE(fvv_calibration_camera(encoder.get(), id, &camera) == FVV_OK);
  return camera;
}

void centre_of(uint16_t id, int t, int32_t centre[3]) {
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  const fvv_camera camera = decoded_camera(id, t);
  REQUIRE(fvv_visibility_centre(&camera, &scene, centre, nullptr) == FVV_OK);
}

// From the definition.
Bytes states_of(const fvv_mesh &mesh, uint16_t id, int t) {
  int32_t centre[3];
  centre_of(id, t, centre);
  Bytes row(mesh.face_count);
  fvv_visibility_facing(&mesh, FVV_VISIBILITY_FACES, centre, FVV_VISIBILITY_THRESHOLD, row.data());
  for (size_t i = 0; i < row.size(); i++)
    if (row[i])
      row[i] = is_seen(mesh, FVV_VISIBILITY_FACES, i, id % 3, t) ? FVV_ELEMENT_SEEN : FVV_ELEMENT_HIDDEN;
  return row;
}

Bytes visibility_payload(const fvv_mesh &mesh, const std::vector<uint16_t> &cameras, int t) {
  std::vector<Bytes> seen, former;
  std::vector<fvv_visibility_view> views;
  for (const uint16_t id : cameras) {
    Bytes row(mesh.face_count);
    for (size_t i = 0; i < row.size(); i++) row[i] = is_seen(mesh, FVV_VISIBILITY_FACES, i, id % 3, t);
    seen.push_back(row);
    const std::vector<uint16_t> before = cameras_in(t - 1);
    const bool was = t && std::count(before.begin(), before.end(), id);
    Sheet sheet(0, t - 1);
    former.push_back(was ? states_of(sheet.mesh(), id, t - 1) : Bytes());
  }
  for (size_t c = 0; c < cameras.size(); c++) {
    views.push_back(
        {cameras[c], {}, seen[c].data(), former[c].empty() ? nullptr : former[c].data(), nullptr});
    centre_of(cameras[c], t, views.back().centre);
  }
  const fvv_visibility_header header = {
      FVV_VISIBILITY_FACES, FVV_VISIBILITY_THRESHOLD, mesh_track, 0, uint32_t(t), 0};
  return encoded(mesh, header, views);
}

// Each frame is a raw mesh, a calibration, and what the cameras that are calibrated see.
Stream moving_stream() {
  Stream out;
  out.configuration = {scene_chunk(), track_chunk(mesh_track, FVV_TRACK_MESH),
                       track_chunk(face_track, FVV_TRACK_VISIBILITY),
                       track_chunk(calibration_track, FVV_TRACK_CALIBRATION)};
  for (const uint16_t id : {2, 7, 9}) out.configuration.push_back(camera_chunk(camera_at(id, 0)));
  const auto encoder = calibration();
  Group group = {0, 2 * frames, {}};
  fvv_bytes payload = {};
  for (int t = 0; t < frames; t++) {
    Sheet sheet(0, t);
    const fvv_mesh mesh = sheet.mesh();
    std::vector<fvv_camera> moving;
    for (const uint16_t id : cameras_in(t))
      if (id != 2) moving.push_back(camera_at(id, t));
    const uint8_t flags = t ? 0 : FVV_FLAG_KEY;
    REQUIRE(fvv_mesh_encode(&mesh, FVV_MESH_RAW, 0, nullptr, &payload, nullptr) == FVV_OK);
    group.chunks.push_back({FVV_CHUNK_MESH, mesh_track, FVV_FLAG_KEY, 2 * t, bytes_of(payload)});
    REQUIRE(fvv_calibration_encode(encoder.get(), &bits, moving.data(), moving.size(), t == 0, &payload,
                                   nullptr) == FVV_OK);
    group.chunks.push_back({FVV_CHUNK_CALIBRATION, calibration_track, flags, 2 * t, bytes_of(payload)});
    group.chunks.push_back(
        {FVV_CHUNK_VISIBILITY, face_track, flags, 2 * t, visibility_payload(mesh, cameras_in(t), t)});
  }
  fvv_bytes_free(&payload);
  out.groups.push_back(group);
  return out;
}

// The states of all cameras of a frame, or why there are none.
fvv_status frame(Opened &opened, int t, Bytes &states) {
  const fvv_visibility *got = nullptr;
  const fvv_status status =
      fvv_stream_visibility(opened.stream, size_t(t), face_track, &got, &opened.diagnostic);
  if (status == FVV_OK)
    states.assign(got->states, got->states + size_t(got->header.camera_count) * got->header.element_count);
  return status;
}

Bytes wanted(int t) {
  Bytes out;
  Sheet sheet(0, t);
  for (const uint16_t id : cameras_in(t)) {
    const Bytes row = states_of(sheet.mesh(), id, t);
    out.insert(out.end(), row.begin(), row.end());
  }
  return out;
}

} // namespace

TEST_CASE("bits of cameras that move are those of where they are, in any order of frames") {
  const Bytes bytes = write(moving_stream());
  Opened opened(bytes);
  REQUIRE(opened.status == FVV_OK);
  for (const int t : {0, 1, 2, 3, 4, 4, 2, 3, 0, 4, 1}) {
    Bytes states;
    REQUIRE(frame(opened, t, states) == FVV_OK);
    CHECK(states == wanted(t));
    // Asking for cameras and meshes in between changes nothing.
    fvv_camera camera;
    CHECK(fvv_stream_camera(opened.stream, size_t(t), 9, &camera, nullptr) == (t == 2 ? FVV_END : FVV_OK));
  }
  for (const size_t step : {size_t(0), size_t(1), size_t(57)}) {
    Check how;
    how.step = step;
    const Checked checked(bytes, how);
    INFO(checked.report());
    CHECK(checked.summary().problems == 0);
    CHECK(checked.summary().whole_frames == frames);
  }
}

TEST_CASE("6003: bits of a camera that is not calibrated at that time") {
  struct Fault {
    const char *name;
    void (*spoil)(Stream &);
    int first; // frame that is wrong; those behind it depend on it
  };
  const Fault faults[] = {
      {"no calibration at this time",
       [](Stream &s) { s.groups[0].chunks.erase(s.groups[0].chunks.begin() + 13); }, 4},
      {"a calibration without the camera",
       [](Stream &s) {
         Sheet sheet(0, 2);
         s.groups[0].chunks[8].payload = visibility_payload(sheet.mesh(), {2, 7, 9}, 2);
       },
       2},
  };
  for (const Fault &fault : faults) {
    INFO(fault.name);
    Stream stream = moving_stream();
    fault.spoil(stream);
    const Bytes bytes = write(stream);
    const Checked checked(bytes);
    INFO(checked.report());
    REQUIRE(checked.summary().problems >= 1);
    CHECK(fvv_checker_problem(checked.checker, 0)->issue == FVV_ISSUE_VISIBILITY_CAMERA);
    CHECK(checked.summary().whole_frames == uint64_t(fault.first));
    Opened opened(bytes);
    Bytes states;
    for (int t = 0; t < fault.first; t++) CHECK(frame(opened, t, states) == FVV_OK);
    CHECK(frame(opened, fault.first, states) == FVV_ERROR_INVALID);
    CHECK(opened.diagnostic.issue == FVV_ISSUE_VISIBILITY_CAMERA);
  }
}

TEST_CASE("the calibration stands in front of the visibility that needs it") {
  Stream stream = moving_stream();
  std::swap(stream.groups[0].chunks[1], stream.groups[0].chunks[2]);
  const Checked checked(write(stream));
  REQUIRE(checked.summary().problems == 1);
  CHECK(fvv_checker_problem(checked.checker, 0)->issue == FVV_ISSUE_VISIBILITY_CAMERA);
}

TEST_CASE("behind a damaged calibration no bits of cameras that move are given") {
  const Bytes good = write(moving_stream());
  const auto places = chunks_of(good);
  for (size_t t = 0; t < frames; t++) {
    Bytes bad = good;
    bad[places[8 + 3 * t + 1].offset + 41] ^= 4;
    const Checked checked(bad);
    INFO(checked.report());
    CHECK(checked.summary().problems == 1);
    CHECK(checked.summary().whole_frames == t);
    Opened opened(bad);
    for (size_t f = 0; f < frames; f++) {
      Bytes states;
      const fvv_status status = frame(opened, int(f), states);
      CHECK((status == FVV_OK) == (f < t));
      if (status == FVV_OK) CHECK(states == wanted(int(f)));
    }
  }
}

// Not run by default: test_stream '[make]' writes the vector anew, where the format has changed.
TEST_CASE("write the vector of visibility of cameras that move", "[.][make]") {
  write_vector(FVV_VISIBILITY_VECTORS "/moving.fvv", write(moving_stream()));
}

TEST_CASE("visibility of cameras that move is that of the decoder that was written from the specification") {
  std::ifstream file(FVV_VISIBILITY_VECTORS "/moving.fvv", std::ios::binary);
  std::ifstream list(FVV_VISIBILITY_VECTORS "/moving.crc");
  Opened opened(Bytes(std::istreambuf_iterator<char>(file), {}));
  REQUIRE(opened.status == FVV_OK);
  CHECK(opened.bytes == write(moving_stream()));
  int count = 0;
  std::string crc;
  for (; list >> crc; count++) {
    Bytes states;
    REQUIRE(frame(opened, count, states) == FVV_OK);
    CHECK(fvv_crc32c(0, states.data(), states.size()) == std::stoul(crc, nullptr, 16));
  }
  CHECK(count == frames);
}
