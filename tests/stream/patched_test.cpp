// Patched frames in a stream: any frame at random with its colours and visibility, and what a lost one costs.
// The streams are cases of the conformance suite, which know what comes back.
#include "fvv/frames.h"
#include "stream_fixture.h"

#include <iterator>

namespace {

Bytes case_of(const char *name) {
  std::ifstream file(std::string(FVV_CASES "/") + name + "/input.fvv", std::ios::binary);
  REQUIRE(file.good());
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

// All of a frame in a row; empty where it fails.
struct Frames : Opened {
  using Opened::Opened;

  Bytes frame(size_t f) {
    Bytes out;
    fvv_mesh mesh;
    if (fvv_stream_mesh(stream, f, 1, &mesh, &diagnostic) != FVV_OK) return out;
    const auto add = [&](const void *data, size_t size) {
      out.insert(out.end(), static_cast<const uint8_t *>(data), static_cast<const uint8_t *>(data) + size);
    };
    add(mesh.lattice, 12 * size_t(mesh.vertex_count));
    add(mesh.faces, 12 * size_t(mesh.face_count));
    const uint8_t *colours = nullptr;
    uint32_t count = 0;
    const fvv_status got = fvv_stream_colours(stream, f, 1, &colours, &count, &diagnostic);
    CHECK((got == FVV_OK || got == FVV_END));
    if (got == FVV_OK) CHECK(count == mesh.vertex_count);
    add(colours, 3 * size_t(count));
    fvv_mesh_free(&mesh);
    return out;
  }
};

} // namespace

TEST_CASE("patched frames and their colours are found in any order") {
  for (const char *name : {"patched_colours", "patched_unseen", "patched_moves", "patched_draco"}) {
    const Bytes bytes = case_of(name);
    Frames in_order(bytes), opened(bytes);
    REQUIRE(opened.status == FVV_OK);
    std::vector<Bytes> wanted;
    for (size_t f = 0; f < fvv_stream_frame_count(in_order.stream); f++) {
      wanted.push_back(in_order.frame(f));
      CHECK(!wanted.back().empty());
    }
    const size_t count = wanted.size();
    for (size_t i = 0; i < 3 * count; i++) {
      const size_t f = i * 5 % count;
      CHECK(opened.frame(f) == wanted[f]);
    }
  }
}

TEST_CASE("the patch of a frame without colours has the one of what no camera shows") {
  Frames opened(case_of("patched_unseen"));
  // Frames 1 and 5 have patches with colours, 3 has one without: the last of its vertices is one of these.
  for (const size_t f : {1, 3, 5}) {
    const Bytes frame = opened.frame(f);
    const Bytes last(frame.end() - 3, frame.end());
    CHECK((last == Bytes{200, 100, 50}) == (f == 3));
  }
}

TEST_CASE("a stream of patched frames is whole, and counted") {
  for (const char *name : {"patched_colours", "patched_visibility", "patched_moves", "patched_hole"}) {
    const Bytes bytes = case_of(name);
    for (const bool decode : {true, false}) {
      Check how;
      how.decode = decode;
      const Checked checked(bytes, how);
      INFO(name << ": " << checked.report());
      CHECK(checked.summary().problems == 0);
      CHECK(checked.summary().whole_frames == checked.summary().frames);
      const fvv_track_summary *track = fvv_checker_track(checked.checker, 0);
      CHECK(track->profile_chunks[FVV_MESH_PATCHED] >= 1);
    }
  }
}

TEST_CASE("frames after a damaged patched frame are lost, up to the next key mesh") {
  const Bytes good = case_of("patched_groups");
  Frames whole(good);
  const auto places = chunks_of(good);
  // SCEN, TRAK; GRUP, three meshes, GEND; the same again.
  Bytes bad = good;
  REQUIRE(places[4].type == FVV_CHUNK_MESH);
  bad[places[4].offset + 60] ^= 4;
  Frames opened(bad);
  for (size_t f = 0; f < 6; f++) CHECK(opened.frame(f) == (f == 1 || f == 2 ? Bytes() : whole.frame(f)));
  const Checked checked(bad);
  INFO(checked.report());
  CHECK(checked.problem(0).issue == FVV_ISSUE_PAYLOAD_CRC);
  // What follows in the group is no further problem, and a chunk of frame 0 might be missing.
  CHECK(checked.summary().problems == 1);
  CHECK(checked.summary().whole_frames == 3);
}

TEST_CASE("a patched frame of a live stream is complete with the colours of its patch") {
  const Bytes bytes = case_of("patched_colours");
  const auto places = chunks_of(bytes);
  size_t meshes = 0;
  for (size_t i = 0; i + 1 < places.size(); i++) {
    if (places[i].type != FVV_CHUNK_MESH) continue;
    meshes++;
    const bool coloured = places[i + 1].type == FVV_CHUNK_COLOURS;
    const Place &last = places[coloured ? i + 1 : i];
    fvv_frames *handle = nullptr;
    REQUIRE(fvv_frames_create(nullptr, nullptr, nullptr, &handle) == FVV_OK);
    REQUIRE(fvv_frames_push(handle, bytes.data(), last.offset + last.extent) == FVV_OK);
    fvv_frames_event event;
    size_t seen = 0, chunks = 0;
    while (fvv_frames_next(handle, &event, nullptr) == FVV_OK)
      if (event.kind == FVV_FRAMES_FRAME) {
        seen++;
        chunks = event.chunk_count;
      }
    // Frame 3 has a patch without colours, which might still come.
    CHECK(seen == (meshes == 4 ? 3 : meshes));
    if (coloured) CHECK(chunks == 2);
    fvv_frames_destroy(handle);
  }
  CHECK(meshes == 7);
}

TEST_CASE("every allocation on the way to a patched frame and its colours may fail") {
  const Bytes bytes = case_of("patched_colours");
  bool done = false;
  for (int64_t n = 0; !done && n < 3000; n++)
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      Opened opened(bytes, allocator);
      if (opened.status != FVV_OK) return;
      fvv_mesh mesh;
      const uint8_t *colours = nullptr;
      uint32_t count = 0;
      const fvv_status status = fvv_stream_mesh(opened.stream, 3, 1, &mesh, nullptr);
      const fvv_status coloured = fvv_stream_colours(opened.stream, 5, 1, &colours, &count, nullptr);
      for (const fvv_status s : {status, coloured}) CHECK((s == FVV_OK || s == FVV_ERROR_MEMORY));
      done = status == FVV_OK && coloured == FVV_OK;
      fvv_mesh_free(&mesh);
    });
  CHECK(done);
}
