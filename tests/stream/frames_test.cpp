// Frames from pushed bytes: the same events for any split of the bytes, whole or damaged, and the same frames
// as by random access.
#include "base/layout.h"
#include "stream/frames.h"
#include "stream_fixture.h"

#include <memory>
#include <random>

namespace {

struct How {
  size_t step = 0; // bytes pushed at a time, 0: all
  bool eager = true, detail = false, join = false;
  std::vector<uint16_t> left_out;
  const fvv_limits *limits = nullptr;
  const fvv_allocator *allocator = nullptr;
};

using Frames = std::unique_ptr<fvv_frames, decltype(&fvv_frames_destroy)>;

Frames frames_of(const How &how) {
  fvv_frames_options options;
  fvv_frames_options_default(&options);
  options.eager = how.eager;
  fvv_frames *frames = nullptr;
  const fvv_status status = fvv_frames_create(&options, how.limits, how.allocator, &frames);
  REQUIRE(status == FVV_OK);
  if (how.detail) fvv_frames_analyse(frames);
  if (how.join) REQUIRE(fvv_frames_join(frames) == FVV_OK);
  REQUIRE(fvv_frames_leave_out(frames, how.left_out.data(), how.left_out.size()) == FVV_OK);
  return Frames(frames, fvv_frames_destroy);
}

// One line for an event, with a digest of all bytes of a frame.
std::string line_of(const fvv_frames *frames, const fvv_frames_event &event) {
  std::ostringstream out;
  out << event.offset << ' ';
  if (event.kind == FVV_FRAMES_READ) {
    out << "read " << fvv_frames_read(frames)->kind << (fvv_frames_begins_time(frames) ? " begins" : "");
    return out.str();
  }
  switch (event.kind) {
  case FVV_FRAMES_CONFIGURATION:
    out << "configuration " << event.configuration->track_count << (event.repeated ? " repeated" : "");
    break;
  case FVV_FRAMES_GROUP:
    out << "group " << event.sequence << ' ' << event.time << '-' << event.end;
    break;
  case FVV_FRAMES_FRAME:
  case FVV_FRAMES_BETWEEN: {
    uint32_t crc = 0;
    for (size_t i = 0; i < event.chunk_count; i++) {
      const fvv_frame_chunk &chunk = event.chunks[i];
      CHECK(chunk.header.time == event.time);
      CHECK(reinterpret_cast<uintptr_t>(chunk.payload) % 8 == 0);
      if (chunk.payload) CHECK(fvv_crc32c(0, chunk.payload, chunk.header.size) == chunk.header.payload_crc);
      crc = fvv_crc32c(crc, &chunk.header.payload_crc, 4);
    }
    out << (event.kind == FVV_FRAMES_FRAME ? "frame " : "between ") << event.time << ' ' << event.chunk_count
        << ' ' << crc << (event.whole ? "" : " broken");
    break;
  }
  case FVV_FRAMES_GROUP_END:
    out << "group end" << (event.whole ? "" : " broken");
    break;
  case FVV_FRAMES_DAMAGE:
    out << "damage " << event.diagnostic.issue << ' ' << event.skipped << ' ' << event.diagnostic.message
        << (event.whole ? " spared" : "");
    break;
  case FVV_FRAMES_END:
    out << "end";
    break;
  }
  return out.str();
}

// All events that have come, and the status that followed the last one.
fvv_status pull(fvv_frames *frames, std::vector<std::string> &lines) {
  fvv_frames_event event;
  fvv_diagnostic diagnostic = {};
  fvv_status status;
  while ((status = fvv_frames_next(frames, &event, &diagnostic)) == FVV_OK)
    lines.push_back(line_of(frames, event));
  if (status < 0) lines.push_back("error " + std::to_string(status) + ' ' + diagnostic.message);
  return status;
}

std::vector<std::string> events_of(const Bytes &bytes, const How &how = {}) {
  const Frames frames = frames_of(how);
  std::vector<std::string> lines;
  const size_t step = how.step ? how.step : bytes.size() + 1;
  for (size_t at = 0; at < bytes.size(); at += step) {
    const size_t size = std::min(step, bytes.size() - at);
    // In a block of exactly that size, so that a sanitizer sees any over-read.
    const Bytes piece(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + size));
    if (fvv_frames_push(frames.get(), piece.data(), piece.size()) < 0) break;
    if (pull(frames.get(), lines) != FVV_NEED_DATA) return lines;
  }
  fvv_frames_finish(frames.get());
  if (pull(frames.get(), lines) == FVV_END) {
    fvv_frames_event event;
    CHECK(fvv_frames_next(frames.get(), &event, nullptr) == FVV_END);
  }
  return lines;
}

std::vector<std::string> having(const std::vector<std::string> &lines, const std::string &word) {
  std::vector<std::string> out;
  for (const std::string &line : lines)
    if (line.find(' ' + word) != std::string::npos) out.push_back(line.substr(line.find(' ') + 1));
  return out;
}

std::vector<int64_t> times_of(const std::vector<std::string> &lines) {
  std::vector<int64_t> out;
  for (const std::string &line : having(lines, "frame "))
    if (line.find("broken") == std::string::npos) out.push_back(std::stoll(line.substr(6)));
  return out;
}

} // namespace

TEST_CASE("a good stream: its configuration, its groups and every frame once") {
  Stream source = good_stream(2);
  source.repeat = true;
  const auto lines = events_of(write(source));
  CHECK(having(lines, "configuration") ==
        std::vector<std::string>{"configuration 2", "configuration 2 repeated"});
  CHECK(having(lines, "group ") ==
        std::vector<std::string>{"group 0 0-6", "group end", "group 1 6-12", "group end"});
  CHECK(times_of(lines) == std::vector<int64_t>{0, 2, 4, 6, 8, 10});
  CHECK(having(lines, "damage").empty());
  CHECK(having(lines, "end").back() == "end");
}

TEST_CASE("any split of the bytes gives the same events, also of damaged and cut streams") {
  Stream source = good_stream(3);
  source.repeat = true;
  const Bytes good = write(source);
  std::mt19937 random(3);
  std::vector<Bytes> streams = {good, {}};
  for (int i = 0; i < 60; i++) {
    Bytes bytes = good;
    const size_t at = random() % bytes.size();
    if (i % 3 == 0) bytes[at] ^= uint8_t(1 << random() % 8);
    if (i % 3 == 1) bytes.resize(at);
    if (i % 3 == 2)
      bytes.erase(bytes.begin() + std::ptrdiff_t(at),
                  bytes.begin() + std::ptrdiff_t(std::min(bytes.size(), at + 1 + random() % 200)));
    streams.push_back(bytes);
  }
  for (const Bytes &bytes : streams)
    for (const int kind : {0, 1, 2}) {
      How how;
      how.eager = kind == 0;
      how.detail = kind == 2;
      const auto whole = events_of(bytes, how);
      for (const size_t step : {1, 7, 32, 33, 100, 1000}) {
        how.step = step;
        CHECK(events_of(bytes, how) == whole);
      }
    }
}

TEST_CASE("a frame is reported with its last track when eager, and else when it is over") {
  // Frames 0, 6 have both tracks; of the others one is missing, so that they wait in any case.
  const Bytes bytes = write(good_stream(2));
  const std::vector<Place> chunks = chunks_of(bytes);
  for (const bool eager : {true, false}) {
    How how;
    how.eager = eager;
    const Frames frames = frames_of(how);
    std::vector<std::string> lines;
    size_t at = 0, number = 0;
    std::vector<int64_t> after_sample; // times that are reported before the chunk after the first sample
    for (const Place &place : chunks) {
      const size_t end = place.offset + place.extent;
      REQUIRE(fvv_frames_push(frames.get(), bytes.data() + at, end - at) == FVV_OK);
      CHECK(pull(frames.get(), lines) == FVV_NEED_DATA);
      at = end;
      if (place.type == FVV_CHUNK_VIDEO_PACKET && !number++) after_sample = times_of(lines);
    }
    CHECK(after_sample == (eager ? std::vector<int64_t>{0} : std::vector<int64_t>{}));
    CHECK(times_of(lines).size() == 6);
  }
}

TEST_CASE("chunks of the frame that is still arriving can be looked at") {
  const Bytes bytes = write(good_stream(2));
  for (const bool detail : {false, true}) {
    How how;
    how.detail = detail;
    const Frames frames = frames_of(how);
    std::vector<std::string> lines;
    fvv_frame_chunk chunk;
    size_t at = 0, seen = 0;
    for (const Place &place : chunks_of(bytes)) {
      const size_t end = place.offset + place.extent;
      REQUIRE(fvv_frames_push(frames.get(), bytes.data() + at, end - at) == FVV_OK);
      REQUIRE(pull(frames.get(), lines) == FVV_NEED_DATA);
      at = end;
      const bool found = fvv_frames_peek(frames.get(), FVV_CHUNK_MESH, &chunk);
      if (place.type == FVV_CHUNK_GROUP) CHECK(!found);
      if (place.type != FVV_CHUNK_MESH || !found) continue;
      seen++;
      CHECK(chunk.offset == place.offset);
      CHECK((chunk.payload == nullptr) == detail);
      if (chunk.payload) CHECK(fvv_crc32c(0, chunk.payload, chunk.header.size) == chunk.header.payload_crc);
      CHECK(!fvv_frames_peek(frames.get(), FVV_CHUNK_CALIBRATION, &chunk));
    }
    CHECK(seen > 0);
  }
}

TEST_CASE("after damage the rest of the group is left out, and the next group continues") {
  const Bytes good = write(good_stream(3));
  const std::vector<Place> chunks = chunks_of(good);
  const auto time_of = [&](const Place &place) {
    int64_t time;
    std::memcpy(&time, good.data() + place.offset + FVV_CHUNK_HEADER_TIME, sizeof time);
    return time;
  };
  const auto of_frame = [](const Place &place) {
    return place.type == FVV_CHUNK_MESH || place.type == FVV_CHUNK_VIDEO_PACKET;
  };
  for (const Place &damaged : chunks) {
    if (!of_frame(damaged)) continue;
    // Of its group the frames that are over before it, of the others all. A frame that waits for the next
    // chunk, which is the damaged one, is over if the header of that is intact; that at the group's start has
    // both tracks.
    std::vector<int64_t> eager, late, with_header;
    const int64_t lost = time_of(damaged);
    for (int64_t t = 0; t < 18; t += 2) {
      const bool other = t / 6 != lost / 6;
      if (other || t + 2 < lost) late.push_back(t);
      if (other || t + 2 < lost || (t < lost && t % 6 == 0)) eager.push_back(t);
      if (other || t < lost) with_header.push_back(t);
    }
    for (const size_t byte : {size_t(9), damaged.extent - 9}) { // of the header, of the payload
      Bytes bytes = good;
      bytes[damaged.offset + byte] ^= 4;
      const auto lines = events_of(bytes);
      CHECK(times_of(lines) == (byte == 9 ? eager : with_header));
      REQUIRE(!having(lines, "damage").empty());
      CHECK(having(lines, "group end broken").size() == 1);
      How detail;
      detail.detail = true;
      detail.eager = false;
      CHECK(times_of(events_of(bytes, detail)) == late);
    }
  }
}

namespace {

// Two rungs of meshes and pictures with their visibility, colours, sound and an environment: 3 groups of 3
// frames.
enum : uint16_t { mesh = 1, video = 2, low_mesh = 3, low_video = 4, seen = 5, sound = 6, around = 7 };

Chunk sound_config_chunk(uint16_t track) {
  static const uint8_t head[] = {'O', 'p', 'u',  's',  'H', 'e', 'a', 'd', 1, 1,
                                 0,   0,   0x80, 0xbb, 0,   0,   0,   0,   0};
  fvv_audio_config config = {};
  config.codec = FVV_CODEC_OPUS;
  config.channels = 1;
  config.packet_duration = 960;
  config.record = head;
  config.record_size = sizeof head;
  return {FVV_CHUNK_AUDIO_CONFIG, track, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_audio_config_encode(&config, out, n, size, nullptr);
          })};
}

Stream ladder_stream() {
  Stream out = good_stream(0);
  const auto tracks = out.configuration.begin() + 3;
  out.configuration.insert(
      tracks, {track_chunk(low_mesh, FVV_TRACK_MESH), track_chunk(low_video, FVV_TRACK_VIDEO),
               track_chunk(seen, FVV_TRACK_VISIBILITY), track_chunk(sound, FVV_TRACK_AUDIO, {1, 48000}),
               track_chunk(around, FVV_TRACK_ENVIRONMENT)});
  out.configuration.insert(
      out.configuration.end() - 1,
      {video_chunk(low_video), tiles_chunk(low_video, two_tiles), sound_config_chunk(sound)});
  for (int g = 0; g < 3; g++) {
    Group group = {6 * g, 6 * g + 6, {}};
    for (int f = 0; f < 3; f++) {
      const int64_t time = 6 * g + 2 * f;
      group.chunks.push_back(mesh_chunk(time, f, mesh));
      group.chunks.push_back(mesh_chunk(time, f, low_mesh));
      group.chunks.push_back(sample_chunk(time, f, video));
      group.chunks.push_back(sample_chunk(time, f, low_video));
      // Payloads of these are not read here.
      group.chunks.push_back({FVV_CHUNK_VISIBILITY, seen, FVV_FLAG_KEY, time, Bytes(20, uint8_t(f))});
      if (f == 1) group.chunks.push_back({FVV_CHUNK_ENVIRONMENT, around, FVV_FLAG_KEY, time, Bytes(12, 7)});
      group.chunks.push_back({FVV_CHUNK_AUDIO, sound, FVV_FLAG_KEY, time, Bytes(9, uint8_t(f))});
      group.chunks.push_back({FVV_CHUNK_AUDIO, sound, FVV_FLAG_KEY, time + 1, Bytes(9, uint8_t(f))});
    }
    out.groups.push_back(group);
  }
  return out;
}

uint16_t track_of(const Bytes &stream, const Place &place) {
  return uint16_t(stream[place.offset + FVV_CHUNK_HEADER_TRACK] |
                  stream[place.offset + FVV_CHUNK_HEADER_TRACK + 1] << 8);
}
int64_t time_of(const Bytes &stream, const Place &place) {
  int64_t time;
  std::memcpy(&time, stream.data() + place.offset + FVV_CHUNK_HEADER_TIME, sizeof time);
  return time;
}

bool is_of_group(const Place &place) {
  for (const uint32_t type :
       {FVV_CHUNK_MESH, FVV_CHUNK_VIDEO_PACKET, FVV_CHUNK_VISIBILITY, FVV_CHUNK_ENVIRONMENT, FVV_CHUNK_AUDIO})
    if (place.type == type) return true;
  return false;
}

const std::vector<int64_t> all_times = {0, 2, 4, 6, 8, 10, 12, 14, 16};

} // namespace

TEST_CASE("tracks that are left out are in no frame, and frames keep their number") {
  const Bytes good = write(ladder_stream());
  for (const bool eager : {true, false}) {
    How how;
    how.eager = eager;
    how.left_out = {low_mesh, low_video, around};
    const auto lines = events_of(good, how);
    CHECK(times_of(lines) == all_times);
    const size_t chunks = eager ? 3 : 4; // sound may come after the frame
    for (const std::string &line : having(lines, "frame "))
      CHECK(line.find(' ' + std::to_string(chunks) + ' ') != std::string::npos);
    how.left_out = {mesh, video, low_mesh, low_video, seen, sound, around};
    const auto none = events_of(good, how);
    CHECK(times_of(none) == all_times);
    CHECK(having(none, "between").empty());
    CHECK(having(none, "damage").empty());
    CHECK(having(none, "group end") == std::vector<std::string>(3, "group end"));
  }
}

TEST_CASE("a damaged payload costs the frames that need its track, and no others") {
  const Bytes good = write(ladder_stream());
  size_t spared = 0, needed = 0;
  for (const Place &place : chunks_of(good)) {
    const uint16_t track = track_of(good, place);
    const int64_t time = time_of(good, place);
    if (!is_of_group(place)) continue;
    INFO("track " << track << " at " << time);
    Bytes bad = good;
    bad[place.offset + FVV_CHUNK_HEADER_SIZE + 3] ^= 4;
    for (const bool eager : {true, false}) {
      How how;
      how.eager = eager;
      how.left_out = {low_mesh, low_video};
      const auto lines = events_of(bad, how);
      REQUIRE(having(lines, "damage").size() == 1);
      const bool is_needed = track == mesh || track == video || track == seen;
      std::vector<int64_t> expected;
      for (const int64_t t : all_times)
        if (!is_needed || t < time || t >= time / 6 * 6 + 6) expected.push_back(t);
      CHECK(times_of(lines) == expected);
      CHECK((having(lines, "damage")[0].find("spared") == std::string::npos) == is_needed);
      CHECK(having(lines, "group end broken").size() == is_needed);
      (is_needed ? needed : spared)++;
      // Frames are those of the undamaged stream; of sound and environment what follows in the group is lost.
      const auto undamaged = having(events_of(good, how), "frame ");
      for (const std::string &line : having(lines, "frame "))
        if (track != sound && track != around)
          CHECK(std::count(undamaged.begin(), undamaged.end(), line) == 1);
      for (const size_t step : {1, 33}) {
        how.step = step;
        CHECK(events_of(bad, how) == lines);
      }
    }
    // All tracks are used.
    const auto lines = events_of(bad);
    CHECK(having(lines, "group end broken").size() == (track != sound && track != around));
  }
  CHECK((needed == 54 && spared == 78));
}

TEST_CASE("bytes that are lost, or a header, cost the rest of the group, whatever is left out") {
  const Bytes good = write(ladder_stream());
  How how;
  how.left_out = {low_mesh, low_video};
  size_t tried = 0;
  for (const Place &place : chunks_of(good)) {
    const uint16_t track = track_of(good, place);
    const int64_t time = time_of(good, place);
    if (!is_of_group(place) || (track != low_mesh && track != low_video)) continue;
    const auto at = std::ptrdiff_t(place.offset), end = at + std::ptrdiff_t(place.extent);
    Bytes header = good, removed = good, twice = good;
    header[place.offset + 9] ^= 4;
    removed.erase(removed.begin() + at, removed.begin() + end);
    twice.insert(twice.begin() + at, good.begin() + at, good.begin() + end);
    for (const Bytes &bad : {header, removed, twice}) {
      const auto lines = events_of(bad, how);
      for (const int64_t t : times_of(lines)) CHECK((t <= time || t >= time / 6 * 6 + 6));
      CHECK(having(lines, "group end broken").size() == 1);
    }
    tried++;
  }
  CHECK(tried == 18);
}

TEST_CASE("a loss after damage that was said to cost nothing is reported") {
  const Bytes good = write(ladder_stream());
  const std::vector<Place> chunks = chunks_of(good);
  How how;
  how.left_out = {low_mesh, low_video};
  size_t tried = 0;
  for (size_t i = 0; i < chunks.size(); i++) {
    if (!is_of_group(chunks[i]) || track_of(good, chunks[i]) != low_mesh) continue;
    const Place &other = chunks[i + 2]; // a chunk of low_video
    Bytes bad = good;
    bad[chunks[i].offset + FVV_CHUNK_HEADER_SIZE + 3] ^= 4;
    bad.erase(bad.begin() + std::ptrdiff_t(other.offset),
              bad.begin() + std::ptrdiff_t(other.offset + other.extent));
    const auto damage = having(events_of(bad, how), "damage");
    REQUIRE(damage.size() == 3); // the last one is of the footer, which has the size of the file
    CHECK(damage[0].find("spared") != std::string::npos);
    CHECK(damage[1].find("damage " + std::to_string(FVV_ISSUE_CONTINUITY)) == 0);
    CHECK(damage[1].find("spared") == std::string::npos);
    CHECK(having(events_of(bad, how), "group end broken").size() == 1);
    for (const size_t step : {1, 33}) {
      How pieces = how;
      pieces.step = step;
      CHECK(events_of(bad, pieces) == events_of(bad, how));
    }
    tried++;
  }
  CHECK(tried == 9);
}

TEST_CASE("damage has its place and the bytes that were passed over") {
  const Bytes good = write(good_stream(2));
  const Place place = chunks_of(good)[10]; // in the first group
  Bytes bytes = good;
  bytes.erase(bytes.begin() + std::ptrdiff_t(place.offset), bytes.begin() + std::ptrdiff_t(place.offset + 8));
  const Frames frames = frames_of({});
  REQUIRE(fvv_frames_push(frames.get(), bytes.data(), bytes.size()) == FVV_OK);
  fvv_frames_finish(frames.get());
  fvv_frames_event event;
  fvv_diagnostic diagnostic;
  bool found = false;
  while (fvv_frames_next(frames.get(), &event, &diagnostic) == FVV_OK)
    if (event.kind == FVV_FRAMES_DAMAGE && !found) {
      found = true;
      CHECK(event.offset == place.offset);
      CHECK(event.skipped == place.extent - 8);
      CHECK(event.diagnostic.status < 0);
    }
  CHECK(found);
}

TEST_CASE("a wrong configuration is damage, and frames wait for a good one") {
  Stream source = good_stream(2);
  source.repeat = true;
  Stream wrong = source;
  wrong.configuration.erase(wrong.configuration.begin() + 5); // VCFG: a video track without its configuration
  const auto lines = events_of(write(wrong));
  CHECK(having(lines, "configuration").empty());
  CHECK(having(lines, "damage").size() == 2);
  CHECK(times_of(lines).empty());
  CHECK(having(lines, "group end").size() == 2);
  // At the end of what has come a block may only lack what was not sent yet.
  const Bytes bytes = write(wrong);
  const std::vector<Place> chunks = chunks_of(bytes);
  const auto cut = events_of({bytes.begin(), bytes.begin() + std::ptrdiff_t(chunks[6].offset)});
  CHECK(having(cut, "configuration").empty());
  CHECK(having(cut, "damage").empty());
}

TEST_CASE("a stream that ends with its configuration reports it") {
  const Bytes bytes = write(good_stream(1));
  const std::vector<Place> chunks = chunks_of(bytes);
  const auto lines = events_of({bytes.begin(), bytes.begin() + std::ptrdiff_t(chunks[8].offset)});
  CHECK(having(lines, "configuration") == std::vector<std::string>{"configuration 2"});
}

TEST_CASE("after a seek frames continue with the configuration that is known or given") {
  const Bytes bytes = write(good_stream(3));
  std::vector<uint64_t> groups;
  for (const Place &place : chunks_of(bytes))
    if (place.type == FVV_CHUNK_GROUP) groups.push_back(place.offset);
  const auto play = [&](fvv_frames *frames, uint64_t offset) {
    std::vector<std::string> lines;
    REQUIRE(fvv_frames_push(frames, bytes.data() + offset, bytes.size() - size_t(offset)) == FVV_OK);
    fvv_frames_finish(frames);
    CHECK(pull(frames, lines) == FVV_END);
    return times_of(lines);
  };
  const Frames frames = frames_of({});
  CHECK(play(frames.get(), 0).size() == 9);
  REQUIRE(fvv_frames_seek(frames.get(), groups[2], fvv_frames_configuration(frames.get())) == FVV_OK);
  CHECK(play(frames.get(), groups[2]) == std::vector<int64_t>{12, 14, 16});
  REQUIRE(fvv_frames_seek(frames.get(), groups[1], fvv_frames_configuration(frames.get())) == FVV_OK);
  CHECK(play(frames.get(), groups[1]) == std::vector<int64_t>{6, 8, 10, 12, 14, 16});

  Opened file(bytes);
  const fvv_configuration *configuration;
  REQUIRE(fvv_stream_configuration(file.stream, 1, &configuration, nullptr) == FVV_OK);
  const Frames fresh = frames_of({});
  CHECK(!fvv_frames_configuration(fresh.get()));
  REQUIRE(fvv_frames_seek(fresh.get(), groups[1], configuration) == FVV_OK);
  CHECK(fvv_frames_configuration(fresh.get()) == configuration);
  CHECK(play(fresh.get(), groups[1]) == std::vector<int64_t>{6, 8, 10, 12, 14, 16});
  // Without any no frame is known to be whole.
  const Frames none = frames_of({});
  REQUIRE(fvv_frames_seek(none.get(), groups[1], nullptr) == FVV_OK);
  CHECK(play(none.get(), groups[1]).empty());
}

TEST_CASE("a stream that is joined late begins with any group") {
  const Bytes bytes = write(good_stream(3));
  const std::vector<Place> chunks = chunks_of(bytes);
  std::vector<size_t> groups;
  for (const Place &place : chunks)
    if (place.type == FVV_CHUNK_GROUP) groups.push_back(place.offset);
  Bytes late(bytes.begin(), bytes.begin() + std::ptrdiff_t(groups[0]));
  late.insert(late.end(), bytes.begin() + std::ptrdiff_t(groups[1]), bytes.end());
  How how;
  how.join = true;
  const auto lines = events_of(late, how);
  CHECK(times_of(lines) == std::vector<int64_t>{6, 8, 10, 12, 14, 16});
  CHECK(having(lines, "damage").empty());
}

TEST_CASE("a group that is dropped ends, and the next one is whole") {
  const Bytes bytes = write(good_stream(2));
  const Frames frames = frames_of({});
  REQUIRE(fvv_frames_push(frames.get(), bytes.data(), bytes.size()) == FVV_OK);
  fvv_frames_finish(frames.get());
  std::vector<int64_t> times;
  fvv_frames_event event;
  while (fvv_frames_next(frames.get(), &event, nullptr) == FVV_OK)
    if (event.kind == FVV_FRAMES_FRAME) {
      times.push_back(event.time);
      if (event.time == 0) fvv_frames_drop_group(frames.get());
    }
  CHECK(times == std::vector<int64_t>{0, 6, 8, 10});
}

TEST_CASE("with detail every event of the reader comes first, without payloads in frames") {
  const Bytes bytes = write(good_stream(1));
  How how;
  how.detail = true;
  const auto lines = events_of(bytes, how);
  // The file header, each chunk, the end.
  CHECK(having(lines, "read").size() == 1 + chunks_of(bytes).size() + 1);
  CHECK(having(lines, "read 2 begins").size() == 3);
  const Frames frames = frames_of(how);
  REQUIRE(fvv_frames_push(frames.get(), bytes.data(), bytes.size()) == FVV_OK);
  fvv_frames_event event;
  while (fvv_frames_next(frames.get(), &event, nullptr) == FVV_OK) {
    if (event.kind != FVV_FRAMES_FRAME) continue;
    CHECK(event.whole);
    for (size_t i = 0; i < event.chunk_count; i++) CHECK(!event.chunks[i].payload);
  }
}

TEST_CASE("errors are final and repeat") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_cameras = 1;
  How how;
  how.limits = &limits;
  // Beyond a limit the block is wrong; what is no fvv stream is an error of the reader.
  CHECK(having(events_of(write(good_stream(1)), how), "configuration").empty());
  const Frames frames = frames_of({});
  const Bytes nonsense(100, 0x42);
  REQUIRE(fvv_frames_push(frames.get(), nonsense.data(), nonsense.size()) == FVV_OK);
  fvv_frames_event event;
  fvv_diagnostic first = {}, second = {};
  const fvv_status status = fvv_frames_next(frames.get(), &event, &first);
  CHECK(status == FVV_ERROR_INVALID);
  CHECK(fvv_frames_next(frames.get(), &event, &second) == status);
  CHECK(std::string(first.message) == second.message);
}

TEST_CASE("frames without memory are an error and leak nothing") {
  const Bytes bytes = write(good_stream(2));
  for (int64_t n = 0;; n++) {
    fvv_status status = FVV_OK;
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      fvv_frames *frames = nullptr;
      status = fvv_frames_create(nullptr, nullptr, allocator, &frames);
      if (status == FVV_OK) status = fvv_frames_push(frames, bytes.data(), bytes.size());
      if (status == FVV_OK) fvv_frames_finish(frames);
      fvv_frames_event event;
      while (status == FVV_OK) status = fvv_frames_next(frames, &event, nullptr);
      fvv_frames_destroy(frames);
    });
    if (status == FVV_END) break;
    CHECK(status == FVV_ERROR_MEMORY);
    REQUIRE(n < 2000);
  }
}
