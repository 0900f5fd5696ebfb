// Visibility in a stream: with the mesh of its time, in any order of frames, and nothing wrong after damage.
#include "mesh_of.h"
#include "stream_fixture.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>

namespace {

// A wavy sheet that is folded over itself, a fan about one vertex, and three faces on one edge.
struct Sheet {
  std::vector<int32_t> positions;
  std::vector<uint32_t> faces;
  static constexpr int32_t side = 14;
  explicit Sheet(int group, int t) {
    for (int32_t v = 0; v < side * side; v++) {
      const int32_t x = v % side, y = v / side;
      positions.insert(positions.end(),
                       {20 * x + 3 * t, 25 * y - 100, group + (x * x * 3 + 17 * y * (x + t)) % 60});
    }
    for (uint32_t y = 0; y + 1 < side; y++)
      for (uint32_t x = 0; x + 1 < side; x++) {
        const uint32_t a = y * side + x;
        for (const uint32_t i : {a, a + 1, a + side, a + 1, a + side + 1, a + side}) faces.push_back(i);
      }
    const uint32_t hub = uint32_t(positions.size() / 3);
    positions.insert(positions.end(), {-200, 0, 30});
    for (int32_t i = 0; i < 9; i++) positions.insert(positions.end(), {-300 + 31 * i, 40 * i % 170, 4 * i});
    for (uint32_t i = 0; i < 8; i++) faces.insert(faces.end(), {hub, hub + i + 1, hub + i + 2});
    faces.insert(faces.end(), {0, side, hub, side, 0, hub + 1});
  }
  fvv_mesh mesh() { return mesh_of(positions, faces); }
};

// A pinhole that looks along z from the origin.
fvv_camera upright_camera(uint16_t id) {
  fvv_camera camera = {};
  camera.id = id;
  camera.width = 32;
  camera.height = 16;
  camera.fx = camera.fy = 20;
  camera.cx = 16;
  camera.cy = 8;
  camera.r_max = 2;
  for (const int i : {0, 4, 8}) camera.rotation[i] = 1;
  return camera;
}

// Beside a line, which moves with t; one vertex in eight is otherwise. All levels on both sides.
uint8_t state_of(const fvv_mesh &mesh, size_t vertex, size_t camera, int t) {
  const int32_t *p = mesh.lattice + 3 * vertex;
  const bool beside = p[0] + p[1] * int32_t(camera) > 90 + 5 * t;
  const bool seen = beside != ((vertex * 2654435761u >> 7) % 8 == camera);
  const size_t level = (vertex + size_t(t) * (vertex % 5 == 0)) % 3;
  return uint8_t((seen ? FVV_VERTEX_SEEN : FVV_VERTEX_HIDDEN) + 2 * level);
}

// What decoders get for one camera: backfacing, or the state; all or nothing away from the outline.
Bytes decoded_states(const fvv_mesh &mesh, const int32_t centre[3], uint8_t threshold, size_t camera, int t) {
  Bytes sides(mesh.vertex_count);
  fvv_visibility_facing(&mesh, centre, threshold, sides.data());
  for (size_t v = 0; v < sides.size(); v++)
    if (sides[v]) sides[v] = 2 - state_of(mesh, v, camera, t) % 2;
  Bytes out = sides;
  for (size_t i = 0; i < 3 * size_t(mesh.face_count); i++)
    for (size_t k = i / 3 * 3; k < i / 3 * 3 + 3; k++) {
      const uint32_t v = mesh.faces[i], w = mesh.faces[k];
      if (sides[v] && sides[w] && sides[v] != sides[w]) out[v] = state_of(mesh, v, camera, t);
    }
  return out;
}

Bytes bytes_of(const fvv_bytes &bytes) {
  return {bytes.data, bytes.data + bytes.size};
}

// The payload of VISI.
Bytes encoded(const fvv_mesh &mesh, const fvv_visibility_header &header,
              const std::vector<fvv_visibility_view> &views) {
  fvv_visibility_order *order = nullptr;
  fvv_bytes payload = {};
  REQUIRE(fvv_visibility_order_open(&mesh, nullptr, &order, nullptr) == FVV_OK);
  REQUIRE(fvv_visibility_encode(order, &mesh, &header, views.data(), views.size(), &payload, nullptr) ==
          FVV_OK);
  const Bytes out = bytes_of(payload);
  fvv_visibility_order_close(order);
  fvv_bytes_free(&payload);
  return out;
}

} // namespace

// ---- Visibility in a stream: with the mesh of its time, in any order of frames, and nothing wrong after
// damage.

namespace static_cameras {

namespace {

constexpr int frames = 5;                                             // of a group
constexpr uint16_t mesh_track = 1, first_track = 2, second_track = 3; // of visibility
const std::vector<uint16_t> camera_ids = {2, 7, 300};

fvv_camera camera_of(uint16_t id) {
  fvv_camera camera = upright_camera(id);
  // A turn about z, so that the centre is more than a sign away from t.
  camera.rotation[0] = camera.rotation[4] = 0.6;
  camera.rotation[1] = -(camera.rotation[3] = 0.8);
  camera.translation[0] = id == 7 ? 1.5 : -0.25;
  camera.translation[1] = id == 300 ? 0.7 : -0.1;
  camera.translation[2] = id == 2 ? 0.4 : -0.6003;
  return camera;
}

constexpr uint8_t threshold_of(uint16_t track) {
  return track == first_track ? FVV_VISIBILITY_THRESHOLD : 10;
}

// The states of all cameras for a mesh, from the definition.
Bytes states_of(const fvv_mesh &mesh, uint8_t threshold, int t) {
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  Bytes out;
  for (size_t c = 0; c < camera_ids.size(); c++) {
    const fvv_camera camera = camera_of(camera_ids[c]);
    int32_t centre[3];
    REQUIRE(fvv_visibility_centre(&camera, &scene, centre, nullptr) == FVV_OK);
    const Bytes row = decoded_states(mesh, centre, threshold, c, t);
    out.insert(out.end(), row.begin(), row.end());
  }
  return out;
}

// The VISI payload of one track and frame; states is that of the frame before, and becomes this one's.
Bytes visibility_payload(const fvv_mesh &mesh, uint16_t track, int t, Bytes &states) {
  const uint8_t threshold = threshold_of(track);
  const Bytes former = states;
  states = states_of(mesh, threshold, t);
  const size_t row = mesh.vertex_count;
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  std::vector<Bytes> seen(camera_ids.size(), Bytes(row));
  std::vector<fvv_visibility_view> views;
  for (size_t c = 0; c < camera_ids.size(); c++) {
    for (size_t i = 0; i < row; i++) seen[c][i] = state_of(mesh, i, c, t);
    fvv_visibility_view view = {
        camera_ids[c], {}, seen[c].data(), t ? former.data() + c * row : nullptr, nullptr};
    const fvv_camera camera = camera_of(camera_ids[c]);
    REQUIRE(fvv_visibility_centre(&camera, &scene, view.centre, nullptr) == FVV_OK);
    views.push_back(view);
  }
  const fvv_visibility_header header = {threshold, mesh_track, 0, uint32_t(t), 0};
  return encoded(mesh, header, views);
}

// Groups of a raw mesh and delta frames, each with visibility of two thresholds.
Stream visible_stream(int groups) {
  Stream out;
  out.configuration = {scene_chunk(), track_chunk(mesh_track, FVV_TRACK_MESH),
                       track_chunk(first_track, FVV_TRACK_VISIBILITY),
                       track_chunk(second_track, FVV_TRACK_VISIBILITY)};
  for (const uint16_t id : camera_ids) out.configuration.push_back(camera_chunk(camera_of(id)));
  for (int g = 0; g < groups; g++) {
    Group group = {2 * frames * g, 2 * frames * (g + 1), {}};
    Sheet key(g, 0);
    const fvv_mesh mesh = key.mesh();
    fvv_bytes payload = {};
    fvv_mesh_sequence *sequence = nullptr;
    REQUIRE(fvv_mesh_encode(&mesh, FVV_MESH_RAW, 0, nullptr, &payload, nullptr) == FVV_OK);
    REQUIRE(fvv_mesh_sequence_open(&mesh, nullptr, &sequence, nullptr) == FVV_OK);
    Bytes first, second;
    for (int t = 0; t < frames; t++) {
      fvv_mesh_delta_options options;
      fvv_mesh_delta_options_default(&options);
      options.max_error = 0;
      if (t)
        REQUIRE(fvv_mesh_sequence_encode(sequence, Sheet(g, t).positions.data(), &options, &payload,
                                         nullptr) == FVV_OK);
      const uint8_t flags = t ? 0 : FVV_FLAG_KEY;
      const int64_t time = group.start + 2 * t;
      const fvv_mesh &now = *fvv_mesh_sequence_mesh(sequence);
      group.chunks.push_back({FVV_CHUNK_MESH, mesh_track, flags, time, bytes_of(payload)});
      group.chunks.push_back(
          {FVV_CHUNK_VISIBILITY, first_track, flags, time, visibility_payload(now, first_track, t, first)});
      group.chunks.push_back({FVV_CHUNK_VISIBILITY, second_track, flags, time,
                              visibility_payload(now, second_track, t, second)});
    }
    fvv_mesh_sequence_close(sequence);
    fvv_bytes_free(&payload);
    out.groups.push_back(group);
  }
  return out;
}

struct Frames : Opened {
  using Opened::Opened;

  // FVV_OK: the states are those of the definition.
  fvv_status frame(size_t f, uint16_t track) {
    const fvv_visibility *got = nullptr;
    const fvv_status result = fvv_stream_visibility(stream, f, track, &got, &diagnostic);
    CHECK((result == FVV_OK) == (got != nullptr));
    if (result != FVV_OK) return result;
    Sheet sheet(int(f) / frames, int(f) % frames);
    const Bytes wanted = states_of(sheet.mesh(), threshold_of(track), int(f) % frames);
    CHECK(std::equal(camera_ids.begin(), camera_ids.end(), got->cameras));
    CHECK(got->header.camera_count == camera_ids.size());
    CHECK(Bytes(got->states, got->states + wanted.size()) == wanted);
    return result;
  }
};

constexpr size_t per_frame = 3, configuration = 7; // chunks

} // namespace

TEST_CASE("visibility is found in any order of frames") {
  Frames opened(write(visible_stream(3)));
  REQUIRE(opened.status == FVV_OK);
  for (size_t f = 0; f < 3 * frames; f++)
    for (const uint16_t track : {first_track, second_track}) CHECK(opened.frame(f, track) == FVV_OK);
  for (size_t f = 3 * frames; f-- > 0;) CHECK(opened.frame(f, first_track) == FVV_OK);
  for (const size_t f : {4u, 4u, 13u, 3u, 0u, 1u, 12u}) CHECK(opened.frame(f, second_track) == FVV_OK);
  const fvv_visibility *none;
  CHECK(fvv_stream_visibility(opened.stream, 0, mesh_track, &none, nullptr) == FVV_END);
  CHECK(fvv_stream_visibility(opened.stream, 99, first_track, &none, nullptr) == FVV_ERROR_ARGUMENT);
}

TEST_CASE("a stream with visibility is whole") {
  const Bytes bytes = write(visible_stream(2));
  for (const bool decode : {true, false}) {
    Check how;
    how.decode = decode;
    const Checked checked(bytes, how);
    CHECK(checked.status == FVV_OK);
    CHECK(checked.summary().problems == 0);
    CHECK(checked.summary().whole_frames == 2 * frames);
    CHECK(fvv_checker_track(checked.checker, 1)->kind == FVV_TRACK_VISIBILITY);
    CHECK(fvv_checker_track(checked.checker, 1)->key_chunks == 2);
  }
}

TEST_CASE("6003, 6005, 6006, 6007: visibility that does not fit its stream") {
  struct Fault {
    uint32_t issue;
    void (*spoil)(Stream &);
    bool without_decoding;
    bool without_frame = false; // its time is no frame any more
  };
  const Fault faults[] = {
      {FVV_ISSUE_VISIBILITY_CAMERA, [](Stream &s) { s.configuration.pop_back(); }, false},
      {FVV_ISSUE_VISIBILITY_MESH,
       [](Stream &s) { s.groups[0].chunks.erase(s.groups[0].chunks.begin() + 12); }, false, true},
      {FVV_ISSUE_VISIBILITY_MESH, [](Stream &s) { s.groups[0].chunks[1].payload[4]++; }, false},
      {FVV_ISSUE_VISIBILITY_MESH, [](Stream &s) { s.groups[0].chunks[1].payload[2] = first_track; }, true},
      {FVV_ISSUE_VISIBILITY_NUMBER, [](Stream &s) { s.groups[0].chunks[13].flags = FVV_FLAG_KEY; }, true},
      {FVV_ISSUE_VISIBILITY_NUMBER, [](Stream &s) { s.groups[0].chunks[13].payload[8]++; }, false},
      {FVV_ISSUE_VISIBILITY_NUMBER,
       [](Stream &s) { s.groups[0].chunks.erase(s.groups[0].chunks.begin() + 10); }, false},
      {FVV_ISSUE_VISIBILITY_STREAM,
       [](Stream &s) {
         Bytes &payload = s.groups[0].chunks[13].payload;
         payload[17]++;
         payload.insert(payload.begin() + 30, 0x55);
       },
       false},
      {FVV_ISSUE_VISIBILITY_PAYLOAD, [](Stream &s) { s.groups[0].chunks[13].payload.resize(9); }, true},
      {FVV_ISSUE_VISIBILITY_PAYLOAD, [](Stream &s) { s.groups[0].chunks[13].payload[0] = 9; }, true},
  };
  for (const Fault &fault : faults) {
    Stream stream = visible_stream(1);
    fault.spoil(stream);
    const Bytes bytes = write(stream);
    check_finds(bytes, fault.issue, fault.without_decoding);
    Frames opened(bytes);
    REQUIRE(opened.status == FVV_OK);
    // frame() compares what comes with the definition.
    size_t wrong = 0;
    for (size_t f = 0; f < fvv_stream_frame_count(opened.stream); f++)
      if (opened.frame(f, first_track) < 0) {
        wrong++;
        CHECK((opened.diagnostic.issue == fault.issue || fault.issue == FVV_ISSUE_VISIBILITY_MESH ||
               opened.diagnostic.issue == FVV_ISSUE_VISIBILITY_NUMBER));
      }
    CHECK((wrong > 0) == !fault.without_frame);
  }
}

TEST_CASE("damage before visibility never yields a wrong one") {
  const Bytes good = write(visible_stream(2));
  const auto places = chunks_of(good);
  for (size_t c = configuration + 1; c < configuration + 1 + per_frame * frames; c++) {
    Bytes bad = good;
    bad[places[c].offset + 40] ^= 4;
    const Checked checked(bad);
    CHECK(checked.summary().problems == 1);
    const size_t frame = (c - configuration - 1) / per_frame;
    Frames opened(bad);
    for (size_t f = 0; f < 2 * frames; f++)
      for (const uint16_t track : {first_track, second_track}) {
        const fvv_status status = opened.frame(f, track);
        if (f < frame || f >= frames) CHECK(status == FVV_OK);
      }
  }
}

TEST_CASE("cameras that do not exist take no memory for what they see") {
  Stream stream = visible_stream(1);
  Bytes &payload = stream.groups[0].chunks[1].payload;
  payload.resize(16);
  payload[12] = 0xE8; // 1,000
  payload[13] = 3;
  for (int i = 0; i < 1000; i++) payload.insert(payload.end(), {1, 0});
  const Bytes bytes = write(stream);
  const Checked checked(bytes);
  CHECK(fvv_checker_problem(checked.checker, 0)->issue == FVV_ISSUE_VISIBILITY_CAMERA);
  size_t largest = 0;
  const auto resize = [](void *user, void *pointer, size_t, size_t size) -> void * {
    *static_cast<size_t *>(user) = std::max(*static_cast<size_t *>(user), size);
    if (size) return std::realloc(pointer, size);
    std::free(pointer);
    return nullptr;
  };
  const fvv_allocator allocator = {resize, &largest};
  Frames opened(bytes, &allocator);
  CHECK(opened.frame(0, first_track) == FVV_ERROR_INVALID);
  CHECK(opened.diagnostic.issue == FVV_ISSUE_VISIBILITY_CAMERA);
  // 206 vertices and 1,000 cameras would be 206,000 bytes.
  CHECK(largest < 100000);
}

TEST_CASE("every allocation on the way to visibility may fail") {
  const Bytes bytes = write(visible_stream(1));
  bool done = false;
  for (int64_t n = 0; !done; n++) {
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      Frames opened(bytes, allocator);
      done = opened.status == FVV_OK && opened.frame(2, first_track) == FVV_OK;
      if (!done) CHECK(opened.diagnostic.status == FVV_ERROR_MEMORY);
    });
    REQUIRE(n < 2000);
  }
  for (int64_t n = 0; n < 150; n += 3) {
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      Check how;
      how.allocator = allocator;
      const Checked checked(bytes, how);
    });
  }
}

// Not run by default: test_stream '[make]' writes the vector again, after a change of the format.
TEST_CASE("write the vector of visibility", "[.][make]") {
  write_vector(FVV_CASES "/vector_visibility_sheet/input.fvv", write(visible_stream(1)));
}

TEST_CASE("visibility of the vector is that of the decoder that was written from the specification") {
  std::ifstream file(FVV_CASES "/vector_visibility_sheet/input.fvv", std::ios::binary);
  std::ifstream list(FVV_LISTINGS "/visibility_sheet.crc");
  Frames opened(Bytes(std::istreambuf_iterator<char>(file), {}));
  REQUIRE(opened.status == FVV_OK);
  size_t count = 0;
  std::string wanted;
  for (; list >> wanted; count++) {
    const fvv_visibility *got;
    const uint16_t track = count % 2 ? second_track : first_track;
    REQUIRE(fvv_stream_visibility(opened.stream, count / 2, track, &got, nullptr) == FVV_OK);
    const size_t size = size_t(got->header.camera_count) * got->header.vertex_count;
    CHECK(fvv_crc32c(0, got->states, size) == std::stoul(wanted, nullptr, 16));
  }
  CHECK(count == 2 * frames);
}

} // namespace static_cameras

// ---- Visibility of cameras that move: their centres come from the calibration of the same time, and without
// one they have no weights.

namespace moving_cameras {

namespace {

constexpr int frames = 5;
constexpr uint16_t mesh_track = 1, visibility_track = 2, calibration_track = 4;
const fvv_calibration_bits bits = {16, 9, 3, 18};

// Camera 2 does not move, 7 travels and turns, 9 travels and is lost in frame 2.
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
  return decoded_states(mesh, centre, FVV_VISIBILITY_THRESHOLD, id % 3, t);
}

Bytes visibility_payload(const fvv_mesh &mesh, const std::vector<uint16_t> &cameras, int t) {
  std::vector<Bytes> seen, former;
  std::vector<fvv_visibility_view> views;
  for (const uint16_t id : cameras) {
    Bytes row(mesh.vertex_count);
    for (size_t i = 0; i < row.size(); i++) row[i] = state_of(mesh, i, id % 3, t);
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
  const fvv_visibility_header header = {FVV_VISIBILITY_THRESHOLD, mesh_track, 0, uint32_t(t), 0};
  return encoded(mesh, header, views);
}

// Each frame is a raw mesh, a calibration, and what the cameras that are calibrated see.
Stream moving_stream() {
  Stream out;
  out.configuration = {scene_chunk(), track_chunk(mesh_track, FVV_TRACK_MESH),
                       track_chunk(visibility_track, FVV_TRACK_VISIBILITY),
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
        {FVV_CHUNK_VISIBILITY, visibility_track, flags, 2 * t, visibility_payload(mesh, cameras_in(t), t)});
  }
  fvv_bytes_free(&payload);
  out.groups.push_back(group);
  return out;
}

// The states of all cameras of a frame, or why there are none.
fvv_status frame(Opened &opened, int t, Bytes &states) {
  const fvv_visibility *got = nullptr;
  const fvv_status status =
      fvv_stream_visibility(opened.stream, size_t(t), visibility_track, &got, &opened.diagnostic);
  if (status == FVV_OK)
    states.assign(got->states, got->states + size_t(got->header.camera_count) * got->header.vertex_count);
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

TEST_CASE("weights of cameras that move are those of where they are, in any order of frames") {
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

TEST_CASE("6003: weights of a camera that is not calibrated at that time") {
  struct Fault {
    const char *name;
    void (*spoil)(Stream &);
    int first; // frame that is wrong; those after it depend on it
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

TEST_CASE("the calibration precedes the visibility that needs it") {
  Stream stream = moving_stream();
  std::swap(stream.groups[0].chunks[1], stream.groups[0].chunks[2]);
  const Checked checked(write(stream));
  REQUIRE(checked.summary().problems == 1);
  CHECK(fvv_checker_problem(checked.checker, 0)->issue == FVV_ISSUE_VISIBILITY_CAMERA);
}

TEST_CASE("after a damaged calibration no weights of cameras that move are returned") {
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

// Not run by default: test_stream '[make]' writes the vector again, after a change of the format.
TEST_CASE("write the vector of visibility of cameras that move", "[.][make]") {
  write_vector(FVV_CASES "/vector_visibility_moving/input.fvv", write(moving_stream()));
}

TEST_CASE("visibility of cameras that move is that of the decoder that was written from the specification") {
  std::ifstream file(FVV_CASES "/vector_visibility_moving/input.fvv", std::ios::binary);
  std::ifstream list(FVV_LISTINGS "/visibility_moving.crc");
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

} // namespace moving_cameras

// ---- Weights in a stream: with frames after others, as the decoder that was written from the specification
// reads them.

namespace weights {

namespace {

constexpr int frames = 5;
constexpr uint16_t mesh_track = 1, track = 2;
const std::vector<uint16_t> camera_ids = {2, 7, 300};

fvv_camera camera_of(uint16_t id) {
  fvv_camera camera = upright_camera(id);
  camera.translation[0] = id == 7 ? 1.5 : -0.25;
  camera.translation[2] = id == 2 ? 0.4 : -0.6003;
  return camera;
}

// former: states of all cameras in the frame before; becomes those of this one.
Bytes payload_of(const fvv_mesh &mesh, int t, Bytes &former) {
  const size_t count = mesh.vertex_count;
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  std::vector<Bytes> weights(camera_ids.size(), Bytes(count));
  std::vector<fvv_visibility_view> views;
  former.resize(count * camera_ids.size());
  for (size_t c = 0; c < camera_ids.size(); c++) {
    for (size_t v = 0; v < count; v++) weights[c][v] = state_of(mesh, v, c, t);
    uint8_t *states = former.data() + c * count;
    fvv_visibility_view view = {camera_ids[c], {}, weights[c].data(), states, states};
    const fvv_camera camera = camera_of(camera_ids[c]);
    REQUIRE(fvv_visibility_centre(&camera, &scene, view.centre, nullptr) == FVV_OK);
    views.push_back(view);
  }
  const fvv_visibility_header header = {FVV_VISIBILITY_THRESHOLD, mesh_track, 0, uint32_t(t), 0};
  return encoded(mesh, header, views);
}

// One group of raw meshes of the same faces.
Stream weight_stream() {
  Stream out;
  out.configuration = {scene_chunk(), track_chunk(mesh_track, FVV_TRACK_MESH),
                       track_chunk(track, FVV_TRACK_VISIBILITY)};
  for (const uint16_t id : camera_ids) out.configuration.push_back(camera_chunk(camera_of(id)));
  Group group = {0, 2 * frames, {}};
  Bytes states;
  for (int t = 0; t < frames; t++) {
    Sheet sheet(0, t);
    const fvv_mesh mesh = sheet.mesh();
    fvv_bytes payload = {};
    REQUIRE(fvv_mesh_encode(&mesh, FVV_MESH_RAW, 0, nullptr, &payload, nullptr) == FVV_OK);
    group.chunks.push_back({FVV_CHUNK_MESH, mesh_track, FVV_FLAG_KEY, 2 * t, bytes_of(payload)});
    group.chunks.push_back(
        {FVV_CHUNK_VISIBILITY, track, uint8_t(t ? 0 : FVV_FLAG_KEY), 2 * t, payload_of(mesh, t, states)});
    fvv_bytes_free(&payload);
  }
  out.groups.push_back(group);
  return out;
}

} // namespace

TEST_CASE("a stream with weights is whole, and its weights are the requested ones near an outline") {
  const Bytes bytes = write(weight_stream());
  const Checked checked(bytes);
  CHECK(checked.status == FVV_OK);
  CHECK(checked.summary().problems == 0);
  CHECK(checked.summary().whole_frames == frames);
  Opened opened(bytes);
  REQUIRE(opened.status == FVV_OK);
  size_t near = 0;
  // Backwards: each from the key on.
  for (int t = frames; t-- > 0;) {
    Sheet sheet(0, t);
    const fvv_mesh mesh = sheet.mesh();
    const fvv_visibility *got = nullptr;
    REQUIRE(fvv_stream_visibility(opened.stream, size_t(t), track, &got, nullptr) == FVV_OK);
    CHECK(got->header.vertex_count == mesh.vertex_count);
    for (size_t i = 0; i < camera_ids.size() * mesh.vertex_count; i++) {
      const uint8_t state = got->states[i];
      if (!state) continue;
      const uint8_t expected = state_of(mesh, i % mesh.vertex_count, i / mesh.vertex_count, t);
      CHECK(FVV_VERTEX_IS_SEEN(state) == FVV_VERTEX_IS_SEEN(expected));
      if (state > FVV_VERTEX_SEEN) CHECK(state == expected);
      near += state > FVV_VERTEX_SEEN;
    }
  }
  CHECK(near > 200);
}

// Not run by default: test_stream '[make]' writes the vector again, after a change of the format.
TEST_CASE("write the vector of weights", "[.][make]") {
  write_vector(FVV_CASES "/vector_visibility_weights/input.fvv", write(weight_stream()));
}

TEST_CASE("weights of the vector are those of the decoder that was written from the specification") {
  std::ifstream file(FVV_CASES "/vector_visibility_weights/input.fvv", std::ios::binary);
  std::ifstream list(FVV_LISTINGS "/visibility_weights.crc");
  Opened opened(Bytes(std::istreambuf_iterator<char>(file), {}));
  REQUIRE(opened.status == FVV_OK);
  size_t count = 0;
  for (std::string crc; list >> crc; count++) {
    const fvv_visibility *got;
    REQUIRE(fvv_stream_visibility(opened.stream, count, track, &got, nullptr) == FVV_OK);
    const size_t size = size_t(got->header.camera_count) * got->header.vertex_count;
    CHECK(fvv_crc32c(0, got->states, size) == std::stoul(crc, nullptr, 16));
  }
  CHECK(count == frames);
}

} // namespace weights
