// Shares in a stream: with frames behind others, as the decoder that was written from the specification reads
// them.
#include "checked.h"
#include "visibility_fixture.h"

#include <fstream>
#include <iterator>

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

// All levels on both sides of a line that moves with t.
uint8_t wanted(const fvv_mesh &mesh, size_t vertex, size_t camera, int t) {
  const bool seen = is_seen(mesh, FVV_VISIBILITY_SHARES, vertex, camera, t);
  const size_t level = (vertex + size_t(t) * (vertex % 5 == 0)) % 3;
  return uint8_t((seen ? FVV_ELEMENT_SEEN : FVV_ELEMENT_HIDDEN) + 2 * level);
}

// former: states of all cameras in the frame before; becomes those of this one.
Bytes payload_of(const fvv_mesh &mesh, int t, Bytes &former) {
  const size_t count = mesh.vertex_count;
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  std::vector<Bytes> shares(camera_ids.size(), Bytes(count));
  std::vector<fvv_visibility_view> views;
  former.resize(count * camera_ids.size());
  for (size_t c = 0; c < camera_ids.size(); c++) {
    for (size_t v = 0; v < count; v++) shares[c][v] = wanted(mesh, v, c, t);
    uint8_t *states = former.data() + c * count;
    fvv_visibility_view view = {camera_ids[c], {}, shares[c].data(), states, states};
    const fvv_camera camera = camera_of(camera_ids[c]);
    REQUIRE(fvv_visibility_centre(&camera, &scene, view.centre, nullptr) == FVV_OK);
    views.push_back(view);
  }
  const fvv_visibility_header header = {
      FVV_VISIBILITY_SHARES, FVV_VISIBILITY_THRESHOLD, mesh_track, 0, uint32_t(t), 0};
  return encoded(mesh, header, views);
}

// One group of raw meshes of the same faces.
Stream share_stream() {
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

TEST_CASE("a stream with shares is whole, and its shares are those that were asked for near an outline") {
  const Bytes bytes = write(share_stream());
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
    CHECK(got->header.element_count == mesh.vertex_count);
    for (size_t i = 0; i < camera_ids.size() * mesh.vertex_count; i++) {
      const uint8_t state = got->states[i];
      if (!state) continue;
      const uint8_t asked = wanted(mesh, i % mesh.vertex_count, i / mesh.vertex_count, t);
      CHECK(FVV_ELEMENT_IS_SEEN(state) == FVV_ELEMENT_IS_SEEN(asked));
      if (state > FVV_ELEMENT_SEEN) CHECK(state == asked);
      near += state > FVV_ELEMENT_SEEN;
    }
  }
  CHECK(near > 200);
}

// Not run by default: test_stream '[make]' writes the vector anew, where the format has changed.
TEST_CASE("write the vector of shares", "[.][make]") {
  write_vector(FVV_VISIBILITY_VECTORS "/shares.fvv", write(share_stream()));
}

TEST_CASE("shares of the vector are those of the decoder that was written from the specification") {
  std::ifstream file(FVV_VISIBILITY_VECTORS "/shares.fvv", std::ios::binary);
  std::ifstream list(FVV_VISIBILITY_VECTORS "/shares.crc");
  Opened opened(Bytes(std::istreambuf_iterator<char>(file), {}));
  REQUIRE(opened.status == FVV_OK);
  size_t count = 0;
  for (std::string crc; list >> crc; count++) {
    const fvv_visibility *got;
    REQUIRE(fvv_stream_visibility(opened.stream, count, track, &got, nullptr) == FVV_OK);
    const size_t size = size_t(got->header.camera_count) * got->header.element_count;
    CHECK(fvv_crc32c(0, got->states, size) == std::stoul(crc, nullptr, 16));
  }
  CHECK(count == frames);
}
