// The checker: the same judgement for any split of the bytes, and nothing damaged called whole.
#include "base/bytes.h"
#include "base/layout.h"
#include "stream_fixture.h"

TEST_CASE("the numbers of a good stream") {
  const Bytes bytes = write(good_stream());
  const Checked checked(bytes);
  const fvv_check_summary &s = checked.summary();
  CHECK(checked.status == FVV_OK);
  CHECK((s.bytes == bytes.size() && s.chunks == 8 + 3 * 6 + 2 && s.groups == 3));
  CHECK((s.frames == 9 && s.whole_frames == 9 && s.problems == 0));
  CHECK((s.payload_bytes == 6 * 112 + 6 * 22 && s.configurations == 1));
  CHECK((s.start == 0 && s.end == 18 && s.has_footer && !s.truncated));
  CHECK((s.written_major == FVV_FORMAT_MAJOR && s.written_minor == FVV_FORMAT_MINOR));
  REQUIRE(fvv_checker_track_count(checked.checker) == 2);
  const fvv_track_summary &mesh = *fvv_checker_track(checked.checker, 0),
                          &video = *fvv_checker_track(checked.checker, 1);
  CHECK((mesh.track == 1 && mesh.kind == FVV_TRACK_MESH && mesh.chunks == 6 && mesh.key_chunks == 6));
  CHECK((mesh.bytes == 6 * 112 && mesh.smallest == 112 && mesh.largest == 112));
  CHECK((mesh.min_vertices == 4 && mesh.max_vertices == 4 && mesh.min_faces == 4 && mesh.max_faces == 4));
  CHECK((mesh.vertices == 24 && mesh.faces == 24));
  CHECK((video.track == 2 && video.kind == FVV_TRACK_VIDEO && video.chunks == 6 && video.bytes == 6 * 22));
  REQUIRE(fvv_checker_run_count(checked.checker) == 1);
  const fvv_frame_run &run = *fvv_checker_run(checked.checker, 0);
  CHECK((run.first == 0 && run.count == 9 && run.first_time == 0 && run.last_time == 16));
  REQUIRE(fvv_checker_configuration(checked.checker));
  CHECK(fvv_checker_configuration(checked.checker)->camera_count == 2);
  CHECK(!fvv_checker_problem(checked.checker, 0));

  Stream repeated = good_stream();
  repeated.repeat = true;
  repeated.finish = false;
  const Checked live(write(repeated));
  CHECK((live.summary().configurations == 3 && live.summary().problems == 0 &&
         live.summary().whole_frames == 9));
  CHECK((!live.summary().has_footer && live.summary().truncated));
}

TEST_CASE("any split of the bytes gives the same report") {
  Stream source = good_stream(2);
  source.repeat = true;
  const Bytes good = write(source);
  Bytes bad = good, cut = good;
  for (const Place &place : chunks_of(good))
    if (place.type == FVV_CHUNK_VIDEO_PACKET) bad[place.offset + 40] ^= 1;
  cut.resize(cut.size() * 2 / 3);
  for (const Bytes &bytes : {good, bad, cut})
    for (const bool decode : {true, false}) {
      Check how;
      how.decode = decode;
      const std::string whole = Checked(bytes, how).report();
      for (const size_t step : {1, 2, 7, 31, 32, 33, 100, 1000}) {
        how.step = step;
        CHECK(Checked(bytes, how).report() == whole);
      }
    }
}

TEST_CASE("of a truncated stream exactly the frames before the cut are whole") {
  const Bytes bytes = write(good_stream(2));
  const std::vector<Place> chunks = chunks_of(bytes);
  for (size_t size = 0; size < bytes.size(); size++) {
    const Checked checked({bytes.begin(), bytes.begin() + std::ptrdiff_t(size)});
    // A frame is whole once the chunk after its last one has come.
    std::vector<int64_t> expected;
    int64_t time = -1, begun = -1;
    for (const Place &place : chunks) {
      if (place.offset + place.extent > size) break;
      std::memcpy(&time, bytes.data() + place.offset + FVV_CHUNK_HEADER_TIME, sizeof time);
      const bool frame = place.type == FVV_CHUNK_MESH || place.type == FVV_CHUNK_VIDEO_PACKET;
      if (begun >= 0 && (place.type == FVV_CHUNK_GROUP_END || (frame && time != begun))) {
        expected.push_back(begun);
        begun = -1;
      }
      if (frame) begun = time;
    }
    INFO("cut at " << size << " of " << bytes.size());
    CHECK(whole_times(checked) == expected);
    CHECK((checked.summary().truncated || checked.status < 0));
    CHECK(!checked.summary().has_footer);
  }
}

TEST_CASE("a flipped bit anywhere is a problem, and its frame is not whole") {
  const Bytes good = write(good_stream(2));
  for (const Place &place : chunks_of(good))
    for (size_t i = 0; i < place.extent; i++) {
      Bytes bytes = good;
      bytes[place.offset + i] ^= uint8_t(1 << (i % 8));
      const Checked checked(bytes);
      INFO("byte " << place.offset + i << " of a chunk at " << place.offset);
      CHECK((checked.summary().problems > 0 || checked.status < 0));
      if (place.type != FVV_CHUNK_MESH && place.type != FVV_CHUNK_VIDEO_PACKET) continue;
      int64_t time;
      std::memcpy(&time, good.data() + place.offset + FVV_CHUNK_HEADER_TIME, sizeof time);
      for (const int64_t whole : whole_times(checked)) CHECK(whole != time);
      // What was before it, and the other group, is as it was.
      CHECK(checked.summary().whole_frames >= 3);
    }
}

namespace {

fvv_status read_all(fvv_checker *checker, const Bytes &bytes) {
  CHECK(fvv_checker_push(checker, bytes.data(), bytes.size()) == FVV_OK);
  return fvv_checker_finish(checker);
}

} // namespace

TEST_CASE("any intact repetition of a configuration block serves a group") {
  Stream source = good_stream(3);
  source.repeat = true;
  const Bytes good = write(source);
  std::vector<size_t> scenes, groups;
  for (const Place &place : chunks_of(good)) {
    if (place.type == FVV_CHUNK_SCENE) scenes.push_back(place.offset);
    if (place.type == FVV_CHUNK_GROUP) groups.push_back(place.offset);
  }
  REQUIRE(scenes.size() == 3);
  for (size_t block = 0; block < 3; block++)
    for (const Place &place : chunks_of(good))
      for (const size_t at : {size_t(9), size_t(34)}) { // header, payload
        if (place.offset < scenes[block] || place.offset >= groups[block]) continue;
        Bytes bad = good;
        bad[place.offset + at] ^= 1;
        INFO("block " << block << ", chunk at " << place.offset << ", byte " << at);
        fvv_checker *checker = nullptr;
        REQUIRE(fvv_checker_create(nullptr, nullptr, nullptr, &checker) == FVV_OK);
        // Only the first block has no repetition before its group.
        CHECK(read_all(checker, bad) == (block ? FVV_OK : FVV_NEED_DATA));
        CHECK(fvv_checker_summary(checker)->problems == 1);
        CHECK(fvv_checker_summary(checker)->whole_frames == (block ? 9 : 6));
        if (!block) {
          CHECK(read_all(checker, bad) == FVV_OK);
          CHECK(fvv_checker_summary(checker)->bytes == bad.size());
          CHECK(fvv_checker_summary(checker)->frames == 9);
          CHECK(fvv_checker_summary(checker)->whole_frames == 9);
          CHECK(fvv_checker_summary(checker)->problems == 1);
        }
        fvv_checker_destroy(checker);
      }
  // The whole block is missing, so that its group follows another one directly.
  Bytes without(good.begin(), good.begin() + std::ptrdiff_t(scenes[0]));
  without.insert(without.end(), good.begin() + std::ptrdiff_t(groups[0]), good.end());
  fvv_checker *checker = nullptr;
  REQUIRE(fvv_checker_create(nullptr, nullptr, nullptr, &checker) == FVV_OK);
  REQUIRE(read_all(checker, without) == FVV_NEED_DATA);
  CHECK(fvv_checker_summary(checker)->whole_frames == 6);
  REQUIRE(read_all(checker, without) == FVV_OK);
  CHECK(fvv_checker_summary(checker)->whole_frames == 9);
  REQUIRE(fvv_checker_problem_count(checker) == 2); // and a footer for more bytes
  CHECK(fvv_checker_problem(checker, 0)->issue == FVV_ISSUE_NO_CONFIGURATION);
  fvv_checker_destroy(checker);
}

TEST_CASE("a hostile payload in an intact chunk") {
  Stream source = good_stream(2);
  std::vector<Chunk> &chunks = source.groups[0].chunks; // mesh 0, sample 0, sample 1, mesh 2
  chunks[3].payload[FVV_MESH_SIZE + 12 * 4] = 9;        // an index
  chunks[2].payload.back() = 0;                         // no EOI
  const Bytes bytes = write(source);
  const std::vector<Place> places = chunks_of(bytes);
  const size_t mesh = places[8 + 1 + 3].offset, sample = places[8 + 1 + 2].offset;
  const Checked checked(bytes);
  CHECK(checked.status == FVV_OK);
  CHECK(checked.summary().problems == 2);
  CHECK(has_problem(checked, FVV_ISSUE_MESH_INDEX, mesh + 32 + FVV_MESH_SIZE + 12 * 4));
  CHECK(has_problem(checked, FVV_ISSUE_SAMPLE_JPEG, sample + 32 + 20));
  CHECK(whole_times(checked) == std::vector<int64_t>{0, 6, 8, 10});
  // Without decoding only the structure is checked.
  Check how;
  how.decode = false;
  const Checked structure(bytes, how);
  CHECK((structure.summary().problems == 0 && structure.summary().whole_frames == 6));
  CHECK(structure.summary().payload_bytes == checked.summary().payload_bytes);
  CHECK(fvv_checker_track(structure.checker, 0)->vertices == 16);
}

TEST_CASE("3032: the meshes of a group have the same normal bits") {
  Stream source = good_stream(0);
  const uint8_t bits[3] = {0, 12, 8};
  for (int g = 0; g < 3; g++) {
    Group group = {6 * g, 6 * g + 6, {}};
    for (int f = 0; f < 3; f++) group.chunks.push_back(mesh_chunk(6 * g + 2 * f, f, 1, 0, bits[g]));
    source.groups.push_back(group);
  }
  for (const bool decode : {true, false}) {
    Check how;
    how.decode = decode;
    const Checked good(write(source), how);
    CHECK((good.status == FVV_OK && good.summary().problems == 0));
    const fvv_track_summary &track = *fvv_checker_track(good.checker, 0);
    CHECK((track.with_normals == 6 && track.min_normal_bits == 8 && track.max_normal_bits == 12));
    for (size_t g = 0; g < 3; g++) {
      Stream spoilt = source;
      spoilt.groups[g].chunks[2] = mesh_chunk(6 * int64_t(g) + 4, 2, 1, 0, g == 1 ? 0 : 2);
      const Checked checked(write(spoilt), how);
      REQUIRE(checked.summary().problems == 1);
      const fvv_diagnostic *problem = fvv_checker_problem(checked.checker, 0);
      CHECK((problem->issue == FVV_ISSUE_MESH_NORMAL_GROUP && problem->chunk_type == FVV_CHUNK_MESH));
      CHECK(checked.summary().whole_frames == 8);
    }
  }
}

TEST_CASE("3016: the meshes of a group have the same texture bits, groups may differ") {
  // By frame: a group without texture coordinates, one with 12 bits, one with 8.
  Stream source = good_stream(0);
  source.configuration.insert(source.configuration.begin() + 3, track_chunk(3, FVV_TRACK_MESH));
  const uint8_t bits[3] = {0, 12, 8};
  for (int g = 0; g < 3; g++) {
    Group group = {6 * g, 6 * g + 6, {}};
    for (int f = 0; f < 3; f++) {
      group.chunks.push_back(mesh_chunk(6 * g + 2 * f, f, 1, bits[g]));
      group.chunks.push_back(mesh_chunk(6 * g + 2 * f, f, 3, 5)); // another track is another matter
    }
    source.groups.push_back(group);
  }
  for (const bool decode : {true, false}) {
    Check how;
    how.decode = decode;
    const Checked good(write(source), how);
    CHECK((good.status == FVV_OK && good.summary().problems == 0 && good.summary().whole_frames == 9));
    const fvv_track_summary &first = *fvv_checker_track(good.checker, 0),
                            &second = *fvv_checker_track(good.checker, 1);
    CHECK((first.track == 1 && first.textured == 6 && first.min_texture_bits == 8 &&
           first.max_texture_bits == 12));
    CHECK((second.track == 3 && second.textured == 9 && second.min_texture_bits == 5));
    // Frame 2 of each group in turn departs from frames 0 and 1.
    for (size_t g = 0; g < 3; g++)
      for (const uint8_t other : {0, 1, 12, 16}) {
        if (other == bits[g]) continue;
        Stream spoilt = source;
        spoilt.groups[g].chunks[4] = mesh_chunk(6 * int64_t(g) + 4, 2, 1, other);
        const Bytes bytes = write(spoilt);
        const Checked checked(bytes, how);
        REQUIRE(checked.summary().problems == 1);
        const fvv_diagnostic *problem = fvv_checker_problem(checked.checker, 0);
        CHECK((problem->issue == FVV_ISSUE_MESH_TEXTURE_GROUP && problem->chunk_type == FVV_CHUNK_MESH));
        CHECK(problem->offset == chunks_of(bytes)[9 + 8 * g + 1 + 4].offset + 32 + 2);
        CHECK(std::string(problem->message) ==
              std::to_string(other) + " texture bits, the first mesh of the track in this group has " +
                  std::to_string(bits[g]));
        std::vector<int64_t> whole;
        for (int64_t f = 0; f < 9; f++)
          if (f != 3 * int64_t(g) + 2) whole.push_back(2 * f);
        CHECK(whole_times(checked) == whole);
      }
  }
}

TEST_CASE("counts beyond the limits") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = 3;
  Check how;
  how.limits = &limits;
  const Checked checked(write(good_stream(1)), how);
  CHECK(checked.summary().problems == 2);
  CHECK(fvv_checker_problem(checked.checker, 0)->status == FVV_ERROR_LIMIT);
  CHECK(whole_times(checked) == std::vector<int64_t>{2});
  fvv_limits_default(&limits);
  limits.max_payload = 50;
  CHECK(Checked(write(good_stream(1)), how).summary().whole_frames == 0);
}

TEST_CASE("a thousand problems are kept and all are counted") {
  Stream source = good_stream(0);
  Group group = {0, 3000, {}};
  for (int f = 0; f < 1500; f++) {
    group.chunks.push_back(mesh_chunk(2 * f, f));
    group.chunks.back().payload[FVV_MESH_SIZE + 12 * 4] = 9;
  }
  source.groups.push_back(group);
  const Checked checked(write(source));
  CHECK((checked.summary().problems == 1500 && checked.summary().whole_frames == 0));
  CHECK(fvv_checker_problem_count(checked.checker) == 1000);
  CHECK(fvv_checker_problem(checked.checker, 0)->offset < fvv_checker_problem(checked.checker, 999)->offset);
  CHECK(!fvv_checker_problem(checked.checker, 1000));
}

TEST_CASE("events are passed on in order before they are checked") {
  const Bytes bytes = write(good_stream(1));
  std::vector<std::pair<fvv_event_kind, uint64_t>> seen;
  fvv_check_options options;
  fvv_check_options_default(&options);
  CHECK(options.decode == 1);
  options.user = &seen;
  options.event = [](void *user, const fvv_event *event) {
    static_cast<decltype(seen) *>(user)->emplace_back(event->kind, event->offset);
  };
  fvv_checker *checker = nullptr;
  REQUIRE(fvv_checker_create(&options, nullptr, nullptr, &checker) == FVV_OK);
  CHECK(fvv_checker_push(checker, bytes.data(), bytes.size()) == FVV_OK);
  CHECK(fvv_checker_finish(checker) == FVV_OK);
  fvv_checker_destroy(checker);
  const std::vector<Place> chunks = chunks_of(bytes);
  REQUIRE(seen.size() == chunks.size() + 2);
  CHECK((seen.front().first == FVV_EVENT_HEADER && seen.back().first == FVV_EVENT_END));
  for (size_t i = 0; i < chunks.size(); i++)
    CHECK((seen[i + 1].first == FVV_EVENT_CHUNK && seen[i + 1].second == chunks[i].offset));
}

TEST_CASE("every allocation of a checker may fail") {
  Bytes bytes = write(good_stream(2));
  bytes[chunks_of(bytes)[9].offset + 40] ^= 1; // so that a problem is kept as well
  int failed = 0;
  for (int64_t n = 0;; n++) {
    fvv_status status = FVV_OK;
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      Check how;
      how.allocator = allocator;
      status = Checked(bytes, how).status;
    });
    if (status == FVV_OK) break;
    INFO("allocation " << n);
    CHECK(status == FVV_ERROR_MEMORY);
    failed++;
  }
  CHECK(failed > 10);
}

TEST_CASE("a stream that is cut within a group ends where its last frame does") {
  Stream source = good_stream();
  const Bytes bytes = write(source);
  const auto places = chunks_of(bytes);
  uint64_t frames = 0;
  int64_t last = -2; // frames are two ticks long
  for (const Place &place : places) {
    const int64_t time = fvv_get_i64(bytes.data() + place.offset + FVV_CHUNK_HEADER_TIME);
    if ((place.type == FVV_CHUNK_MESH || place.type == FVV_CHUNK_VIDEO_PACKET) && time != last) {
      frames++;
      last = time;
    }
    const Checked cut(Bytes(bytes.begin(), bytes.begin() + ptrdiff_t(place.offset + place.extent)));
    INFO("cut at " << place.offset + place.extent);
    CHECK(cut.summary().frames == frames);
    CHECK((cut.summary().start == 0 && cut.summary().end == last + 2));
  }
}
