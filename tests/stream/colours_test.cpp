// Colours in a stream: of key meshes and their delta frames, in any order of frames, and nothing wrong after
// damage.
#include "fvv/frames.h"
#include "mesh_of.h"
#include "stream_fixture.h"

#include <fstream>
#include <iterator>

namespace {

constexpr uint16_t mesh_track = 1, colour_track = 2;
constexpr int frames = 4; // of a group: a key mesh with colours, two delta frames, a key mesh without
constexpr size_t configuration = 3, per_group = frames + 1 + 2;

// A wavy sheet, in the second group also far pieces.
struct Sheet {
  std::vector<int32_t> positions;
  std::vector<uint32_t> faces;
  static constexpr int32_t side = 18;
  Sheet(int group, int t) {
    for (int32_t v = 0; v < side * side; v++) {
      const int32_t x = v % side, y = v / side;
      positions.insert(positions.end(),
                       {31 * x - 200 + 3 * t, 25 * y - 100, (x * x * 3 + 17 * y * x) % 90 - 40});
    }
    for (uint32_t y = 0; y + 1 < side; y++)
      for (uint32_t x = 0; x + 1 < side; x++) {
        const uint32_t a = y * side + x;
        for (const uint32_t i : {a, a + 1, a + side, a + 1, a + side + 1, a + side}) faces.push_back(i);
      }
    for (int32_t far = 0; far < 3 * group; far++) {
      const auto first = uint32_t(positions.size() / 3);
      for (int32_t k = 0; k < 3; k++)
        positions.insert(positions.end(), {900 * far - 700, -900 - 300 * far, 7 * k});
      for (uint32_t k = 0; k < 3; k++) faces.push_back(first + k);
    }
  }
  fvv_mesh mesh() { return mesh_of(positions, faces); }
};

Bytes colours_payload(const fvv_mesh &mesh, int group) {
  Bytes colours;
  for (uint32_t v = 0; v < mesh.vertex_count; v++) {
    const int32_t *p = mesh.lattice + 3 * size_t(v);
    for (const int32_t value : {p[0] / 2, p[1] / 3 + p[0] / 4, p[2] * (group + 1)})
      colours.push_back(uint8_t(value));
  }
  const fvv_colours_header header = {mesh_track, uint8_t(group ? 1 : 9),    uint8_t(group ? 3 : 20),
                                     0,          uint32_t(group ? 67 : 50), 0};
  fvv_bytes payload = {};
  REQUIRE(fvv_colours_encode(&mesh, &header, colours.data(), nullptr, nullptr, &payload, nullptr) == FVV_OK);
  const Bytes out(payload.data, payload.data + payload.size);
  fvv_bytes_free(&payload);
  return out;
}

Stream coloured_stream() {
  Stream out;
  out.configuration = {scene_chunk(), track_chunk(mesh_track, FVV_TRACK_MESH),
                       track_chunk(colour_track, FVV_TRACK_COLOURS)};
  for (int g = 0; g < 2; g++) {
    Group group = {2 * frames * g, 2 * frames * (g + 1), {}};
    fvv_bytes payload = {};
    fvv_mesh_sequence *sequence = nullptr;
    for (int t = 0; t < frames; t++) {
      Sheet sheet(g, t);
      const fvv_mesh mesh = sheet.mesh();
      const bool key = t == 0 || t == 3;
      fvv_mesh_delta_options options;
      fvv_mesh_delta_options_default(&options);
      if (key)
        REQUIRE(fvv_mesh_encode(&mesh, FVV_MESH_RAW, 0, nullptr, &payload, nullptr) == FVV_OK);
      else
        REQUIRE(fvv_mesh_sequence_encode(sequence, mesh.lattice, &options, &payload, nullptr) == FVV_OK);
      const int64_t time = group.start + 2 * t;
      group.chunks.push_back({FVV_CHUNK_MESH, mesh_track, uint8_t(key ? FVV_FLAG_KEY : 0), time,
                              Bytes(payload.data, payload.data + payload.size)});
      if (t) continue;
      REQUIRE(fvv_mesh_sequence_open(&mesh, nullptr, &sequence, nullptr) == FVV_OK);
      group.chunks.push_back({FVV_CHUNK_COLOURS, colour_track, FVV_FLAG_KEY, time, colours_payload(mesh, g)});
    }
    fvv_mesh_sequence_close(sequence);
    fvv_bytes_free(&payload);
    out.groups.push_back(group);
  }
  return out;
}

struct Frames : Opened {
  using Opened::Opened;

  fvv_status frame(size_t f, Bytes &colours) {
    const uint8_t *got = nullptr;
    uint32_t count = 0;
    const fvv_status result = fvv_stream_colours(stream, f, mesh_track, &got, &count, &diagnostic);
    CHECK((result == FVV_OK) == (got != nullptr));
    colours.assign(got, got + 3 * size_t(count));
    return result;
  }
};

} // namespace

TEST_CASE("delta frames have the colours of their key mesh, in any order of frames") {
  const Bytes bytes = write(coloured_stream());
  Frames opened(bytes);
  REQUIRE(opened.status == FVV_OK);
  Bytes first[2], colours;
  for (const size_t f : {0, 4, 2, 6, 1, 5, 0, 4, 3, 7, 2}) {
    const fvv_status status = opened.frame(f, colours);
    CHECK(status == (f % frames == 3 ? FVV_END : FVV_OK));
    if (status != FVV_OK) continue;
    Sheet sheet(int(f / frames), 0);
    CHECK(colours.size() == sheet.positions.size());
    if (first[f / frames].empty()) first[f / frames] = colours;
    CHECK(colours == first[f / frames]);
  }
  const uint8_t *none = nullptr;
  uint32_t count = 0;
  CHECK(fvv_stream_colours(opened.stream, 0, colour_track, &none, &count, nullptr) == FVV_END);
  for (const bool decode : {true, false}) {
    Check how;
    how.decode = decode;
    const Checked checked(bytes, how);
    INFO(checked.report());
    CHECK(checked.summary().problems == 0);
    CHECK(checked.summary().whole_frames == 2 * frames);
    const fvv_track_summary *track = fvv_checker_track(checked.checker, 1);
    CHECK(track->kind == FVV_TRACK_COLOURS);
    CHECK(track->chunks == 2);
    CHECK((track->min_cell_size == 50 && track->max_cell_size == 67));
    CHECK(track->cells > 100);
  }
}

TEST_CASE("a frame of a live stream is complete with its last chunk, with and without colours") {
  const Bytes bytes = write(coloured_stream());
  const auto places = chunks_of(bytes);
  // Key mesh with colours: with these; delta frames: with the mesh.
  const size_t ends[] = {configuration + 2, configuration + 3, configuration + 4};
  for (size_t f = 0; f < 3; f++) {
    fvv_frames *handle = nullptr;
    REQUIRE(fvv_frames_create(nullptr, nullptr, nullptr, &handle) == FVV_OK);
    const Place &last = places[ends[f]];
    REQUIRE(fvv_frames_push(handle, bytes.data(), last.offset + last.extent) == FVV_OK);
    fvv_frames_event event;
    size_t seen = 0;
    while (fvv_frames_next(handle, &event, nullptr) == FVV_OK) seen += event.kind == FVV_FRAMES_FRAME;
    CHECK(seen == f + 1);
    fvv_frames_destroy(handle);
  }
}

TEST_CASE("6201 to 6204: colours that do not fit their stream") {
  struct Fault {
    uint32_t issue;
    void (*spoil)(Stream &);
    bool without_decoding;
  };
  const Fault faults[] = {
      {FVV_ISSUE_COLOURS_PAYLOAD, [](Stream &s) { s.groups[0].chunks[1].payload.resize(9); }, true},
      {FVV_ISSUE_COLOURS_PAYLOAD, [](Stream &s) { s.groups[0].chunks[1].payload[0] = 0; }, true},
      {FVV_ISSUE_COLOURS_MESH, [](Stream &s) { s.groups[0].chunks[1].payload[2] = colour_track; }, true},
      {FVV_ISSUE_COLOURS_MESH, [](Stream &s) { s.groups[0].chunks[1].payload[4]++; }, false},
      {FVV_ISSUE_COLOURS_MESH, [](Stream &s) { std::swap(s.groups[0].chunks[0], s.groups[0].chunks[1]); },
       false},
      // At the time of a delta frame, with the mesh of that frame.
      {FVV_ISSUE_COLOURS_MESH,
       [](Stream &s) {
         Chunk late = s.groups[0].chunks[1];
         late.time = s.groups[0].chunks[2].time;
         s.groups[0].chunks.insert(s.groups[0].chunks.begin() + 3, late);
       },
       false},
      {FVV_ISSUE_COLOURS_CELLS, [](Stream &s) { s.groups[0].chunks[1].payload[12]++; }, false},
      {FVV_ISSUE_COLOURS_STREAM, [](Stream &s) { s.groups[0].chunks[1].payload.pop_back(); }, false},
  };
  for (const Fault &fault : faults) {
    Stream stream = coloured_stream();
    fault.spoil(stream);
    const Bytes bytes = write(stream);
    check_finds(bytes, fault.issue, fault.without_decoding);
  }
  // Without the key flag.
  Stream stream = coloured_stream();
  Chunk again = stream.groups[0].chunks[1];
  again.flags = 0;
  again.time = stream.groups[0].chunks[4].time;
  stream.groups[0].chunks.push_back(again);
  const Bytes bytes = write(stream);
  const Checked checked(bytes);
  REQUIRE(checked.summary().problems == 1);
  CHECK(fvv_checker_problem(checked.checker, 0)->issue == FVV_ISSUE_COLOURS_PAYLOAD);
  Frames opened(bytes);
  Bytes colours;
  CHECK(opened.frame(3, colours) == FVV_ERROR_INVALID);
  CHECK(opened.diagnostic.issue == FVV_ISSUE_COLOURS_PAYLOAD);
}

TEST_CASE("damage never yields wrong colours") {
  const Bytes good = write(coloured_stream());
  const auto places = chunks_of(good);
  Frames whole(good);
  for (size_t c = configuration + 1; c < configuration + per_group - 1; c++) {
    Bytes bad = good;
    bad[places[c].offset + 50] ^= 4;
    const Checked checked(bad);
    CHECK(checked.summary().problems == 1);
    Frames opened(bad);
    for (size_t f = 0; f < 2 * frames; f++) {
      Bytes wanted, found;
      const fvv_status expected = whole.frame(f, wanted), status = opened.frame(f, found);
      // A frame whose mesh is damaged might be patched: its vertices are not known, nor those of frames after
      // it.
      if (f < frames && expected == FVV_OK && c > configuration + 2 && c <= configuration + 2 + f)
        CHECK(status == FVV_ERROR_DAMAGED);
      else if (f >= frames || c > configuration + 2)
        CHECK(status == expected);
      if (status == FVV_OK) CHECK(found == wanted);
    }
  }
}

// Not run by default: test_stream '[make]' writes the vector again, after a change of the format.
TEST_CASE("write the vector of colours", "[.][make]") {
  write_vector(FVV_CASES "/vector_colours_sheet/input.fvv", write(coloured_stream()));
}

TEST_CASE("colours of the vector are those of the decoder that was written from the specification") {
  std::ifstream file(FVV_CASES "/vector_colours_sheet/input.fvv", std::ios::binary);
  std::ifstream list(FVV_LISTINGS "/colours_sheet.crc");
  Frames opened(Bytes(std::istreambuf_iterator<char>(file), {}));
  REQUIRE(opened.status == FVV_OK);
  CHECK(opened.bytes == write(coloured_stream()));
  size_t count = 0;
  for (std::string crc; list >> crc; count++) {
    Bytes colours;
    const fvv_status status = opened.frame(count, colours);
    CHECK((status == FVV_END) == (crc == "none"));
    if (status == FVV_OK)
      CHECK(fvv_crc32c(0, colours.data(), colours.size()) == std::stoul(crc, nullptr, 16));
  }
  CHECK(count == 2 * frames);
}
