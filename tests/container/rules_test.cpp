// One faulty stream for each numbered rule of the container and its two records; clauses 3 to 7.
#include "container_fixture.h"

namespace {

// A stream as a list of chunks with a hand on every one; counters are given by the caller.
struct Parts {
  Bytes scene = scene_payload(), mesh_track = track_payload(FVV_TRACK_MESH, "m"),
        video_track = track_payload(FVV_TRACK_VIDEO, "v");
  Bytes head = hand_file_header();

  Bytes block() const {
    return join({hand_chunk("SCEN", 1, 0, 0, 0, scene), hand_chunk("TRAK", 1, 1, 1, 0, mesh_track),
                 hand_chunk("TRAK", 1, 2, 2, 0, video_track)});
  }
  // Digest as of clause 5: CRC over bytes 0 to 27 of the headers of the block.
  uint32_t digest() const {
    uint32_t crc = 0;
    const Bytes all = block();
    for (size_t at = 0; at < all.size(); at += size_t(fvv_chunk_extent(fvv_get_u64(all.data() + at + 16))))
      crc = fvv_crc32c(crc, all.data() + at, 28);
    return crc;
  }
  Bytes group(uint32_t sequence = 0, int64_t start = 0, int64_t end = 10, uint8_t counter = 0) const {
    Bytes p(24);
    fvv_put_u32(p.data(), sequence);
    fvv_put_u32(p.data() + 4, digest());
    fvv_put_i64(p.data() + 8, start);
    fvv_put_i64(p.data() + 16, end);
    return hand_chunk("GRUP", 3, counter, 0, start, p);
  }
  Bytes mesh(uint8_t counter = 1, int64_t time = 0, uint8_t flags = 3, uint16_t track = 1) const {
    return hand_chunk("MESH", flags, counter, track, time, {1, 2, 3});
  }
};

uint32_t issue_of(const Bytes &stream) {
  const Reading reading = read_stream(stream);
  const fvv_diagnostic *problem = reading.first_problem();
  return problem ? problem->issue : 0;
}

// GEND for a group with one mesh chunk.
Bytes group_end(const Parts &p, uint32_t sequence = 0, uint32_t count = 2, int64_t time = 10,
                uint8_t kind_flags = 3, uint8_t extra = 0, uint32_t chain_xor = 0) {
  const Bytes g = p.group(), m = p.mesh();
  uint32_t chain = fvv_crc32c(0, g.data(), 28);
  chain = fvv_crc32c(chain, m.data(), 28) ^ chain_xor;
  Bytes payload(32);
  fvv_put_u32(payload.data(), sequence);
  fvv_put_u32(payload.data() + 4, count);
  fvv_put_u32(payload.data() + 8, chain);
  fvv_put_u32(payload.data() + 12, 1);
  fvv_put_u32(payload.data() + 16, 1);
  fvv_put_u32(payload.data() + 20, 3u + extra);
  memcpy(payload.data() + 24, "MESH", 4);
  fvv_put_u16(payload.data() + 28, 1);
  payload[30] = kind_flags;
  payload.insert(payload.end(), {0, 3, 0}); // kind 0, 3 bytes, time +0
  payload.insert(payload.end(), extra, 0);
  return hand_chunk("GEND", 5, 2, 0, time, payload);
}

} // namespace

TEST_CASE("a stream put together by hand from the specification is good") {
  const Parts p;
  const Bytes body = join({p.head, p.block(), p.group(), p.mesh(), group_end(p)});
  const size_t group_at = 24 + p.block().size();
  Bytes index(8 + 16 + 52);
  fvv_put_u32(index.data(), 1);
  fvv_put_u32(index.data() + 4, 1);
  fvv_put_u64(index.data() + 8, 24);
  fvv_put_u32(index.data() + 16, uint32_t(group_at - 24));
  fvv_put_u32(index.data() + 20, fvv_get_u32(body.data() + group_at + 32 + 4));
  uint8_t *e = index.data() + 24;
  const Bytes end = group_end(p);
  fvv_put_u64(e, group_at);
  fvv_put_u64(e + 8, body.size() - group_at);
  fvv_put_i64(e + 16, 0);
  fvv_put_i64(e + 24, 10);
  fvv_put_u32(e + 32, 0);
  fvv_put_u32(e + 36, 1);
  fvv_put_u32(e + 40, fvv_get_u32(end.data() + 32 + 8));
  fvv_put_u32(e + 44, uint32_t(end.size()));
  fvv_put_u32(e + 48, 0);
  const Bytes indx = hand_chunk("INDX", 0, 0, 0, 0, index);
  Bytes foot(24);
  fvv_put_u64(foot.data(), body.size());
  fvv_put_u64(foot.data() + 8, body.size() + indx.size() + 56);
  fvv_put_u32(foot.data() + 16, fvv_crc32c(0, index.data(), index.size()));
  const Bytes stream = join({body, indx, hand_chunk("FOOT", 1, 1, 0, 0, foot)});
  const Reading reading = read_stream(stream);
  INFO((reading.first_problem() ? reading.first_problem()->message : ""));
  CHECK(reading.good());

  Bytes other_index = index, other_foot = foot;
  for (const size_t at : {0, 4, 8, 16, 20, 24 + 36, 24 + 48}) {
    INFO("byte " << at << " of the index");
    other_index = index;
    other_index[at] ^= 8;
    fvv_put_u32(other_foot.data() + 16, fvv_crc32c(0, other_index.data(), other_index.size()));
    CHECK(issue_of(join({body, hand_chunk("INDX", 0, 0, 0, 0, other_index),
                         hand_chunk("FOOT", 1, 1, 0, 0, other_foot)})) == FVV_ISSUE_INDEX);
  }
  for (const size_t field : {0, 8, 16, 20}) {
    other_foot = foot;
    other_foot[field] ^= 8;
    CHECK(issue_of(join({body, indx, hand_chunk("FOOT", 1, 1, 0, 0, other_foot)})) == FVV_ISSUE_FOOTER);
  }
  CHECK(issue_of(join({stream, {0}})) == FVV_ISSUE_TRAILING);
  CHECK(issue_of(join({stream, stream})) == FVV_ISSUE_TRAILING);
  CHECK(issue_of(join({stream, hand_chunk("zzzz", 0, 2, 0, 0, {})})) == FVV_ISSUE_TRAILING);
  CHECK(issue_of(join({body, indx, hand_chunk("zzzz", 0, 1, 0, 0, {})})) == FVV_ISSUE_CHUNK_PLACE);
}

TEST_CASE("rules of the file header") {
  const Parts p;
  Bytes other = p.head;
  other[0] = 0x88;
  CHECK(issue_of(other) == FVV_ISSUE_SIGNATURE);
  CHECK(issue_of({'P', 'K'}) == FVV_ISSUE_FILE_HEADER_TRUNCATED);
  CHECK(issue_of({}) == FVV_ISSUE_FILE_HEADER_TRUNCATED);
  other = p.head;
  other[9] ^= 1;
  CHECK(issue_of(other) == FVV_ISSUE_FILE_HEADER_CRC);
  CHECK(issue_of(hand_file_header(0, 2, 7)) == FVV_ISSUE_FILE_HEADER_RESERVED);
  CHECK(issue_of(hand_file_header(0, 3)) == FVV_ISSUE_VERSION);
  CHECK(issue_of(hand_file_header(0, 1)) == FVV_ISSUE_VERSION); // another format
  CHECK(issue_of(hand_file_header(1, 0)) == FVV_ISSUE_VERSION);
  CHECK(issue_of(join({hand_file_header(0, 2), p.block()})) == 0);
}

TEST_CASE("rules of chunk headers and payloads") {
  const Parts p;
  const Bytes front = join({p.head, p.block(), p.group()});
  CHECK(issue_of(join({front, Bytes(32, 0)})) == FVV_ISSUE_CHUNK_HEADER);
  CHECK(issue_of(join({front, p.mesh(1, 0, 3 | 8)})) == FVV_ISSUE_CHUNK_FLAGS);
  CHECK(issue_of(join({front, p.mesh(1, 0, 2)})) == FVV_ISSUE_CHUNK_FLAGS); // MESH is critical
  CHECK(issue_of(join({front, hand_chunk("zzzz", 4, 1, 0, 0, {})})) == FVV_ISSUE_CHUNK_FLAGS);
  Bytes bad = p.mesh();
  bad[32] ^= 1;
  CHECK(issue_of(join({front, bad})) == FVV_ISSUE_PAYLOAD_CRC);
  bad = p.mesh();
  bad[36] = 1;
  CHECK(issue_of(join({front, bad})) == FVV_ISSUE_PADDING);
  CHECK(issue_of(join({front, p.mesh(2)})) == FVV_ISSUE_CONTINUITY);
  CHECK(issue_of(join({front, hand_chunk("zzzz", 1, 1, 0, 0, {})})) == FVV_ISSUE_UNKNOWN_CRITICAL);
  CHECK(issue_of(join({front, hand_chunk("DELT", 3, 1, 1, 0, {})})) == FVV_ISSUE_UNKNOWN_CRITICAL);
  bad = p.mesh();
  bad.resize(20);
  CHECK(issue_of(join({front, bad})) == FVV_ISSUE_CHUNK_TRUNCATED);
  bad = p.mesh();
  bad.resize(34);
  CHECK(issue_of(join({front, bad})) == FVV_ISSUE_CHUNK_TRUNCATED);
  CHECK(issue_of(join({front, p.mesh(1, 0, 3, 0)})) == FVV_ISSUE_CHUNK_FIELDS);
  CHECK(issue_of(join({p.head, hand_chunk("SCEN", 1, 0, 3, 0, p.scene)})) == FVV_ISSUE_CHUNK_FIELDS);
  CHECK(issue_of(join({p.head, hand_chunk("SCEN", 1, 0, 0, 3, p.scene)})) == FVV_ISSUE_CHUNK_FIELDS);

  fvv_chunk_header header = {FVV_CHUNK_MESH, 3, 1, 1, 0, UINT64_C(1) << 63, 0, 0};
  fvv_diagnostic d{};
  CHECK(fvv_header_check(&header, 0, &d) == FVV_ERROR_INVALID);
  CHECK(d.issue == FVV_ISSUE_CHUNK_SIZE);
  // Although every limit is smaller.
  Bytes endless = p.mesh();
  fvv_put_u64(endless.data() + 16, UINT64_C(1) << 63);
  fvv_put_u32(endless.data() + 28, fvv_crc32c(0, endless.data(), 28));
  const Reading reading = read_stream(join({front, endless, p.mesh()}));
  CHECK(reading.status == FVV_ERROR_INVALID);
  CHECK(reading.diagnostic.issue == FVV_ISSUE_CHUNK_SIZE);
}

TEST_CASE("limits stop a reader before it holds what they forbid") {
  const Parts p;
  fvv_limits limits;
  fvv_limits_default(&limits);
  const Bytes stream = join({p.head, p.block(), p.group(), p.mesh()});
  const auto stopped = [&](const Bytes &bytes) {
    const Reading reading = read_stream(bytes, 0, &limits);
    return reading.status == FVV_ERROR_LIMIT && reading.diagnostic.issue == FVV_ISSUE_LIMIT;
  };
  CHECK_FALSE(stopped(stream));
  limits.max_payload = 55;
  CHECK(stopped(stream));
  fvv_limits_default(&limits);
  limits.max_tracks = 1;
  CHECK(stopped(stream));
  fvv_limits_default(&limits);
  limits.max_group_chunks = 1;
  CHECK(stopped(stream));
  fvv_limits_default(&limits);
  limits.max_groups = 1;
  CHECK(stopped(small_stream(2)));
  limits.max_groups = 2;
  CHECK_FALSE(stopped(small_stream(2)));

  // A header that claims 2^62 bytes costs nothing: it is refused before anything is waited for.
  Bytes huge = p.mesh();
  fvv_put_u64(huge.data() + 16, UINT64_C(1) << 62);
  fvv_put_u32(huge.data() + 28, fvv_crc32c(0, huge.data(), 28));
  fvv_limits_default(&limits);
  CHECK(stopped(join({p.head, p.block(), p.group(), huge})));
}

TEST_CASE("rules of order") {
  const Parts p;
  CHECK(issue_of(join({p.head, p.group()})) == FVV_ISSUE_NO_CONFIGURATION);
  CHECK(issue_of(join({p.head, hand_chunk("TRAK", 1, 0, 1, 0, p.mesh_track)})) == FVV_ISSUE_CHUNK_PLACE);
  CHECK(issue_of(join({p.head, p.block(), p.mesh(3)})) == FVV_ISSUE_CHUNK_PLACE);
  CHECK(issue_of(join({p.head, p.block(), hand_chunk("FOOT", 1, 3, 0, 0, Bytes(24))})) ==
        FVV_ISSUE_CHUNK_PLACE);
  CHECK(issue_of(join({p.head, p.block(), p.group(), p.mesh(), p.block()})) == FVV_ISSUE_GROUP_UNFINISHED);
  CHECK(issue_of(join({p.head, p.block(), p.group(), p.mesh()})) == FVV_ISSUE_GROUP_UNFINISHED);
}

TEST_CASE("rules of groups") {
  const Parts p;
  const Bytes front = join({p.head, p.block()});
  CHECK(issue_of(join({front, hand_chunk("GRUP", 3, 0, 0, 0, Bytes(23))})) == FVV_ISSUE_GROUP_PAYLOAD);
  CHECK(issue_of(join({front, p.group(1)})) == FVV_ISSUE_GROUP_SEQUENCE);
  CHECK(issue_of(join({front, p.group(0, 5, 5)})) == FVV_ISSUE_GROUP_TIME);
  Bytes other = p.group();
  other[8] = 1; // time of the header
  fvv_put_u32(other.data() + 28, fvv_crc32c(0, other.data(), 28));
  CHECK(issue_of(join({front, other})) == FVV_ISSUE_GROUP_TIME);
  CHECK(issue_of(join({front, p.group(), p.mesh(), group_end(p), p.group(1, 9, 12)})) ==
        FVV_ISSUE_GROUP_TIME);
  Parts changed;
  changed.mesh_track = track_payload(FVV_TRACK_MESH, "n");
  CHECK(issue_of(join({p.head, changed.block(), p.group()})) == FVV_ISSUE_GROUP_CONFIGURATION);
  CHECK(issue_of(join({front, p.group(), p.mesh(1, 10)})) == FVV_ISSUE_CHUNK_TIME);
  CHECK(issue_of(join({front, p.group(), p.mesh(1, -1)})) == FVV_ISSUE_CHUNK_TIME);
  CHECK(issue_of(join({front, p.group(), p.mesh(1, 2), p.mesh(2, 1)})) == FVV_ISSUE_CHUNK_TIME_ORDER);
  CHECK(issue_of(join({front, p.group(), p.mesh(1, 2), p.mesh(2, 2)})) == FVV_ISSUE_CHUNK_TIME_ORDER);
  CHECK(issue_of(join({front, p.group(), p.mesh(1, 0, 3, 7)})) == FVV_ISSUE_TRACK_UNDECLARED);
  CHECK(issue_of(join({front, p.group(), p.mesh(1, 0, 3, 2)})) == FVV_ISSUE_TRACK_KIND_MISMATCH);
  CHECK(issue_of(join({front, p.group(), p.mesh(1, 0, 1)})) == FVV_ISSUE_TRACK_NOT_KEY);
  const Bytes open = join({front, p.group(), p.mesh()});
  CHECK(issue_of(join({open, group_end(p)})) == 0);
  CHECK(issue_of(join({open, group_end(p, 1)})) == FVV_ISSUE_GROUP_END);
  CHECK(issue_of(join({open, group_end(p, 0, 3)})) == FVV_ISSUE_GROUP_END);
  CHECK(issue_of(join({open, group_end(p, 0, 2, 11)})) == FVV_ISSUE_GROUP_END);
  CHECK(issue_of(join({open, group_end(p, 0, 2, 10, 3, 0, 1)})) == FVV_ISSUE_GROUP_END);
  CHECK(issue_of(join({open, group_end(p, 0, 2, 10, 1)})) == FVV_ISSUE_GROUP_TABLE);
  CHECK(issue_of(join({open, group_end(p, 0, 2, 10, 3, 1)})) == FVV_ISSUE_GROUP_TABLE);
}

TEST_CASE("a chunk exchanged for another intact one breaks the chain") {
  const Parts p;
  const Bytes other = hand_chunk("MESH", 3, 1, 1, 0, {1, 2, 4});
  CHECK(issue_of(join({p.head, p.block(), p.group(), other, group_end(p)})) == FVV_ISSUE_GROUP_END);
}

TEST_CASE("TRAK comes first, and scenes agree") {
  const Parts p;
  const Bytes scene = hand_chunk("SCEN", 1, 0, 0, 0, p.scene);
  CHECK(issue_of(join({p.head, scene, hand_chunk("META", 0, 1, 0, 0, {'{', '}'}),
                       hand_chunk("TRAK", 1, 2, 1, 0, p.mesh_track)})) == FVV_ISSUE_CHUNK_PLACE);
  Parts other;
  other.scene[0] = 2;
  CHECK(issue_of(join({p.head, p.block(), other.block()})) == FVV_ISSUE_TIME_BASE);
  other = p;
  other.scene[40] ^= 1;
  CHECK(issue_of(join({p.head, p.block(), other.block()})) == FVV_ISSUE_LATTICE);
  other = p;
  other.scene[48] = FVV_UP_Z;
  CHECK(issue_of(join({p.head, p.block(), other.block()})) == 0);
}

TEST_CASE("good headers nested in bad payloads cost linear time") {
  const Parts p;
  // Each of them claims all the rest, with a CRC that fails only at the end.
  const size_t count = 40000;
  Bytes nested;
  for (size_t i = 0; i < count; i++) {
    Bytes h = hand_chunk("MESH", 3, 1, 1, 0, {});
    fvv_put_u64(h.data() + 16, (count - 1 - i) * 32);
    h[24] = 1;
    fvv_put_u32(h.data() + 28, fvv_crc32c(0, h.data(), 28));
    nested.insert(nested.end(), h.begin(), h.end());
  }
  const Reading reading = read_stream(join({p.head, p.block(), p.group(), nested}));
  CHECK(reading.status == FVV_ERROR_LIMIT);
  CHECK(reading.diagnostic.issue == FVV_ISSUE_LIMIT);
}

TEST_CASE("rules of SCEN and TRAK") {
  const Parts p;
  const auto with_scene = [&](size_t at, uint8_t value) {
    Parts q;
    q.scene[at] = value;
    return issue_of(join({q.head, q.block()}));
  };
  CHECK(with_scene(0, 1) == 0);
  CHECK(with_scene(0, 0) == FVV_ISSUE_TIME_BASE);
  CHECK(with_scene(4, 0) == FVV_ISSUE_TIME_BASE);
  CHECK(with_scene(8, 0) == FVV_ISSUE_TIME_BASE);
  CHECK(with_scene(15, 0x80) == FVV_ISSUE_TIME_BASE);
  CHECK(with_scene(47, 0xbf) == FVV_ISSUE_LATTICE); // step < 0
  CHECK(with_scene(23, 0x7f) == 0);
  Parts nan;
  memset(nan.scene.data() + 16, 0xff, 8);
  CHECK(issue_of(join({nan.head, nan.block()})) == FVV_ISSUE_LATTICE);
  CHECK(with_scene(48, 7) == FVV_ISSUE_UP_AXIS);
  CHECK(with_scene(49, 1) == 0);
  CHECK(with_scene(49, 2) == FVV_ISSUE_SCENE_PAYLOAD);
  for (size_t at = 50; at < 56; at++) CHECK(with_scene(at, 1) == FVV_ISSUE_SCENE_PAYLOAD);
  Parts cut;
  cut.scene.pop_back();
  CHECK(issue_of(join({cut.head, cut.block()})) == FVV_ISSUE_SCENE_PAYLOAD);

  const auto with_track = [&](const Bytes &payload) {
    Parts q;
    q.mesh_track = payload;
    return issue_of(join({q.head, q.block()}));
  };
  Bytes t = p.mesh_track;
  t[0] = 0;
  CHECK(with_track(t) == FVV_ISSUE_TRACK_KIND);
  t = p.mesh_track;
  t[1] = 3;
  CHECK(with_track(t) == FVV_ISSUE_TRACK_PAYLOAD);
  t[1] = 0; // times of a mesh track are frames
  CHECK(with_track(t) == FVV_ISSUE_TRACK_FRAMES);
  t = p.mesh_track;
  t[4] = 1; // a time base of 1/0, and then 1/1, which a mesh track may not have
  CHECK(with_track(t) == FVV_ISSUE_TRACK_TIME_BASE);
  t[8] = 1;
  CHECK(with_track(t) == FVV_ISSUE_TRACK_TIME_BASE);
  t[0] = FVV_TRACK_DATA;
  CHECK(with_track(t) == 0);
  t = p.mesh_track;
  t[14] = 1;
  CHECK(with_track(t) == FVV_ISSUE_TRACK_ALTERNATE);
  t[12] = 1;
  CHECK(with_track(t) == 0);
  t = p.mesh_track;
  t.push_back('x');
  CHECK(with_track(t) == FVV_ISSUE_TRACK_PAYLOAD);
  CHECK(with_track({1, 0, 0}) == FVV_ISSUE_TRACK_PAYLOAD);
  t = p.mesh_track;
  t[24] = 0xff;
  CHECK(with_track(t) == FVV_ISSUE_TEXT);
  CHECK(issue_of(join({p.head, hand_chunk("SCEN", 1, 0, 0, 0, p.scene),
                       hand_chunk("TRAK", 1, 1, 1, 0, p.mesh_track),
                       hand_chunk("TRAK", 1, 2, 1, 0, p.mesh_track)})) == FVV_ISSUE_TRACK_ID);
}

namespace {

// A writer whose output counts its bytes.
struct CountingWriter {
  uint64_t bytes = 0;
  fvv_writer *writer = nullptr;
  fvv_diagnostic d = {};

  CountingWriter() {
    const fvv_output output = {count, this};
    REQUIRE(fvv_writer_create(&output, nullptr, &writer, &d) == FVV_OK);
    configure(FVV_CHUNK_SCENE, 0, scene_payload());
  }
  ~CountingWriter() { fvv_writer_destroy(writer); }
  static fvv_status count(void *user, const void *, size_t size) {
    static_cast<CountingWriter *>(user)->bytes += size;
    return FVV_OK;
  }
  void configure(uint32_t type, uint16_t track, const Bytes &payload) {
    REQUIRE(fvv_writer_configuration(writer, type, track, 0, payload.data(), payload.size(), &d) == FVV_OK);
  }
  // The call fails with FVV-7001 and writes nothing.
  template <class Call> void refuses(const Call &call) {
    const uint64_t before = bytes;
    CHECK(call() == FVV_ERROR_LIMIT);
    CHECK(d.issue == FVV_ISSUE_LIMIT);
    CHECK(bytes == before);
  }
};

} // namespace

TEST_CASE("a writer refuses what readers with default limits refuse, before it writes it") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  CountingWriter w;
  for (uint16_t id = 1; id <= limits.max_tracks; id++)
    w.configure(FVV_CHUNK_TRACK, id, track_payload(FVV_TRACK_MESH, ""));
  const Bytes track = track_payload(FVV_TRACK_MESH, "");
  w.refuses([&] {
    return fvv_writer_configuration(w.writer, FVV_CHUNK_TRACK, 300, 0, track.data(), track.size(), &w.d);
  });
  for (uint32_t i = 0; i < limits.max_cameras; i++) w.configure(FVV_CHUNK_CAMERA, 0, Bytes(8));
  const Bytes camera(8), text(size_t(limits.max_text) + 1, ' ');
  w.refuses([&] {
    return fvv_writer_configuration(w.writer, FVV_CHUNK_CAMERA, 0, 0, camera.data(), camera.size(), &w.d);
  });
  w.refuses([&] {
    return fvv_writer_configuration(w.writer, FVV_CHUNK_METADATA, 0, 0, text.data(), text.size(), &w.d);
  });
  // A new block starts its count of cameras at 0.
  w.configure(FVV_CHUNK_SCENE, 0, scene_payload());
  w.configure(FVV_CHUNK_CAMERA, 0, camera);

  REQUIRE(fvv_writer_begin_group(w.writer, 0, 1, &w.d) == FVV_OK);
  const auto chunk = [&](uint32_t number) {
    const uint32_t type = 0x61616161 + (number / 256 << 8) + number % 16 + (number / 16 % 16 << 16);
    return fvv_writer_chunk(w.writer, type, 0, 0, 0, nullptr, 0, &w.d);
  };
  for (uint32_t i = 0; i < 1024; i++) REQUIRE(chunk(i) == FVV_OK);
  w.refuses([&] { return chunk(1024); });
  CHECK(chunk(17) == FVV_OK);
  CHECK(fvv_writer_end_group(w.writer, &w.d) == FVV_OK);
}

TEST_CASE("a writer refuses the group that no reader with default limits would list", "[long][slow]") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  CountingWriter w;
  int64_t group = 0;
  bool good = true;
  for (; group < limits.max_groups && good; group++)
    good = fvv_writer_begin_group(w.writer, group, group + 1, &w.d) == FVV_OK &&
           fvv_writer_end_group(w.writer, &w.d) == FVV_OK;
  REQUIRE(good);
  w.refuses([&] { return fvv_writer_begin_group(w.writer, group, group + 1, &w.d); });
  CHECK(fvv_writer_finish(w.writer, &w.d) == FVV_OK);
}
