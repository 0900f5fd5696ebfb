// Frames by number, the configuration rules that concern several chunks, and the texturing options of a
// block.
#include "base/layout.h"
#include "stream_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

namespace {

// The first lattice coordinate of the second vertex identifies the mesh.
int mesh_number(fvv_stream *stream, size_t frame, fvv_status expected = FVV_OK) {
  fvv_mesh mesh;
  fvv_diagnostic diagnostic;
  const fvv_status status = fvv_stream_mesh(stream, frame, 1, &mesh, &diagnostic);
  CHECK(status == expected);
  if (status != FVV_OK) {
    CHECK(mesh.lattice == nullptr);
    return -1;
  }
  const int number = mesh.lattice[3] - 10;
  fvv_mesh_free(&mesh);
  return number;
}
int sample_number(fvv_stream *stream, size_t frame, fvv_status expected = FVV_OK) {
  const uint8_t *sample;
  size_t size;
  int key = 0;
  const fvv_status status = fvv_stream_sample(stream, frame, 2, &sample, &size, &key, nullptr);
  CHECK(status == expected);
  CHECK((status == FVV_OK) == (sample != nullptr));
  if (status != FVV_OK) return -1;
  CHECK((key && size == 22));
  return sample[6];
}

// The configuration of the stream's only group, by both interfaces.
fvv_diagnostic configuration_problem(const Stream &stream) {
  const Bytes bytes = write(stream);
  Opened opened(bytes);
  REQUIRE(opened.status == FVV_OK);
  const fvv_configuration *configuration;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_configuration(opened.stream, 0, &configuration, &diagnostic);
  CHECK(status == diagnostic.status);
  fvv_checker *checker = nullptr;
  REQUIRE(fvv_checker_create(nullptr, nullptr, nullptr, &checker) == FVV_OK);
  CHECK(fvv_checker_push(checker, bytes.data(), bytes.size()) == FVV_OK);
  CHECK(fvv_checker_finish(checker) == FVV_OK);
  CHECK((fvv_checker_configuration(checker) != nullptr) == (status == FVV_OK));
  bool found = status == FVV_OK;
  for (size_t i = 0; i < fvv_checker_problem_count(checker); i++) {
    const fvv_diagnostic *problem = fvv_checker_problem(checker, i);
    found = found || (problem->issue == diagnostic.issue && problem->offset == diagnostic.offset &&
                      std::string(problem->message) == diagnostic.message);
  }
  CHECK(found);
  fvv_checker_destroy(checker);
  return diagnostic;
}

} // namespace

TEST_CASE("frames are numbered over groups") {
  for (const bool finish : {true, false}) {
    Stream source = good_stream();
    source.finish = finish;
    Opened opened(write(source));
    REQUIRE(opened.status == FVV_OK);
    REQUIRE(fvv_stream_frame_count(opened.stream) == 9);
    for (size_t frame : {8, 0, 4, 1, 7, 3, 2, 6, 5}) {
      fvv_frame info;
      REQUIRE(fvv_stream_frame(opened.stream, frame, &info, nullptr) == FVV_OK);
      CHECK((info.time == int64_t(2 * frame) && info.group == frame / 3));
      const int number = int(frame);
      if (frame % 3 == 1)
        mesh_number(opened.stream, frame, FVV_END);
      else
        CHECK(mesh_number(opened.stream, frame) == number);
      if (frame % 3 == 2)
        sample_number(opened.stream, frame, FVV_END);
      else
        CHECK(sample_number(opened.stream, frame) == number);
    }
    fvv_frame info;
    fvv_diagnostic diagnostic;
    CHECK(fvv_stream_frame(opened.stream, 9, &info, &diagnostic) == FVV_ERROR_ARGUMENT);
    CHECK(std::string(diagnostic.message) == "frame 9 of 9");
    // Tracks that are none, or of the other kind.
    fvv_mesh mesh;
    CHECK(fvv_stream_mesh(opened.stream, 0, 2, &mesh, nullptr) == FVV_END);
    const uint8_t *sample;
    size_t size;
    int key;
    CHECK(fvv_stream_sample(opened.stream, 0, 1, &sample, &size, &key, nullptr) == FVV_END);
    CHECK(fvv_stream_sample(opened.stream, 0, 9, &sample, &size, &key, nullptr) == FVV_END);
  }
}

TEST_CASE("a configuration is found by group and by identifier") {
  Stream source = good_stream();
  source.repeat = true;
  Opened opened(write(source));
  for (const size_t group : {0, 2, 1}) {
    const fvv_configuration *c;
    REQUIRE(fvv_stream_configuration(opened.stream, group, &c, nullptr) == FVV_OK);
    CHECK((c->track_count == 2 && c->camera_count == 2 && c->video_count == 1 && c->metadata_count == 1));
    CHECK((c->scene.frame_duration == 2 && c->scene.up_axis == FVV_UP_Y));
    CHECK(std::string(c->metadata[0].text, c->metadata[0].size) == "{\"a\": 1}");
    REQUIRE(fvv_configuration_track(c, 2));
    CHECK(std::string(fvv_configuration_track(c, 2)->name, 4) == "name");
    CHECK((fvv_configuration_camera(c, 1) == &c->cameras[1] && !fvv_configuration_camera(c, 2)));
    REQUIRE(fvv_configuration_video(c, 2));
    CHECK((fvv_configuration_video(c, 2)->tile_count == 2 && !fvv_configuration_video(c, 1)));
    CHECK(fvv_configuration_video(c, 2)->tiles[1].destination.x == 32);
    CHECK(!fvv_configuration_track(c, 3));
  }
  const fvv_configuration *c;
  CHECK(fvv_stream_configuration(opened.stream, 3, &c, nullptr) == FVV_ERROR_ARGUMENT);
}

TEST_CASE("rules between chunks of a configuration") {
  struct Case {
    const char *what;
    uint32_t issue;
    std::vector<Chunk> chunks; // after SCEN, TRAK 1, TRAK 2
  };
  const auto tile = [](uint16_t camera, fvv_rect from, fvv_rect to) { return fvv_tile{camera, from, to}; };
  const Chunk c0 = camera_chunk(0), c1 = camera_chunk(1), video = video_chunk(2),
              tiles = tiles_chunk(2, two_tiles);
  for (const Case &c : {
           Case{"good", 0, {c0, c1, video, tiles}},
           {"one camera's whole picture", 0, {c0, video, tiles_chunk(2, {two_tiles[0]})}},
           {"an atlas", 0, {video_chunk(2, FVV_SHOWS_ATLAS)}},
           {"VCFG of a mesh track", FVV_ISSUE_CONFIGURATION_TRACK, {c0, c1, video, tiles, video_chunk(1)}},
           {"VCFG of no track", FVV_ISSUE_CONFIGURATION_TRACK, {c0, c1, video, tiles, video_chunk(7)}},
           {"two VCFG", FVV_ISSUE_CONFIGURATION_TRACK, {c0, c1, video, video, tiles}},
           {"two TILE", FVV_ISSUE_CONFIGURATION_TRACK, {c0, c1, video, tiles, tiles}},
           {"TILE of a mesh track",
            FVV_ISSUE_CONFIGURATION_TRACK,
            {c0, c1, video, tiles, tiles_chunk(1, two_tiles)}},
           {"no VCFG", FVV_ISSUE_CONFIGURATION_VIDEO, {c0, c1}},
           {"no VCFG, but TILE", FVV_ISSUE_CONFIGURATION_VIDEO, {c0, c1, tiles}},
           {"no TILE", FVV_ISSUE_CONFIGURATION_VIDEO, {c0, c1, video}},
           {"TILE of an atlas",
            FVV_ISSUE_CONFIGURATION_VIDEO,
            {c0, c1, video_chunk(2, FVV_SHOWS_ATLAS), tiles}},
           {"camera twice", FVV_ISSUE_CONFIGURATION_CAMERA, {c0, c1, c1, video, tiles}},
           {"tile of no camera", FVV_ISSUE_CONFIGURATION_CAMERA, {c0, video, tiles}},
           {"source outside on the right",
            FVV_ISSUE_TILE_RECT,
            {c0, c1, video, tiles_chunk(2, {two_tiles[0], tile(1, {1, 0, 32, 16}, {32, 0, 32, 16})})}},
           {"source outside below",
            FVV_ISSUE_TILE_RECT,
            {c0, c1, video, tiles_chunk(2, {two_tiles[0], tile(1, {0, 8, 32, 9}, {32, 0, 32, 16})})}},
           {"source outside beyond 16 bits",
            FVV_ISSUE_TILE_RECT,
            {c0, c1, video, tiles_chunk(2, {two_tiles[0], tile(1, {65535, 0, 32, 16}, {32, 0, 32, 16})})}},
           {"destination outside",
            FVV_ISSUE_TILE_RECT,
            {c0, c1, video, tiles_chunk(2, {two_tiles[0], tile(1, {0, 0, 32, 16}, {48, 0, 32, 16})})}},
       }) {
    INFO(c.what);
    Stream source = good_stream(1);
    source.configuration.resize(3);
    source.configuration.insert(source.configuration.end(), c.chunks.begin(), c.chunks.end());
    const fvv_diagnostic diagnostic = configuration_problem(source);
    CHECK(diagnostic.issue == c.issue);
    if (!c.issue) continue;
    CHECK(diagnostic.status == FVV_ERROR_INVALID);
    CHECK(diagnostic.offset >= 24);
    CHECK(diagnostic.chunk_type != 0);
  }
}

TEST_CASE("tiles that overlap and a camera that has two") {
  // The encoder refuses both: a good record is spoilt.
  const size_t second = FVV_TILE_SIZE + FVV_TILE_ENTRY_SIZE;
  for (const auto &[at, value] : {std::pair(second + FVV_TILE_ENTRY_DESTINATION, uint8_t(16)),
                                  {second + FVV_TILE_ENTRY_CAMERA, uint8_t(0)}}) {
    Stream source = good_stream(1);
    for (Chunk &chunk : source.configuration)
      if (chunk.type == FVV_CHUNK_TILES) chunk.payload[at] = value;
    const fvv_diagnostic diagnostic = configuration_problem(source);
    INFO(diagnostic.message);
    CHECK(diagnostic.issue == FVV_ISSUE_TILE_OVERLAP);
  }
}

TEST_CASE("limits of a configuration") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  const Bytes bytes = write(good_stream(1));
  const auto status = [&] {
    Opened opened(bytes, nullptr, &limits);
    REQUIRE(opened.status == FVV_OK);
    const fvv_configuration *configuration;
    return fvv_stream_configuration(opened.stream, 0, &configuration, nullptr);
  };
  limits.max_cameras = 2;
  CHECK(status() == FVV_OK);
  limits.max_cameras = 1;
  CHECK(status() == FVV_ERROR_LIMIT);
  limits.max_cameras = 1024;
  limits.max_text = 7; // of META, which is left out
  CHECK(status() == FVV_OK);
  limits.max_text = 3; // of a name
  CHECK(status() == FVV_ERROR_LIMIT);
  limits.max_text = 8;
  limits.max_tracks = 1;
  CHECK(status() == FVV_ERROR_LIMIT);
}

TEST_CASE("a group whose configuration block is lost has that of a repetition, or an error") {
  for (const bool repeated : {true, false}) {
    Stream source = good_stream(3);
    source.repeat = repeated;
    Bytes bytes = write(source);
    // A byte that is missing hides where the block is, and the footer does not fit.
    const char scene[] = {'S', 'C', 'E', 'N'};
    bytes.erase(std::search(bytes.begin(), bytes.end(), scene, scene + 4));
    Opened opened(bytes);
    REQUIRE(opened.status == FVV_OK);
    REQUIRE(fvv_stream_group(opened.stream, 0)->configuration_offset == 0);
    const fvv_configuration *configuration = nullptr;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_stream_configuration(opened.stream, 0, &configuration, &diagnostic);
    CHECK(status == (repeated ? FVV_OK : FVV_ERROR_DAMAGED));
    if (repeated) CHECK(configuration->scene.lattice_step > 0);
    if (!repeated) CHECK(diagnostic.issue == FVV_ISSUE_GROUP_CONFIGURATION);
  }
}

TEST_CASE("a damaged chunk loses its frame alone") {
  const Bytes good = write(good_stream());
  for (const Place &place : chunks_of(good)) {
    if (place.type != FVV_CHUNK_MESH && place.type != FVV_CHUNK_VIDEO_PACKET) continue;
    Bytes bytes = good;
    bytes[place.offset + 36] ^= 4;
    Opened opened(bytes);
    REQUIRE(opened.status == FVV_OK);
    int failures = 0;
    for (size_t frame = 0; frame < 9; frame++) {
      fvv_mesh mesh;
      fvv_diagnostic d = {};
      fvv_status status = fvv_stream_mesh(opened.stream, frame, 1, &mesh, &d);
      if (status == FVV_OK) {
        CHECK(mesh.lattice[3] == 10 + int32_t(frame));
        fvv_mesh_free(&mesh);
      }
      failures += status < 0;
      if (status < 0) CHECK((d.issue == FVV_ISSUE_PAYLOAD_CRC && d.offset == place.offset));
      const uint8_t *sample;
      size_t size;
      int key;
      status = fvv_stream_sample(opened.stream, frame, 2, &sample, &size, &key, &d);
      if (status == FVV_OK) CHECK(sample[6] == frame);
      failures += status < 0;
      if (status < 0) CHECK((d.issue == FVV_ISSUE_PAYLOAD_CRC && d.offset == place.offset));
    }
    CHECK(failures == 1);
  }
}

TEST_CASE("every allocation of a stream may fail") {
  const Bytes bytes = write(good_stream());
  int failed = 0;
  for (int64_t n = 0;; n++) {
    fvv_status worst = FVV_OK;
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      Opened opened(bytes, allocator);
      worst = opened.status;
      for (size_t frame = 0; opened.status == FVV_OK && frame < 9; frame++) {
        fvv_mesh mesh;
        fvv_status status = fvv_stream_mesh(opened.stream, frame, 1, &mesh, nullptr);
        if (status == FVV_OK) fvv_mesh_free(&mesh);
        if (status < 0) worst = status;
        const uint8_t *sample;
        size_t size;
        int key;
        status = fvv_stream_sample(opened.stream, frame, 2, &sample, &size, &key, nullptr);
        if (status < 0) worst = status;
      }
    });
    if (worst == FVV_OK) break;
    INFO("allocation " << n);
    CHECK(worst == FVV_ERROR_MEMORY);
    failed++;
  }
  CHECK(failed > 10);
}

// ---- TEXR: the texturing options of a block, the defaults without, and each rule by its number.

namespace {

constexpr fvv_texturing wanted = {0.125, 0.4, 1.5, 0.002, 5, {10, 20, 255}, FVV_BLEND_PAPER};

Chunk texturing_chunk() {
  return {FVV_CHUNK_TEXTURING, 0, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_texturing_encode(&wanted, out, n, size, nullptr);
          })};
}

fvv_diagnostic problem_of(const Bytes &payload) {
  fvv_texturing out;
  fvv_diagnostic d = {};
  const fvv_status status = fvv_texturing_decode(&out, payload.data(), payload.size(), &d);
  CHECK(status == (d.issue ? FVV_ERROR_INVALID : FVV_OK));
  return d;
}

Stream vector_stream(bool has_chunk) {
  Stream out = good_stream(2);
  out.repeat = true;
  if (has_chunk) out.configuration.push_back(texturing_chunk());
  return out;
}

const char *path_of(bool has_chunk, bool text) {
  if (text) return has_chunk ? FVV_LISTINGS "/texturing_explicit.txt" : FVV_LISTINGS "/texturing_default.txt";
  return has_chunk ? FVV_CASES "/vector_texturing_explicit/input.fvv"
                   : FVV_CASES "/vector_texturing_default/input.fvv";
}

Bytes contents(const char *path) {
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file.good());
  return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

TEST_CASE("texturing has the values of the block, and the defaults without") {
  for (const bool sent : {false, true}) {
    Stream source = good_stream(1);
    if (sent) source.configuration.push_back(texturing_chunk());
    Opened opened(write(source));
    const fvv_configuration *c = nullptr;
    REQUIRE(fvv_stream_configuration(opened.stream, 0, &c, nullptr) == FVV_OK);
    CHECK(bool(c->has_texturing) == sent);
    const fvv_texturing &t = c->texturing;
    CHECK(t.threshold == (sent ? 0.125 : 0.05));
    CHECK(t.depth_bias == (sent ? 0.4 : 0.2));
    CHECK(t.depth_slope == (sent ? 1.5 : 0.5));
    CHECK(t.inset == (sent ? 0.002 : 0));
    CHECK(t.best == (sent ? 5 : 3));
    CHECK(t.unseen[0] == (sent ? 10 : 128));
    CHECK(t.unseen[2] == (sent ? 255 : 128));
    CHECK(t.blend == (sent ? FVV_BLEND_PAPER : FVV_BLEND_VIEWER));
  }
}

TEST_CASE("an invalid ancillary chunk takes no more than itself and its track") {
  Chunk wide = texturing_chunk();
  wide.payload[0] = 0xff; // no cosine
  wide.payload[7] = 0x7f;
  Chunk codec = video_chunk(2);
  std::memcpy(codec.payload.data(), "abcd", 4);
  struct Case {
    const char *what;
    uint32_t issue;
    std::vector<Chunk> chunks; // after SCEN, TRAK 1, TRAK 2
    size_t metadata, videos;
    bool textured;
  };
  const Chunk c0 = camera_chunk(0), c1 = camera_chunk(1), video = video_chunk(2),
              tiles = tiles_chunk(2, two_tiles), text = text_chunk("{}");
  for (const Case &c :
       {Case{"text is not UTF-8",
             FVV_ISSUE_TEXT,
             {c0, c1, video, tiles, text_chunk("\"\xff\""), text},
             1,
             1,
             0},
        {"text with NUL",
         FVV_ISSUE_TEXT,
         {c0, c1, video, tiles, text_chunk(std::string("{\0}", 3))},
         0,
         1,
         0},
        {"TEXR out of range", FVV_ISSUE_TEXTURING_RANGE, {c0, c1, video, tiles, wide}, 0, 1, 0},
        {"two TEXR",
         FVV_ISSUE_TEXTURING_PAYLOAD,
         {c0, c1, video, tiles, texturing_chunk(), texturing_chunk()},
         0,
         1,
         1},
        {"a codec that is not known", FVV_ISSUE_VIDEO_CODEC, {c0, c1, codec, tiles}, 0, 0, 0}}) {
    INFO(c.what);
    Stream source = good_stream(1);
    source.configuration.resize(3);
    source.configuration.insert(source.configuration.end(), c.chunks.begin(), c.chunks.end());
    const Bytes bytes = write(source);
    const Checked checked(bytes);
    REQUIRE(checked.problem_count() == 1);
    CHECK(checked.problem(0).issue == c.issue);
    CHECK(checked.summary().whole_frames == checked.summary().frames);
    CHECK(checked.summary().frames > 0);
    const fvv_configuration *configuration = nullptr;
    Opened opened(bytes);
    REQUIRE(fvv_stream_configuration(opened.stream, 0, &configuration, nullptr) == FVV_OK);
    CHECK(configuration->metadata_count == c.metadata);
    CHECK(configuration->video_count == c.videos);
    CHECK((configuration->has_texturing != 0) == c.textured);
    CHECK(configuration->texturing.threshold == (c.textured ? wanted.threshold : 0.05));
  }
}

TEST_CASE("6101, 6102: texturing out of range, of another size, or twice") {
  const Bytes good = texturing_chunk().payload;
  REQUIRE(good.size() == 40);
  REQUIRE(problem_of(good).issue == 0);
  const auto with = [&](size_t at, double value) {
    Bytes bad = good;
    std::memcpy(&bad[at], &value, sizeof value);
    return problem_of(bad);
  };
  for (const double value : {-0.01, 1.01, double(NAN), double(INFINITY)}) {
    CHECK(with(0, value).issue == FVV_ISSUE_TEXTURING_RANGE);
    CHECK(with(0, value).offset == 0);
  }
  CHECK(with(0, 0).issue == 0);
  CHECK(with(0, 1).issue == 0);
  for (const size_t at : {8u, 16u, 24u}) {
    for (const double value : {-0.01, double(NAN), double(INFINITY)}) {
      CHECK(with(at, value).issue == FVV_ISSUE_TEXTURING_RANGE);
      CHECK(with(at, value).offset == at);
    }
    CHECK(with(at, 0).issue == 0);
  }
  Bytes bad = good;
  bad[32] = 0;
  CHECK(problem_of(bad).issue == FVV_ISSUE_TEXTURING_RANGE);
  bad = good;
  bad[36] = 2;
  CHECK(problem_of(bad).issue == FVV_ISSUE_TEXTURING_RANGE);
  CHECK(problem_of(bad).offset == 36);
  for (size_t at = 37; at < 40; at++) {
    bad = good;
    bad[at] = 1;
    CHECK(problem_of(bad).issue == FVV_ISSUE_TEXTURING_PAYLOAD);
  }
  for (size_t size = 0; size < 40; size++) // in a block of exactly that size
    CHECK(problem_of(Bytes(good.begin(), good.begin() + std::ptrdiff_t(size))).issue ==
          FVV_ISSUE_TEXTURING_PAYLOAD);
  bad = good;
  bad.push_back(0); // of a later version
  CHECK(problem_of(bad).issue == 0);

  Stream twice = good_stream(1);
  for (int i = 0; i < 2; i++) twice.configuration.push_back(texturing_chunk());
  Opened opened(write(twice));
  const fvv_configuration *c = nullptr;
  fvv_diagnostic d = {};
  CHECK(fvv_stream_configuration(opened.stream, 0, &c, &d) == FVV_OK);
  CHECK(c->texturing.threshold == wanted.threshold);

  fvv_texturing none = wanted;
  none.best = 0;
  size_t written = 0;
  uint8_t out[40];
  CHECK(fvv_texturing_encode(&none, out, sizeof out, &written, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_texturing_encode(&wanted, out, 39, &written, nullptr) == FVV_ERROR_BUFFER_TOO_SMALL);
}

TEST_CASE("libfvv reads of the vectors what the plain reader of the specification reads") {
  for (const bool has_chunk : {false, true}) {
    const Bytes bytes = contents(path_of(has_chunk, false)), text = contents(path_of(has_chunk, true));
    Opened opened(bytes);
    std::ostringstream ours;
    for (size_t g = 0; g < 2; g++) {
      const fvv_configuration *c = nullptr;
      REQUIRE(fvv_stream_configuration(opened.stream, g, &c, nullptr) == FVV_OK);
      const fvv_texturing &t = c->texturing;
      ours << g << ' ' << t.threshold << ' ' << t.depth_bias << ' ' << t.depth_slope << ' ' << t.inset << ' '
           << int(t.best);
      for (const uint8_t channel : t.unseen) ours << ' ' << int(channel);
      ours << ' ' << int(t.blend) << '\n';
    }
    CHECK(ours.str() == std::string(text.begin(), text.end()));
  }
}

TEST_CASE("write the texturing vectors", "[.][make]") {
  for (const bool has_chunk : {false, true})
    write_vector(path_of(has_chunk, false), write(vector_stream(has_chunk)));
}
