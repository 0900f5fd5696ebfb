// Sound and alternatives (clauses 5.2 and 20): records, times, and how streams and checker count what is no
// frame.
#include "fvv/frames.h"
#include "stream_fixture.h"

#include <algorithm>
#include <functional>
#include <memory>

namespace {

constexpr uint16_t sound = 7;

// As WebCodecs takes it: mono, 312 samples of delay.
const Bytes opus_head = {'O', 'p', 'u', 's', 'H', 'e', 'a', 'd', 1, 1, 0x38, 1, 0x80, 0xbb, 0, 0, 0, 0, 0};
const Bytes stereo_aac_44100 = {0x12, 0x10};

fvv_audio_config opus() {
  fvv_audio_config out = {};
  out.codec = FVV_CODEC_OPUS;
  out.channels = 1;
  out.packet_duration = 960;
  out.preroll = 4;
  out.record = opus_head.data();
  out.record_size = opus_head.size();
  out.language = "en";
  out.language_size = 2;
  return out;
}

Bytes payload_of(const fvv_audio_config &config) {
  return record([&](uint8_t *out, size_t n, size_t *size) {
    return fvv_audio_config_encode(&config, out, n, size, nullptr);
  });
}

// The issue of reading a configuration.
uint32_t issue_of(const Bytes &payload) {
  fvv_audio_config config;
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_audio_config_decode(&config, payload.data(), payload.size(), nullptr, &diagnostic);
  CHECK((status == FVV_OK) == (diagnostic.issue == 0));
  return diagnostic.issue;
}

Bytes packets_of(const fvv_audio_config &config, const fvv_audio_chunk &chunk,
                 const std::vector<Bytes> &data) {
  std::vector<fvv_audio_packet> packets;
  for (const Bytes &one : data) packets.push_back({one.data(), one.size()});
  return record([&](uint8_t *out, size_t n, size_t *size) {
    return fvv_audio_encode(&config, &chunk, packets.data(), out, n, size, nullptr);
  });
}

Chunk audio_track_chunk(uint16_t id, fvv_rational base = {1, 48000}) {
  fvv_track track = {};
  track.id = id;
  track.kind = FVV_TRACK_AUDIO;
  track.time_base = base;
  return {FVV_CHUNK_TRACK, id, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_track_encode(&track, out, n, size, nullptr);
          })};
}

// Two packets of 20 ms from a sample on.
Chunk sound_chunk(int64_t time, int64_t start, bool key, uint32_t preroll = 0) {
  const fvv_audio_chunk chunk = {start, 2 + preroll, preroll, {}};
  const std::vector<Bytes> data(2 + preroll, Bytes{0xf8, 0xff, 0xfe});
  return {FVV_CHUNK_AUDIO, sound, uint8_t(key ? FVV_FLAG_KEY : 0), time, packets_of(opus(), chunk, data)};
}

// good_stream, whose frames are 80 ms apart, with 40 ms of sound at each tick.
Stream with_sound(int groups = 2) {
  Stream out = good_stream(groups);
  out.configuration.insert(out.configuration.begin() + 1, audio_track_chunk(sound));
  out.configuration.push_back({FVV_CHUNK_AUDIO_CONFIG, sound, 0, 0, payload_of(opus())});
  for (Group &group : out.groups) {
    for (int64_t tick = group.start; tick < group.end; tick++) {
      const uint32_t preroll = tick == group.start && tick ? 4 : 0;
      group.chunks.push_back(
          sound_chunk(tick, 1920 * tick - 960 * int64_t(preroll), tick == group.start, preroll));
    }
    std::stable_sort(group.chunks.begin(), group.chunks.end(),
                     [](const Chunk &a, const Chunk &b) { return a.time < b.time; });
  }
  return out;
}

// The issue that the checker finds first; 0: none.
uint32_t problem_of(const Stream &stream) {
  const Checked checked(write(stream));
  return checked.problem_count() ? checked.problem(0).issue : 0;
}

uint32_t problem_with(const std::function<void(Stream &)> &change) {
  Stream stream = with_sound();
  change(stream);
  return problem_of(stream);
}

Chunk *sound_at(Stream &stream, size_t group, int64_t time) {
  for (Chunk &chunk : stream.groups[group].chunks)
    if (chunk.type == FVV_CHUNK_AUDIO && chunk.time == time) return &chunk;
  FAIL("no sound at " << time);
  return nullptr;
}

} // namespace

TEST_CASE("audio configurations are read as they were written") {
  fvv_audio_config config = opus();
  config.flags = FVV_AUDIO_PLACED | FVV_AUDIO_MOVES;
  for (int i = 0; i < 3; i++) config.position[i] = 0.5 * i - 2;
  const Bytes payload = payload_of(config);
  fvv_audio_config read;
  REQUIRE(fvv_audio_config_decode(&read, payload.data(), payload.size(), nullptr, nullptr) == FVV_OK);
  CHECK(read.codec == config.codec);
  CHECK(read.channels == 1);
  CHECK(read.flags == config.flags);
  CHECK(read.packet_duration == 960);
  CHECK(read.preroll == 4);
  CHECK(std::equal(read.position, read.position + 3, config.position));
  CHECK(Bytes(read.record, read.record + read.record_size) == opus_head);
  CHECK(std::string(read.language, read.language_size) == "en");
  CHECK(fvv_audio_sample_rate(&read) == 48000);

  fvv_audio_config aac = config;
  aac.codec = FVV_CODEC_MP4A;
  aac.channels = 2;
  aac.packet_duration = 1024;
  aac.record = stereo_aac_44100.data();
  aac.record_size = stereo_aac_44100.size();
  CHECK(issue_of(payload_of(aac)) == 0);
  CHECK(fvv_audio_sample_rate(&aac) == 44100);
  aac.channels = 1;
  size_t size;
  CHECK(fvv_audio_config_encode(&aac, nullptr, 0, &size, nullptr) == FVV_ERROR_ARGUMENT);
}

TEST_CASE("rules of ACFG") {
  const Bytes good = payload_of(opus());
  const auto with = [&](size_t at, uint8_t value) {
    Bytes bytes = good;
    bytes[at] = value;
    return issue_of(bytes);
  };
  CHECK(issue_of(good) == 0);
  for (size_t size = 0; size < good.size(); size++)
    CHECK(issue_of({good.begin(), good.begin() + std::ptrdiff_t(size)}) == FVV_ISSUE_AUDIO_CONFIG_PAYLOAD);
  CHECK(with(5, 4) == FVV_ISSUE_AUDIO_CONFIG_PAYLOAD);
  CHECK(with(20, 1) == FVV_ISSUE_AUDIO_CONFIG_PAYLOAD);
  CHECK(with(0, 'x') == FVV_ISSUE_AUDIO_CODEC);
  CHECK(with(4, 0) == FVV_ISSUE_AUDIO_CONFIG_RANGE);
  CHECK(with(4, 9) == FVV_ISSUE_AUDIO_CONFIG_RANGE);
  CHECK(with(4, 2) == FVV_ISSUE_AUDIO_RECORD); // the record has one channel
  CHECK(with(5, FVV_AUDIO_MOVES) == FVV_ISSUE_AUDIO_CONFIG_RANGE);
  CHECK(with(31, 0x40) == FVV_ISSUE_AUDIO_CONFIG_RANGE); // a position without its flag
  CHECK(with(12, 0xc1) == FVV_ISSUE_AUDIO_CONFIG_RANGE);
  CHECK(with(13, 0x30) == FVV_ISSUE_AUDIO_CONFIG_RANGE);
  CHECK(with(48, 'o') == FVV_ISSUE_AUDIO_RECORD);
  CHECK(with(56, 2) == 0);                       // a compatible version
  CHECK(with(56, 16) == FVV_ISSUE_AUDIO_RECORD); // and one that is not
  CHECK(with(66, 1) == FVV_ISSUE_AUDIO_RECORD);  // mapping family 1 has a table
  CHECK(with(68, 0xff) == FVV_ISSUE_TEXT);
}

TEST_CASE("packets are read as they were written, and sizes that lie are found") {
  fvv_audio_config config = opus();
  config.flags = FVV_AUDIO_PLACED | FVV_AUDIO_MOVES;
  const fvv_audio_chunk chunk = {-1920, 3, 1, {1, 2, 3}};
  const std::vector<Bytes> data = {{1}, {2, 3}, Bytes(70, 4)};
  const Bytes good = packets_of(config, chunk, data);
  CHECK(good.size() == 16 + 24 + 6 + 73);
  fvv_audio_chunk read;
  std::vector<fvv_audio_packet> packets(good.size() / 3);
  REQUIRE(fvv_audio_decode(&config, good.data(), good.size(), &read, packets.data(), packets.size(),
                           nullptr) == FVV_OK);
  CHECK(read.start == -1920);
  CHECK(read.packet_count == 3);
  CHECK(read.preroll_count == 1);
  CHECK(read.position[1] == 2);
  for (size_t i = 0; i < 3; i++) CHECK(Bytes(packets[i].data, packets[i].data + packets[i].size) == data[i]);
  CHECK(fvv_audio_decode(&config, good.data(), good.size(), &read, packets.data(), 2, nullptr) ==
        FVV_ERROR_BUFFER_TOO_SMALL);

  const auto issue_with = [&](size_t at, uint8_t value) {
    Bytes bytes = good;
    bytes[at] = value;
    fvv_diagnostic diagnostic = {};
    CHECK(fvv_audio_decode(&config, bytes.data(), bytes.size(), &read, packets.data(), packets.size(),
                           &diagnostic) == FVV_ERROR_INVALID);
    return diagnostic.issue;
  };
  CHECK(issue_with(8, 0) == FVV_ISSUE_AUDIO_PAYLOAD);         // no packet
  CHECK(issue_with(11, 0x80) == FVV_ISSUE_AUDIO_PAYLOAD);     // two thousand million packets
  CHECK(issue_with(12, 3) == FVV_ISSUE_AUDIO_PAYLOAD);        // nothing but pre-roll
  CHECK(issue_with(40, 0) == FVV_ISSUE_AUDIO_PAYLOAD);        // an empty packet
  CHECK(issue_with(42, 3) == FVV_ISSUE_AUDIO_PAYLOAD);        // one byte more than there is
  CHECK(issue_with(23, 0xff) == 0 + FVV_ISSUE_AUDIO_PAYLOAD); // no number as position
  Bytes longer = good;                                        // of a later version
  longer.push_back(0);
  CHECK(fvv_audio_decode(&config, longer.data(), longer.size(), &read, packets.data(), packets.size(),
                         nullptr) == FVV_OK);
  for (size_t size = 0; size < good.size(); size++)
    CHECK(fvv_audio_decode(&config, good.data(), size, &read, packets.data(), packets.size(), nullptr) ==
          FVV_ERROR_INVALID);
}

TEST_CASE("times of sound are compared exactly") {
  const fvv_audio_config config = opus();
  const fvv_rational ntsc = {1001, 30000};
  const auto follow = [&](int64_t start, int64_t time, int64_t end, uint32_t preroll = 0) {
    fvv_audio_place place = {};
    const fvv_audio_chunk chunk = {start, 1 + preroll, preroll, {}};
    return fvv_audio_follow(&place, &config, ntsc, &chunk, 1, time, end, nullptr);
  };
  // Tick 30 is at 1.001 s, which is sample 48048.
  CHECK(follow(48048, 30, 31) == FVV_OK);
  CHECK(follow(48047, 30, 31) == FVV_ERROR_INVALID);
  CHECK(follow(48047, 29, 30) == FVV_OK);
  CHECK(follow(48048, 29, 30) == FVV_ERROR_INVALID);
  CHECK(follow(48048 - 960, 30, 31, 1) == FVV_OK);
  CHECK(follow(-48048, -30, -29) == FVV_OK);
  CHECK(follow(-48049, -30, -29) == FVV_ERROR_INVALID);
  // 2^62 ticks are far more samples than fit in 64 bits, and 2^62 samples are fewer ticks.
  const int64_t far = int64_t(1) << 62;
  CHECK(follow(far, far, far + 1) == FVV_ERROR_INVALID);
  CHECK(follow(far, far / 1602, far) == FVV_OK);
  CHECK(follow(INT64_MAX - 100, 0, INT64_MAX) == FVV_ERROR_INVALID);
  CHECK(follow(INT64_MIN, INT64_MIN / 1000, 0) == FVV_OK);
}

TEST_CASE("only the first chunk of sound in a group is a key") {
  const fvv_audio_config config = opus();
  fvv_audio_place place = {};
  const fvv_audio_chunk first = {0, 1, 0, {}}, second = {960, 1, 0, {}};
  CHECK(fvv_audio_follow(&place, &config, {1, 50}, &first, 1, 0, 9, nullptr) == FVV_OK);
  fvv_audio_place other = place;
  CHECK(fvv_audio_follow(&place, &config, {1, 50}, &second, 0, 1, 9, nullptr) == FVV_OK);
  CHECK(fvv_audio_follow(&other, &config, {1, 50}, &second, 1, 1, 9, nullptr) == FVV_ERROR_INVALID);
}

TEST_CASE("sound makes no frames, and no frame waits for it") {
  const Bytes bytes = write(with_sound());
  const Checked checked(bytes);
  CHECK(checked.problem_count() == 0);
  CHECK(checked.summary().frames == 6);
  CHECK(checked.summary().whole_frames == 6);
  Opened opened(bytes);
  REQUIRE(fvv_stream_frame_count(opened.stream) == 6);
  for (size_t i = 0; i < 6; i++) {
    fvv_frame frame;
    REQUIRE(fvv_stream_frame(opened.stream, i, &frame, nullptr) == FVV_OK);
    CHECK(frame.time == 2 * int64_t(i));
  }
  const fvv_configuration *configuration;
  REQUIRE(fvv_stream_configuration(opened.stream, 0, &configuration, nullptr) == FVV_OK);
  REQUIRE(configuration->sound_count == 1);
  CHECK(fvv_configuration_audio(configuration, sound) == &configuration->sounds[0].config);
  CHECK(!fvv_configuration_audio(configuration, 1));

  // All of it arrives, at frames and between them.
  fvv_frames *frames;
  REQUIRE(fvv_frames_create(nullptr, nullptr, nullptr, &frames) == FVV_OK);
  const std::unique_ptr<fvv_frames, void (*)(fvv_frames *)> owner(frames, fvv_frames_destroy);
  REQUIRE(fvv_frames_push(frames, bytes.data(), bytes.size()) == FVV_OK);
  fvv_frames_event event;
  std::vector<int64_t> frame_times, sound_times;
  while (fvv_frames_next(frames, &event, nullptr) == FVV_OK) {
    if (event.kind == FVV_FRAMES_FRAME) frame_times.push_back(event.time);
    if (event.kind != FVV_FRAMES_FRAME && event.kind != FVV_FRAMES_BETWEEN) continue;
    for (size_t i = 0; i < event.chunk_count; i++)
      if (event.chunks[i].header.type == FVV_CHUNK_AUDIO) sound_times.push_back(event.chunks[i].header.time);
  }
  CHECK(frame_times == std::vector<int64_t>{0, 2, 4, 6, 8, 10});
  CHECK(sound_times == std::vector<int64_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
}

TEST_CASE("2205, 4304: audio tracks and their configurations belong together") {
  CHECK(problem_with([](Stream &) {}) == 0);
  CHECK(problem_with([](Stream &s) { s.configuration.pop_back(); }) == FVV_ISSUE_CONFIGURATION_AUDIO);
  CHECK(problem_with([](Stream &s) { s.configuration.push_back(s.configuration.back()); }) ==
        FVV_ISSUE_CONFIGURATION_AUDIO);
  CHECK(problem_with([](Stream &s) { s.configuration.back().track = 1; }) == FVV_ISSUE_CONFIGURATION_AUDIO);
  CHECK(problem_with([](Stream &s) {
          s.configuration[1] = audio_track_chunk(sound, {1, 44100});
        }) == FVV_ISSUE_AUDIO_RECORD);
  CHECK(problem_with([](Stream &s) {
          s.configuration[1] = audio_track_chunk(sound, {0, 0});
        }) == FVV_ISSUE_AUDIO_RECORD);
  // Pictures of a stream whose sound has a codec of later days are good, and the codec is reported.
  CHECK(problem_with([](Stream &s) { s.configuration.back().payload[0] = 'x'; }) == FVV_ISSUE_AUDIO_CODEC);
}

TEST_CASE("4305, 4306: packets of a stream follow one another") {
  const auto at = [](size_t group, int64_t time, const Chunk &chunk) {
    return problem_with([&](Stream &s) { *sound_at(s, group, time) = chunk; });
  };
  CHECK(at(0, 1, sound_chunk(1, 1921, false)) == FVV_ISSUE_AUDIO_TIME);
  CHECK(at(0, 1, sound_chunk(1, 0, false, 2)) == FVV_ISSUE_AUDIO_TIME);
  CHECK(at(1, 6, sound_chunk(6, 6 * 1920 - 960, true)) == FVV_ISSUE_AUDIO_TIME); // begins before its time
  CHECK(at(0, 5, sound_chunk(5, 5 * 1920, false, 0)) == 0);
  CHECK(problem_with([](Stream &s) { sound_at(s, 0, 2)->payload.pop_back(); }) == FVV_ISSUE_AUDIO_PAYLOAD);
  // After a loss in the group its times cannot be compared, and are no problem of their own.
  Bytes bytes = write(with_sound());
  for (const Place &place : chunks_of(bytes))
    if (place.type == FVV_CHUNK_AUDIO) {
      bytes[place.offset + 33] ^= 1;
      break;
    }
  const Checked checked(bytes);
  CHECK(checked.problem_count() == 1);
  CHECK(checked.problem(0).issue == FVV_ISSUE_PAYLOAD_CRC);
}

TEST_CASE("2106: tracks of an alternate group are of one kind and ranked") {
  const auto of = [](uint8_t kind, uint16_t rank) {
    Stream stream = good_stream(1);
    for (uint16_t i = 0; i < 2; i++) {
      fvv_track track = {};
      track.id = uint16_t(20 + i);
      track.kind = i ? kind : uint8_t(FVV_TRACK_MESH);
      track.alternate_group = 3;
      track.rank = i ? rank : 0;
      track.bit_rate = 1000;
      track.size = 4;
      stream.configuration.insert(
          stream.configuration.begin() + 1 + i,
          {FVV_CHUNK_TRACK, track.id, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
             return fvv_track_encode(&track, out, n, size, nullptr);
           })});
    }
    return problem_of(stream);
  };
  CHECK(of(FVV_TRACK_MESH, 1) == 0);
  CHECK(of(FVV_TRACK_MESH, 0) == FVV_ISSUE_TRACK_ALTERNATE);
  CHECK(of(FVV_TRACK_VISIBILITY, 1) == FVV_ISSUE_TRACK_ALTERNATE);
}

TEST_CASE("sound of the vector is that of the decoder that was written from the specification") {
  std::ifstream file(FVV_CASES "/vector_audio_two_sounds/input.fvv", std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  const std::string content = bytes.str();
  const Bytes stream(content.begin(), content.end());
  CHECK(Checked(stream).problem_count() == 0);
  std::ifstream listing(FVV_LISTINGS "/audio_two_sounds.txt");
  std::vector<std::string> expected, found;
  for (std::string line; std::getline(listing, line);)
    if (line.rfind("sound ", 0) == 0) expected.push_back(line.substr(0, line.find(" of ") + 5));
  REQUIRE(expected.size() == 12);

  fvv_frames *frames;
  REQUIRE(fvv_frames_create(nullptr, nullptr, nullptr, &frames) == FVV_OK);
  const std::unique_ptr<fvv_frames, void (*)(fvv_frames *)> owner(frames, fvv_frames_destroy);
  REQUIRE(fvv_frames_push(frames, stream.data(), stream.size()) == FVV_OK);
  fvv_frames_event event;
  while (fvv_frames_next(frames, &event, nullptr) == FVV_OK)
    for (size_t i = 0; i < event.chunk_count; i++) {
      const fvv_frame_chunk &chunk = event.chunks[i];
      if (chunk.header.type != FVV_CHUNK_AUDIO) continue;
      const fvv_audio_config *config =
          fvv_configuration_audio(fvv_frames_configuration(frames), chunk.header.track);
      fvv_audio_chunk read;
      REQUIRE(fvv_audio_decode(config, chunk.payload, size_t(chunk.header.size), &read, nullptr, 0,
                               nullptr) == FVV_ERROR_BUFFER_TOO_SMALL);
      std::ostringstream line;
      line << "sound " << chunk.header.track << " time " << chunk.header.time << " start " << read.start
           << ' ' << read.preroll_count << " of " << read.packet_count;
      found.push_back(line.str());
    }
  CHECK(found == expected);
}
