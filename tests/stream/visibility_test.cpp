// Visibility in a stream: with the mesh of its time, in any order of frames, and nothing wrong behind damage.
#include "checked.h"
#include "visibility_fixture.h"

#include <algorithm>
#include <fstream>
#include <iterator>

namespace {

constexpr int frames = 5; // of a group
constexpr uint16_t mesh_track = 1, face_track = 2, vertex_track = 3;
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

// The states of all cameras for a mesh, from the definition.
Bytes states_of(const fvv_mesh &mesh, uint8_t domain, uint8_t threshold, int t) {
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  Bytes out;
  for (size_t c = 0; c < camera_ids.size(); c++) {
    const fvv_camera camera = camera_of(camera_ids[c]);
    int32_t centre[3];
    REQUIRE(fvv_visibility_centre(&camera, &scene, centre, nullptr) == FVV_OK);
    Bytes row(domain == FVV_VISIBILITY_FACES ? mesh.face_count : mesh.vertex_count);
    fvv_visibility_facing(&mesh, domain, centre, threshold, row.data());
    for (size_t i = 0; i < row.size(); i++)
      if (row[i]) row[i] = is_seen(mesh, domain, i, c, t) ? FVV_ELEMENT_SEEN : FVV_ELEMENT_HIDDEN;
    out.insert(out.end(), row.begin(), row.end());
  }
  return out;
}

constexpr uint8_t threshold_of(uint16_t track) {
  return track == face_track ? FVV_VISIBILITY_THRESHOLD : 10;
}
constexpr uint8_t domain_of(uint16_t track) {
  return track == face_track ? FVV_VISIBILITY_FACES : FVV_VISIBILITY_VERTICES;
}

// The VISI payload of one track and frame; states is that of the frame before, and becomes this one's.
Bytes visibility_payload(const fvv_mesh &mesh, uint16_t track, int t, Bytes &states) {
  const uint8_t domain = domain_of(track), threshold = threshold_of(track);
  const Bytes former = states;
  states = states_of(mesh, domain, threshold, t);
  const size_t row = states.size() / camera_ids.size();
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  std::vector<Bytes> seen(camera_ids.size(), Bytes(row));
  std::vector<fvv_visibility_view> views;
  for (size_t c = 0; c < camera_ids.size(); c++) {
    for (size_t i = 0; i < row; i++) seen[c][i] = is_seen(mesh, domain, i, c, t);
    fvv_visibility_view view = {
        camera_ids[c], {}, seen[c].data(), t ? former.data() + c * row : nullptr, nullptr};
    const fvv_camera camera = camera_of(camera_ids[c]);
    REQUIRE(fvv_visibility_centre(&camera, &scene, view.centre, nullptr) == FVV_OK);
    views.push_back(view);
  }
  const fvv_visibility_header header = {domain, threshold, mesh_track, 0, uint32_t(t), 0};
  return encoded(mesh, header, views);
}

// Groups of a raw mesh and delta frames, each with the visibility of faces and vertices.
Stream visible_stream(int groups) {
  Stream out;
  out.configuration = {scene_chunk(), track_chunk(mesh_track, FVV_TRACK_MESH),
                       track_chunk(face_track, FVV_TRACK_VISIBILITY),
                       track_chunk(vertex_track, FVV_TRACK_VISIBILITY)};
  for (const uint16_t id : camera_ids) out.configuration.push_back(camera_chunk(camera_of(id)));
  for (int g = 0; g < groups; g++) {
    Group group = {2 * frames * g, 2 * frames * (g + 1), {}};
    Sheet key(g, 0);
    const fvv_mesh mesh = key.mesh();
    fvv_bytes payload = {};
    fvv_mesh_sequence *sequence = nullptr;
    REQUIRE(fvv_mesh_encode(&mesh, FVV_MESH_RAW, 0, nullptr, &payload, nullptr) == FVV_OK);
    REQUIRE(fvv_mesh_sequence_open(&mesh, nullptr, &sequence, nullptr) == FVV_OK);
    Bytes faces, vertices;
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
          {FVV_CHUNK_VISIBILITY, face_track, flags, time, visibility_payload(now, face_track, t, faces)});
      group.chunks.push_back({FVV_CHUNK_VISIBILITY, vertex_track, flags, time,
                              visibility_payload(now, vertex_track, t, vertices)});
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
    const Bytes wanted = states_of(sheet.mesh(), domain_of(track), threshold_of(track), int(f) % frames);
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
    for (const uint16_t track : {face_track, vertex_track}) CHECK(opened.frame(f, track) == FVV_OK);
  for (size_t f = 3 * frames; f-- > 0;) CHECK(opened.frame(f, face_track) == FVV_OK);
  for (const size_t f : {4u, 4u, 13u, 3u, 0u, 1u, 12u}) CHECK(opened.frame(f, vertex_track) == FVV_OK);
  const fvv_visibility *none;
  CHECK(fvv_stream_visibility(opened.stream, 0, mesh_track, &none, nullptr) == FVV_END);
  CHECK(fvv_stream_visibility(opened.stream, 99, face_track, &none, nullptr) == FVV_ERROR_ARGUMENT);
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
  };
  const Fault faults[] = {
      {FVV_ISSUE_VISIBILITY_CAMERA, [](Stream &s) { s.configuration.pop_back(); }, false},
      {FVV_ISSUE_VISIBILITY_MESH,
       [](Stream &s) { s.groups[0].chunks.erase(s.groups[0].chunks.begin() + 12); }, false},
      {FVV_ISSUE_VISIBILITY_MESH, [](Stream &s) { s.groups[0].chunks[1].payload[4]++; }, false},
      {FVV_ISSUE_VISIBILITY_MESH, [](Stream &s) { s.groups[0].chunks[1].payload[2] = face_track; }, true},
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
      {FVV_ISSUE_VISIBILITY_DOMAIN, [](Stream &s) { s.groups[0].chunks[13].payload[0] = 9; }, true},
  };
  for (const Fault &fault : faults) {
    Stream stream = visible_stream(1);
    fault.spoil(stream);
    const Bytes bytes = write(stream);
    for (const bool decode : {true, false}) {
      Check how;
      how.decode = decode;
      const Checked checked(bytes, how);
      INFO(checked.report());
      bool found = false;
      for (size_t i = 0; i < fvv_checker_problem_count(checked.checker); i++)
        found |= fvv_checker_problem(checked.checker, i)->issue == fault.issue;
      CHECK(found == (decode || fault.without_decoding));
    }
    Frames opened(bytes);
    REQUIRE(opened.status == FVV_OK);
    // frame() compares what comes with the definition.
    size_t wrong = 0;
    for (size_t f = 0; f < fvv_stream_frame_count(opened.stream); f++)
      if (opened.frame(f, face_track) < 0) {
        wrong++;
        CHECK((opened.diagnostic.issue == fault.issue || fault.issue == FVV_ISSUE_VISIBILITY_MESH ||
               opened.diagnostic.issue == FVV_ISSUE_VISIBILITY_NUMBER));
      }
    CHECK(wrong > 0);
  }
}

TEST_CASE("damage in front of visibility never yields a wrong one") {
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
      for (const uint16_t track : {face_track, vertex_track}) {
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
  CHECK(opened.frame(0, face_track) == FVV_ERROR_INVALID);
  CHECK(opened.diagnostic.issue == FVV_ISSUE_VISIBILITY_CAMERA);
  // 348 faces and 1,000 cameras would be 348,000 bytes.
  CHECK(largest < 100000);
}

TEST_CASE("every allocation on the way to visibility may fail") {
  const Bytes bytes = write(visible_stream(1));
  bool done = false;
  for (int64_t n = 0; !done; n++) {
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      Frames opened(bytes, allocator);
      done = opened.status == FVV_OK && opened.frame(2, face_track) == FVV_OK;
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

// Not run by default: test_stream '[make]' writes the vector anew, where the format has changed.
TEST_CASE("write the vector of visibility", "[.][make]") {
  write_vector(FVV_VISIBILITY_VECTORS "/sheet.fvv", write(visible_stream(1)));
}

TEST_CASE("visibility of the vector is that of the decoder that was written from the specification") {
  std::ifstream file(FVV_VISIBILITY_VECTORS "/sheet.fvv", std::ios::binary);
  std::ifstream list(FVV_VISIBILITY_VECTORS "/sheet.crc");
  Frames opened(Bytes(std::istreambuf_iterator<char>(file), {}));
  REQUIRE(opened.status == FVV_OK);
  size_t count = 0;
  std::string wanted;
  for (; list >> wanted; count++) {
    const fvv_visibility *got;
    const uint16_t track = count % 2 ? vertex_track : face_track;
    REQUIRE(fvv_stream_visibility(opened.stream, count / 2, track, &got, nullptr) == FVV_OK);
    const size_t size = size_t(got->header.camera_count) * got->header.element_count;
    CHECK(fvv_crc32c(0, got->states, size) == std::stoul(wanted, nullptr, 16));
  }
  CHECK(count == 2 * frames);
}
